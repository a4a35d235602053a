"""MeshAsset: vertex streams, indices, parts and skeleton, in the very layout the GPU takes.

Streams (structure of arrays, one row per vertex, all of length n):

    position  f4[n,3]   mesh space, metres
    normal    i2[n,4]   snorm16 xyz, unit, mesh space; w = 0
    tangent   i2[n,4]   snorm16 xyz, unit; w = handedness, +-32767 (bitangent = w * cross(normal, tangent))
    uv0, uv1  f4[n,2]   origin top-left
    color     u2[n,4]   unorm16, scene-linear rgb, straight alpha
    joints    u2[n,4]   indices into `skeleton`; joints1 the influences 5..8
    weights   u2[n,4]   unorm16, the row (with weights1) sums to 1

`position` and `normal` are always there; a mesh without normals gets flat or smooth ones at import.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

#: stream -> (dtype, components). The order is the order of the vertex attribute locations.
STREAMS: dict[str, tuple[str, int]] = {
    "position": ("<f4", 3),
    "normal": ("<i2", 4),
    "tangent": ("<i2", 4),
    "uv0": ("<f4", 2),
    "uv1": ("<f4", 2),
    "color": ("<u2", 4),
    "joints": ("<u2", 4),
    "weights": ("<u2", 4),
    "joints1": ("<u2", 4),
    "weights1": ("<u2", 4),
}

TOPOLOGIES = ("triangles", "lines", "points")


@dataclass(slots=True)
class Submesh:
    """A run of indices drawn with one material slot. Indices count from the mesh's first vertex."""

    first_index: int
    index_count: int
    material_slot: int = 0
    topology: str = "triangles"
    bounds_min: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bounds_max: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(slots=True)
class Skeleton:
    """Joints in depth-first order. `inverse_bind`: f4[j,4,4], joint space from mesh space. `parents`: -1 for roots."""

    names: list[str]
    parents: NDArray[np.int32]
    inverse_bind: NDArray[np.float32]


@dataclass(slots=True)
class MorphTarget:
    """Offsets added to the base streams position, normal, tangent: f4[n,3] each; absent ones are not there."""

    name: str
    streams: dict[str, NDArray[np.float32]]


@dataclass(slots=True)
class MeshAsset:
    """One mesh: `streams` as above, `indices` u4[m], `submeshes` in draw order."""

    name: str
    streams: dict[str, NDArray[np.generic]]
    indices: NDArray[np.uint32]
    submeshes: list[Submesh]
    skeleton: Skeleton | None = None
    morphs: list[MorphTarget] = field(default_factory=list)
    extras: dict[str, object] = field(default_factory=dict)

    @property
    def vertex_count(self) -> int:
        return len(self.streams["position"])

    @property
    def layout(self) -> tuple[str, ...]:
        """The names of the streams present, in attribute order: the key of the vertex arena it lives in."""
        return tuple(name for name in STREAMS if name in self.streams)
