"""Rays through triangles, by embree (package embreex): nearest hits and shadow rays, on whole arrays."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError

F8 = NDArray[np.float64]

INSTALL = "pip install 'lucarna[report]'"
#: of the scene's size: how far a ray starts off the surface that it leaves. Embree is float32, places within R are
#: known to about 1e-7 R, and a hit's place is taken from its triangle.
LIFT = 4e-6


def missing() -> str:
    """Empty where rays can be traced, else the reason that they cannot."""
    if importlib.util.find_spec("embreex") is None:
        return f"it needs ray tracing by the package embreex, which is not installed ({INSTALL})"
    return ""


@dataclass(frozen=True, slots=True)
class Hits:
    """For each ray: the triangle (-1: none), its barycentrics (weights of corners 1 and 2), the distance."""

    triangle: NDArray[np.int32]
    u: F8
    v: F8
    distance: F8


class Rays:
    """`corners` f8[n,3,3], world; at least one triangle may be there, or none. Raises LucarnaError without embreex."""

    def __init__(self, corners: F8) -> None:
        if missing():
            raise LucarnaError("ray tracing needs the package embreex", hint=INSTALL)
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self.corners = np.asarray(corners, np.float64)
        count = len(self.corners)
        points = self.corners.reshape(-1, 3)
        low, high = (points.min(axis=0), points.max(axis=0)) if count else (np.zeros(3), np.ones(3))
        #: the middle, which embree's float32 is relative to
        self.origin = (low + high) / 2.0
        #: half of the diagonal, m
        self.radius = max(float(np.linalg.norm(high - low)) / 2.0, 1e-30)
        self._scene = None
        if count:
            local = (points - self.origin).astype(np.float32)
            index = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
            self._scene = EmbreeScene()
            TriangleMesh(self._scene, local, index)

    @property
    def lift(self) -> float:
        """Metres that rays start off the surface they leave."""
        return LIFT * self.radius

    def nearest(self, start: F8, direction: F8, limit: F8 | None = None) -> Hits:
        """The first triangle that each ray meets, no farther than `limit` f8[k] (m; None: anywhere)."""
        count = len(start)
        if self._scene is None or count == 0:
            none = np.full(count, -1, np.int32)
            return Hits(none, np.zeros(count), np.zeros(count), np.full(count, np.inf))
        o, d = self._local(start, direction)
        found = self._scene.run(o, d, output=1)
        triangle = np.asarray(found["primID"], np.int32)
        distance = np.where(triangle >= 0, np.asarray(found["tfar"], np.float64), np.inf)
        if limit is not None:
            triangle = np.where(distance <= limit, triangle, -1).astype(np.int32)
        return Hits(triangle, np.asarray(found["u"], np.float64), np.asarray(found["v"], np.float64), distance)

    def blocked(self, start: F8, direction: F8, limit: F8 | None = None) -> NDArray[np.bool_]:
        """Whether each ray meets anything before `limit` f8[k] (m; None: anywhere)."""
        if self._scene is None or len(start) == 0:
            return np.zeros(len(start), bool)
        o, d = self._local(start, direction)
        far = None if limit is None else np.clip(limit, 0.0, 1e37).astype(np.float32)
        return np.asarray(self._scene.run(o, d, far, query="OCCLUDED") != -1)

    def _local(self, start: F8, direction: F8) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        start = np.broadcast_to(start, direction.shape)
        return (
            np.ascontiguousarray(start - self.origin, np.float32),
            np.ascontiguousarray(direction, np.float32),
        )
