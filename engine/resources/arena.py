"""MeshArena: all meshes of one vertex layout in one set of vertex streams and one index buffer.

So a draw needs no buffer change, and thousands of meshes draw by one multi-draw-indirect call.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import STREAMS, MeshAsset
from engine.gpu.types import Buffer, Device, VertexAttribute

#: attribute formats of the streams in the shader's eyes; the location is the stream's place in STREAMS
STREAM_FORMATS = {
    "position": "f4x3",
    "normal": "snorm16x4",
    "tangent": "snorm16x4",
    "uv0": "f4x2",
    "uv1": "f4x2",
    "color": "unorm16x4",
    "joints": "u2x4",
    "weights": "unorm16x4",
    "joints1": "u2x4",
    "weights1": "unorm16x4",
}

#: the per-instance attribute that says which object is drawn
OBJECT_ATTRIBUTE = VertexAttribute(location=15, stream="object", format="u4x1", per_instance=True)


@dataclass(frozen=True, slots=True)
class MeshSlice:
    """Where a mesh lies in its arena."""

    base_vertex: int
    first_index: int


class MeshArena:
    """Grows by doubling; on growth everything is uploaded again from the memory-mapped assets."""

    def __init__(self, device: Device, layout: tuple[str, ...]) -> None:
        self.layout = layout
        self.streams: dict[str, Buffer] = {}
        self.indices: Buffer | None = None
        self._device = device
        self._meshes: list[MeshAsset] = []
        self._vertex_capacity = 0
        self._index_capacity = 0
        self._vertex_count = 0
        self._index_count = 0

    @property
    def byte_size(self) -> int:
        per_vertex = sum(_stride(name) for name in self.layout)
        return self._vertex_capacity * per_vertex + self._index_capacity * 4

    def attributes(self, wanted: tuple[str, ...]) -> tuple[VertexAttribute, ...]:
        """The vertex attributes of the streams in `wanted` that this arena has, plus the object id."""
        locations = {name: i for i, name in enumerate(STREAMS)}
        own = [VertexAttribute(locations[n], n, STREAM_FORMATS[n]) for n in self.layout if n in wanted]
        return (*own, OBJECT_ATTRIBUTE)

    def add_many(self, meshes: list[MeshAsset]) -> list[MeshSlice]:
        """Append meshes of this layout and upload them; returns their places."""
        vertices = self._vertex_count + sum(m.vertex_count for m in meshes)
        indices = self._index_count + sum(len(m.indices) for m in meshes)
        if vertices > self._vertex_capacity or indices > self._index_capacity:
            self._grow(vertices, indices)
        return [self._append(mesh) for mesh in meshes]

    def release(self) -> None:
        for buffer in self.streams.values():
            buffer.release()
        if self.indices is not None:
            self.indices.release()
        self.streams, self.indices = {}, None

    def _grow(self, vertices: int, indices: int) -> None:
        meshes, self._meshes = self._meshes, []
        first = not meshes
        self._vertex_capacity = vertices if first else max(vertices, 2 * self._vertex_capacity)
        self._index_capacity = indices if first else max(indices, 2 * self._index_capacity)
        self.release()
        self.streams = {
            name: self._device.buffer(max(4, self._vertex_capacity * _stride(name)), label=f"arena {name}")
            for name in self.layout
        }
        self.indices = self._device.buffer(max(4, self._index_capacity * 4), label="arena indices")
        self._vertex_count = self._index_count = 0
        for mesh in meshes:
            self._append(mesh)

    def _append(self, mesh: MeshAsset) -> MeshSlice:
        assert self.indices is not None
        slice_ = MeshSlice(self._vertex_count, self._index_count)
        for name in self.layout:
            data: NDArray[np.generic] = np.ascontiguousarray(mesh.streams[name])
            self.streams[name].write(data, self._vertex_count * _stride(name))
        if len(mesh.indices):
            self.indices.write(np.ascontiguousarray(mesh.indices), self._index_count * 4)
        self._vertex_count += mesh.vertex_count
        self._index_count += len(mesh.indices)
        self._meshes.append(mesh)
        return slice_


def _stride(stream: str) -> int:
    dtype, components = STREAMS[stream]
    return np.dtype(dtype).itemsize * components
