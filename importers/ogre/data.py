"""What an Ogre mesh or skeleton holds, whether it came as binary or as XML. Plain arrays, the source's own spaces."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Indices = NDArray[np.uint32]

#: operation type of a submesh -> importers.geometry.topology's mode
OPERATIONS = {
    1: 0,  # point list
    2: 1,  # line list
    3: 3,  # line strip
    4: 4,  # triangle list
    5: 5,  # triangle strip
    6: 6,  # triangle fan
}


@dataclass(slots=True)
class Geometry:
    """Vertices: position f4[n,3]; normal f4[n,3]; tangent f4[n,4] (w = handedness); uv sets f4[n,2]; color f4[n,4]
    as the file has it (display-referred)."""

    position: Floats
    normal: Floats | None = None
    tangent: Floats | None = None
    uv: dict[int, Floats] = field(default_factory=dict)
    color: Floats | None = None

    @property
    def count(self) -> int:
        return len(self.position)


@dataclass(slots=True)
class Assignments:
    """Rows (vertex u4, bone handle u2, weight f4), in the file's order."""

    vertex: Indices
    bone: NDArray[np.uint16]
    weight: Floats

    @staticmethod
    def none() -> Assignments:
        return Assignments(np.zeros(0, np.uint32), np.zeros(0, np.uint16), np.zeros(0, np.float32))

    def __len__(self) -> int:
        return len(self.vertex)


@dataclass(slots=True)
class SubMesh:
    """`geometry` None: it uses the shared one. `operation`: a key of OPERATIONS. `indices`: as in the file, may be
    empty (then the vertices in order)."""

    material: str
    indices: Indices
    geometry: Geometry | None = None
    operation: int = 4
    assignments: Assignments = field(default_factory=Assignments.none)
    aliases: dict[str, str] = field(default_factory=dict)
    name: str = ""


@dataclass(slots=True)
class Pose:
    """Offsets f4[k,3] (and of normals) of some vertices. `target`: 0 the shared geometry, i + 1 submesh i."""

    name: str
    target: int
    vertices: Indices
    offsets: Floats
    normals: Floats | None = None


@dataclass(slots=True)
class MorphKey:
    """All positions (and normals) of the target at `time`."""

    time: float
    positions: Floats
    normals: Floats | None = None


@dataclass(slots=True)
class PoseKey:
    """Poses (their numbers in the mesh) and how much of each at `time`."""

    time: float
    poses: list[tuple[int, float]]


@dataclass(slots=True)
class VertexTrack:
    """`target` as in Pose; keys of one kind."""

    target: int
    morphs: list[MorphKey] = field(default_factory=list)
    poses: list[PoseKey] = field(default_factory=list)


@dataclass(slots=True)
class VertexAnimation:
    name: str
    length: float
    tracks: list[VertexTrack] = field(default_factory=list)
    base: str = ""


@dataclass(slots=True)
class OgreMesh:
    """A whole mesh. `left_out`: kind of data that was skipped -> how many of it."""

    version: str
    shared: Geometry | None = None
    submeshes: list[SubMesh] = field(default_factory=list)
    assignments: Assignments = field(default_factory=Assignments.none)
    skeleton: str = ""
    poses: list[Pose] = field(default_factory=list)
    animations: list[VertexAnimation] = field(default_factory=list)
    left_out: dict[str, int] = field(default_factory=dict)

    def skip(self, what: str) -> None:
        self.left_out[what] = self.left_out.get(what, 0) + 1


@dataclass(slots=True)
class Bone:
    """A bone's binding pose, relative to its parent (a handle, -1: none). Rotation xyzw."""

    name: str
    handle: int
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    parent: int = -1


@dataclass(slots=True)
class BoneTrack:
    """Keys of one bone, relative to its binding pose: times f4[k], rotation f4[k,4] xyzw, translation and scale
    f4[k,3]."""

    bone: int
    times: Floats
    rotation: Floats
    translation: Floats
    scale: Floats


@dataclass(slots=True)
class SkeletonAnimation:
    name: str
    length: float
    tracks: list[BoneTrack] = field(default_factory=list)
    base: str = ""


@dataclass(slots=True)
class OgreSkeleton:
    """`links`: (name of another skeleton whose animations this one uses, scale of their translations)."""

    version: str
    bones: list[Bone] = field(default_factory=list)
    animations: list[SkeletonAnimation] = field(default_factory=list)
    links: list[tuple[str, float]] = field(default_factory=list)
