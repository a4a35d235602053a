"""Accessors: typed arrays out of buffer bytes, with every offset, stride and count proven to fit before it is used.

Source: glTF 2.0 specification (Khronos, 2021), section 3.6.2 (accessors, alignment, sparse) and 3.11 (normalised).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.findings import Findings
from importers.gltf.container import Buffers
from importers.gltf.document import Document

Array = NDArray[Any]

#: componentType -> dtype
COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
#: type -> (columns, rows)
TYPES = {
    "SCALAR": (1, 1), "VEC2": (1, 2), "VEC3": (1, 3), "VEC4": (1, 4), "MAT2": (2, 2), "MAT3": (3, 3), "MAT4": (4, 4),
}  # fmt: skip
_MAX_COUNT = 1 << 31
#: extensions of a buffer view whose bytes are compressed (meshopt.py)
COMPRESSED_VIEWS = ("EXT_meshopt_compression", "KHR_meshopt_compression")


class Accessors:
    """Reads accessors by index, each once. Arrays are [count, components]; treat them as read-only."""

    def __init__(self, document: Document, buffers: Buffers, max_bytes: int) -> None:
        self._document = document
        self._buffers = buffers
        self._left = max_bytes
        self._cache: dict[int, Array | None] = {}
        self._unpacked: dict[int, memoryview | None] = {}

    @property
    def findings(self) -> Findings:
        return self._document.findings

    def count(self, index: int) -> int:
        """The count that the accessor claims, unchecked but at least 0."""
        value = self._document.objects("accessors")[index].get("count")
        return value if isinstance(value, int) and value > 0 else 0

    def raw(self, index: int) -> Array | None:
        """The values in their stored type, [count, components]; None (with a finding) where they cannot be had."""
        if index not in self._cache:
            self._cache[index] = self._read(index)
        return self._cache[index]

    def provide(self, index: int, values: Array) -> None:
        """Take `values` [count, components] for the accessor's, whatever its own view says (decoded Draco streams)."""
        if self.charge(values.nbytes, f"accessors[{index}]"):
            self._cache[index] = values

    def floats(self, index: int) -> NDArray[np.float32] | None:
        """The values as float32, normalised integers decoded: c/255, c/65535, max(c/127, -1), max(c/32767, -1)."""
        values = self.raw(index)
        if values is None:
            return None
        if values.dtype.kind == "f":
            return np.asarray(values, np.float32)
        if self._document.objects("accessors")[index].get("normalized") is not True:
            return np.asarray(values, np.float32)
        scale = float(np.iinfo(values.dtype).max)
        return np.asarray(np.maximum(np.asarray(values, np.float32) / np.float32(scale), np.float32(-1.0)))

    def is_normalized(self, index: int) -> bool:
        return self._document.objects("accessors")[index].get("normalized") is True

    def _read(self, index: int) -> Array | None:
        doc, where = self._document, f"accessors[{index}]"
        accessor = doc.objects("accessors")[index]
        component = doc.integer(accessor, "componentType", where)
        dtype_name = COMPONENTS.get(component if component is not None else -1)
        if dtype_name is None:
            known = ", ".join(map(str, COMPONENTS))
            self.findings.error("gltf.value", f"component type {component} is none of {known}", where)
            return None
        kind = doc.text(accessor, "type", where)
        if kind not in TYPES:
            self.findings.error("gltf.value", f"type {kind!r} is none of {', '.join(TYPES)}", where)
            return None
        count = doc.integer(accessor, "count", where)
        if count is None or not 0 < count < _MAX_COUNT:
            self.findings.error("gltf.count", f"the count is {count}; it must be 1 to {_MAX_COUNT - 1:,}", where)
            return None
        dtype = np.dtype(dtype_name)
        columns, rows = TYPES[kind]
        # A matrix column starts on a 4-byte boundary
        column_size = rows * dtype.itemsize if columns == 1 else -(-rows * dtype.itemsize // 4) * 4
        size = column_size * columns
        if not self.charge(count * max(size, rows * columns * 4), where):
            return None
        view = doc.integer(accessor, "bufferView", where)
        values: Array | None
        if view is None:
            values = np.zeros((count, rows * columns), dtype)
        else:
            offset = doc.integer(accessor, "byteOffset", where, 0)
            located = self._locate(view, offset, count, size, dtype.itemsize, f"{where}.bufferView")
            if located is None:
                return None
            strides = (located[1], column_size, dtype.itemsize)
            values = np.ndarray((count, columns, rows), dtype, located[0], 0, strides).reshape(count, rows * columns)
        if "sparse" in accessor:
            values = self._apply_sparse(values, accessor, where)
        return values

    def view_bytes(self, index: int, where: str) -> memoryview | None:
        """All bytes of a buffer view (an image); None (with a finding) where they cannot be had."""
        bounds = self._view_bounds(index, where)
        return None if bounds is None else bounds[0][bounds[1] : bounds[1] + bounds[2]]

    def _view_bounds(self, index: int, where: str) -> tuple[memoryview, int, int, int] | None:
        """(buffer, start, length, stride or 0) of a buffer view, proven to lie inside the buffer."""
        doc = self._document
        if doc.checked_index(index, where, "bufferViews") is None:
            return None
        place = f"bufferViews[{index}]"
        view = doc.objects("bufferViews")[index]
        for name in COMPRESSED_VIEWS:
            packed = doc.extension(view, name, place)
            if packed is not None:
                stride = doc.integer(view, "byteStride", place, 0)
                data = self._unpack(index, packed, f"{place}.extensions.{name}")
                return None if data is None or stride is None or stride < 0 else (data, 0, len(data), stride)
        return self._range(view, place)

    def _unpack(self, index: int, packed: dict[str, Any], place: str) -> memoryview | None:
        """The bytes of a buffer view compressed by meshopt, decoded once."""
        if index in self._unpacked:
            return self._unpacked[index]
        from importers.gltf.meshopt import decode  # few files need it
        from importers.gltf.meshopt_attributes import Damaged

        doc = self._document
        self._unpacked[index] = None
        bounds = self._range(packed, place)
        count, stride = doc.integer(packed, "count", place), doc.integer(packed, "byteStride", place)
        if bounds is None or count is None or stride is None:
            return None
        if not 0 < count < _MAX_COUNT or not 0 < stride <= 256:
            self.findings.error("gltf.meshopt", f"{count:,} elements of {stride} bytes are not possible", place)
            return None
        if not self.charge(2 * count * stride, place):
            return None
        data = bytes(bounds[0][bounds[1] : bounds[1] + bounds[2]])
        mode, kind = doc.text(packed, "mode", place), doc.text(packed, "filter", place, "NONE")
        try:
            self._unpacked[index] = memoryview(decode(data, count, stride, mode, kind).tobytes())
        except (Damaged, IndexError) as error:
            reason = error.message if isinstance(error, Damaged) else "the stream ends too early"
            self.findings.error("gltf.meshopt", f"the compressed data is damaged: {reason}", place, "export it again")
        return self._unpacked[index]

    def _range(self, view: dict[str, Any], place: str) -> tuple[memoryview, int, int, int] | None:
        """(buffer, start, length, stride or 0) that an object with buffer, byteOffset and byteLength names."""
        doc = self._document
        number = doc.index(view, "buffer", place, "buffers")
        start = doc.integer(view, "byteOffset", place, 0)
        length = doc.integer(view, "byteLength", place)
        stride = doc.integer(view, "byteStride", place, 0)
        if number is None or start is None or length is None or stride is None:
            if number is None and "buffer" not in view:
                self.findings.error("gltf.value", "the buffer view names no buffer", place)
            elif length is None:
                self.findings.error("gltf.value", "the buffer view has no byte length", place)
            return None
        buffer = self._buffers.get(number)
        if buffer is None:
            return None
        if start < 0 or length < 1 or stride < 0 or start + length > len(buffer):
            self.findings.error(
                "gltf.view-range",
                f"bytes {start:,} to {start + length:,} lie outside the {len(buffer):,} of buffers[{number}]", place,
                "copy or export the file again",
            )  # fmt: skip
            return None
        return buffer, start, length, stride

    def _locate(
        self, index: int, offset: int | None, count: int, size: int, alignment: int, where: str
    ) -> tuple[memoryview, int] | None:
        """The bytes from the first of `count` elements of `size` bytes on, and the stride; proven to fit the view."""
        bounds = self._view_bounds(index, where)
        if bounds is None or offset is None:
            return None
        buffer, start, length, stride = bounds
        stride = stride or size
        place = where.removesuffix(".bufferView")
        end = offset + (count - 1) * stride + size
        if offset < 0 or end > length:
            self.findings.error(
                "gltf.accessor-range",
                f"{count:,} elements need bytes {offset:,} to {end:,} of bufferViews[{index}], {length:,} long",
                place, "copy or export the file again",
            )  # fmt: skip
            return None
        if stride < size:
            self.findings.error("gltf.stride", f"the stride of {stride} is less than an element's {size} bytes", place)
            return None
        if (start + offset) % alignment or stride % alignment:
            self.findings.warn("gltf.alignment", f"the data is not aligned to {alignment} bytes", place)
        return buffer[start + offset : start + end], stride

    def _apply_sparse(self, base: Array, accessor: dict[str, Any], where: str) -> Array | None:
        doc, place = self._document, f"{where}.sparse"
        sparse = doc.child(accessor, "sparse", where)
        count = doc.integer(sparse, "count", place)
        if count is None or not 0 < count <= len(base):
            self.findings.error("gltf.sparse", f"the sparse count is {count}; it must be 1 to {len(base):,}", place)
            return base
        indices_of = doc.child(sparse, "indices", place)
        values_of = doc.child(sparse, "values", place)
        kind = COMPONENTS.get(doc.integer(indices_of, "componentType", f"{place}.indices") or 0, "")
        if kind not in ("<u1", "<u2", "<u4"):
            self.findings.error("gltf.sparse", "the sparse indices are no unsigned integers", f"{place}.indices")
            return base
        parts: list[Array] = []
        for owner, name, dtype, width in (
            (indices_of, "indices", np.dtype(kind), 1),
            (values_of, "values", base.dtype, base.shape[1]),
        ):
            view = doc.integer(owner, "bufferView", f"{place}.{name}")
            offset = doc.integer(owner, "byteOffset", f"{place}.{name}", 0)
            if view is None:
                self.findings.error("gltf.sparse", "no buffer view is named", f"{place}.{name}")
                return base
            size = dtype.itemsize * width
            located = self._locate(view, offset, count, size, dtype.itemsize, f"{place}.{name}.bufferView")
            if located is None:
                return base
            parts.append(np.ndarray((count, width), dtype, located[0], 0, (located[1], dtype.itemsize)))
        indices, values = parts[0][:, 0].astype(np.int64), parts[1]
        inside = indices < len(base)
        if not inside.all():
            self.findings.error(
                "gltf.sparse", f"{int((~inside).sum()):,} sparse indices lie outside 0..{len(base) - 1:,}; left out",
                f"{place}.indices",
            )  # fmt: skip
        result = base.copy()
        result[indices[inside]] = values[inside]
        return result

    def charge(self, size: int, where: str) -> bool:
        """Take `size` bytes from the budget of decoded data; False (with a finding) where it is used up."""
        if size > self._left:
            self.findings.error(
                "gltf.too-large", f"needs {size:,} bytes decoded; {self._left:,} are left of the limit", where,
                "split the file, or repair the count",
            )  # fmt: skip
            return False
        self._left -= size
        return True
