"""Morph targets on the GPU: the offsets of meshes in use, and per object its weights (lib/morph.glsl)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import MeshAsset
from engine.gpu.types import Buffer, Device
from engine.resources.residency import Residency
from engine.scene.scene import Scene

U4 = NDArray[np.uint32]

#: words before the list of (target, weight)
_HEAD = 5


class MorphRows:
    """`buffer`: offsets, then per object its weights; see the shader. Nothing is uploaded while all weights are 0."""

    def __init__(self, device: Device, residency: Residency) -> None:
        self._device, self._residency = device, residency
        self.buffer: Buffer = device.buffer(16, label="morphs")
        self._offsets: U4 = np.zeros(1, np.uint32)
        #: mesh id -> (where its offsets begin, 1 normals + 2 tangents)
        self._meshes: dict[int, tuple[int, int]] = {}
        self._seen: tuple[object, ...] = ()
        #: the table of objects and their weights, of now; never written over
        self.rows: U4 = np.zeros(0, np.uint32)

    @property
    def offset_words(self) -> int:
        """Words of offsets before `rows`; where they change, rows of before mean nothing any more."""
        return len(self._offsets)

    def put_before(self, rows: U4, objects: int) -> int:
        """Have the rows of the frame before, of as many `objects`, behind those of now; returns how far behind the
        table of now theirs is."""
        shift = len(self.rows)
        moved = rows.copy()
        moved[:objects] += np.where(rows[:objects] > 0, shift, 0).astype(np.uint32)
        both = np.concatenate([self.rows, moved])
        self._write(both, False)
        return shift

    def update(self, scene: Scene, *, everything: bool = False) -> None:
        """Bring both buffers up to date with the weights of now. `everything`: of those that never had one too."""
        morphs = scene.morphs
        wanted = morphs.active | everything
        if not wanted.any():
            return
        seen = (id(scene), morphs.rev, scene.structure_rev, everything)
        if seen == self._seen:
            return
        self._seen = seen
        table = scene.instances
        row = morphs.of_nodes(table.node)
        shown = np.flatnonzero(table.alive & (row >= 0) & np.append(wanted, False)[row])
        grown = self._add_meshes({int(m) for m in table.mesh[shown]})
        start = len(self._offsets)
        data: list[U4] = [np.zeros(len(table), np.uint32)]
        heads: dict[tuple[int, int], int] = {}
        at = start + len(table)
        for instance in shown.tolist():
            key = (int(row[instance]), int(table.mesh[instance]))
            if key not in heads:
                part = slice(int(morphs.first[key[0]]), int(morphs.first[key[0]] + morphs.count[key[0]]))
                head = self._head(key[1], morphs.weights[part])
                heads[key] = at
                data.append(head)
                at += len(head)
            data[0][instance] = heads[key]
        self.rows = np.concatenate(data)
        self._write(self.rows, grown)

    def release(self) -> None:
        self.buffer.release()

    def _write(self, rows: U4, whole: bool) -> None:
        size = self._offsets.nbytes + rows.nbytes
        if self.buffer.size < size:
            self.buffer.release()
            self.buffer = self._device.buffer(size + rows.nbytes, label="morphs")  # lists of weights grow and shrink
            whole = True
        if whole:
            self._offsets[0] = len(self._offsets)
            self.buffer.write(self._offsets)
        self.buffer.write(rows, self._offsets.nbytes)

    def _head(self, mesh: int, weights: NDArray[np.float64]) -> U4:
        first, kinds = self._meshes[mesh]
        info = self._residency.meshes[mesh]
        used = np.flatnonzero(weights[: len(info.asset.morphs)])
        head = np.zeros(_HEAD + 2 * len(used), np.uint32)
        head[:_HEAD] = first, info.place.base_vertex, info.asset.vertex_count, kinds, len(used)
        head[_HEAD::2] = used
        head[_HEAD + 1 :: 2] = weights[used].astype(np.float32).view(np.uint32)
        return head

    def _add_meshes(self, wanted: set[int]) -> bool:
        if wanted <= self._meshes.keys():
            return False
        parts: list[U4] = [np.zeros(1, np.uint32)]
        at = 1
        for mesh in sorted(wanted | self._meshes.keys()):
            asset = self._residency.meshes[mesh].asset
            self._meshes[mesh] = (at, morph_kinds(asset))
            parts.append(offset_block(asset).view(np.uint32))
            at += len(parts[-1])
        self._offsets = np.concatenate(parts)
        return True


def morph_kinds(mesh: MeshAsset) -> int:
    """1 where some target moves normals, plus 2 where some moves tangents."""
    return sum(bit for bit, name in ((1, "normal"), (2, "tangent")) if any(name in m.streams for m in mesh.morphs))


def offset_block(mesh: MeshAsset) -> NDArray[np.float32]:
    """f4: target after target, positions, then normals and tangents where any target has them; absent ones are 0."""
    kinds = morph_kinds(mesh)
    names = ["position", *(name for bit, name in ((1, "normal"), (2, "tangent")) if kinds & bit)]
    none = np.zeros((mesh.vertex_count, 3), np.float32)
    return np.concatenate(
        [np.asarray(target.streams.get(name, none), np.float32).reshape(-1) for target in mesh.morphs for name in names]
    )
