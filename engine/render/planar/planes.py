"""MirrorPlanes: the planes that a scene's mirrors lie in, and those of them that count in a view."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import MeshAsset
from engine.math.frustum import planes_from_matrix
from engine.render.planar.camera import side_of
from engine.render.planar.parts import FlatPart, flat_parts
from engine.render.view import View
from engine.resources.residency import Residency
from engine.scene.scene import Scene

F8 = NDArray[np.float64]

FEATURE = "planar_reflection"
#: two parts share a mirror: cosine between their normals; metres apart, of how far they are from each other
SAME_TURN, SAME_PLACE = 0.9999999, 1e-4
#: float32 positions near the camera, relative to how far things are
ROUNDING = 4e-6
#: pixels: what is seen more edge-on than this is left to the environment
LEAST_PIXELS = 0.5


@dataclass(frozen=True, slots=True)
class MirrorPlane:
    """`plane` f8[4], world: (n, w) with n unit on the camera's side. `near`: metres off the plane that still count as
    in it. `rows`: instances that are nothing but a part of it."""

    plane: F8
    near: float
    rows: NDArray[np.intp]


class MirrorPlanes:
    """Of one scene at a time. `count`: flat parts that ask for it, seen or not."""

    def __init__(self, residency: Residency) -> None:
        self._residency = residency
        self._parts: dict[tuple[int, int], tuple[MeshAsset, list[FlatPart]]] = {}
        self._built: tuple[object, ...] = ()
        self._row = np.zeros(0, np.intp)
        self._part: list[FlatPart] = []
        self._both = np.zeros(0, np.bool_)

    @property
    def count(self) -> int:
        return len(self._part)

    def update(self, scene: Scene) -> None:
        """Find the parts again where the structure changed."""
        key = (id(scene), scene.structure_rev, self._residency.structure_rev)
        if key == self._built:
            return
        self._built = key
        table, residency = scene.instances, self._residency
        records = residency.materials.records
        asks = np.array([FEATURE in r.asset.features and FEATURE in r.effect.features for r in records] or [False])
        rows = np.flatnonzero(table.alive & (table.material >= 0) & asks[np.maximum(table.material, 0)])
        if len(rows):
            node = table.node[rows]
            rows = rows[(scene.skins.of_nodes(node) < 0) & (scene.morphs.of_nodes(node) < 0)]
        found = []
        for row in rows.tolist():
            both = "double_sided" in records[int(table.material[row])].asset.features
            found += [(row, part, both) for part in self._parts_of(int(table.mesh[row]), int(table.submesh[row]))]
        self._row = np.array([row for row, _, _ in found], np.intp)
        self._part = [part for _, part, _ in found]
        self._both = np.array([both for _, _, both in found], np.bool_)

    def _parts_of(self, mesh: int, submesh: int) -> list[FlatPart]:
        """Found once for each mesh; again where a file was read again."""
        asset = self._residency.meshes[mesh].asset
        known = self._parts.get((mesh, submesh))
        if known is None or known[0] is not asset:
            known = self._parts[mesh, submesh] = (asset, flat_parts(asset, submesh))
        return known[1]

    @np.errstate(all="ignore")
    def of_view(self, scene: Scene, view: View, most: int) -> list[MirrorPlane]:
        """The planes of what may be seen in this view, the largest in the picture first; `most` of them. What a node
        has flattened, or put where no number is, is none."""
        if not self._part or most < 1:
            return []
        camera = view.camera
        planes, center, radius, area, off, points, frames = self._in_world(scene)
        side = side_of(camera, planes)
        behind = (side < 0.0) & self._both
        planes[behind], side[behind] = -planes[behind], -side[behind]
        away = np.linalg.norm(center - camera.position, axis=1)
        nearest = np.maximum(away - radius, camera.znear)
        if camera.ymag > 0.0:
            thick = side * 2.0 * radius * view.height / (2.0 * camera.ymag)
            angle = np.ones((len(side), 1))
        else:
            thick = side / nearest * view.height / (2.0 * math.tan(camera.yfov / 2.0))
            angle = np.linalg.norm(points - camera.position, axis=2).clip(camera.znear) ** -3.0
        frustum = planes_from_matrix(camera.clip_from_world(view.aspect))
        inside = ((points @ frustum[:, :3].T + frustum[:, 3]) >= 0.0).all(axis=2)
        # how large it is in the picture; what is at its border alone counts a little
        weight = area * side * (angle * (inside + 1e-6)).mean(axis=1)
        touched = np.all(np.any(frames @ frustum[:, :3].T + frustum[:, 3] >= 0.0, axis=1), axis=1)
        seen = scene.instances.drawn[self._row] & (thick > LEAST_PIXELS) & touched
        near = np.maximum(off + 1e-5 * radius, ROUNDING * (away + radius))
        return self._merged(planes, center, weight, near, seen & np.isfinite(weight), most)

    def _in_world(self, scene: Scene) -> tuple[F8, F8, F8, F8, F8, F8, F8]:
        """Planes f8[n,4], centres, radii, areas, metres off the plane, points f8[n,POINTS,3] and frames f8[n,4,3]; NaN
        where a node is flat."""
        world = scene.nodes.world[scene.instances.node[self._row]]
        linear, place = world[:, :, :3], world[:, :, 3]
        parts = self._part
        scale = np.linalg.norm(linear, axis=(1, 2))
        sound = np.abs(np.linalg.det(linear)) > 1e-12 * scale**3
        back = np.linalg.inv(np.where(sound[:, None, None], linear, np.eye(3)))
        local = np.array([part.plane for part in parts])
        planes = np.empty((len(parts), 4))
        planes[:, :3] = np.einsum("nji,nj->ni", back, local[:, :3])
        planes[:, 3] = local[:, 3] - (planes[:, :3] * place).sum(axis=1)
        planes /= np.where(sound, np.linalg.norm(planes[:, :3], axis=1), np.nan)[:, None]
        center = np.einsum("nij,nj->ni", linear, np.array([part.center for part in parts])) + place
        points, frames = (
            np.einsum("nij,npj->npi", linear, np.array(local)) + place[:, None]
            for local in ([part.points for part in parts], [part.frame for part in parts])
        )
        radius = scale * np.array([part.radius for part in parts])
        area = scale**2 / 3.0 * np.array([part.area for part in parts])
        return planes, center, radius, area, scale * np.array([part.off for part in parts]), points, frames

    def _merged(
        self, planes: F8, center: F8, weight: F8, near: F8, seen: NDArray[np.bool_], most: int
    ) -> list[MirrorPlane]:
        """Parts in one plane are one mirror."""
        left = np.flatnonzero(seen)
        groups = []
        while len(left):
            first = left[np.argmax(weight[left])]
            apart = np.abs((center[left] * planes[first, :3]).sum(axis=1) + planes[first, 3])
            far = np.linalg.norm(center[left] - center[first], axis=1)
            same = planes[left, :3] @ planes[first, :3] > SAME_TURN
            same &= apart <= np.maximum(near[first], SAME_PLACE * far)
            same |= left == first
            groups.append((float(weight[left[same]].sum()), int(first), left[same]))
            left = left[~same]
            if len(groups) > 8 * most:  # what is left is smaller than any of these
                break
        groups.sort(key=lambda group: -group[0])
        return [
            MirrorPlane(
                planes[first], float(near[members].max()),
                np.unique(self._row[[k for k in members.tolist() if self._part[k].whole]]).astype(np.intp),
            )
            for _, first, members in groups[:most]
        ]  # fmt: skip
