"""A GLB file put together: arrays become accessors in one buffer, equal ones once; the JSON tree at the end.

Source: glTF 2.0 specification (Khronos, 2021), sections 3.6 and 4.
"""

from __future__ import annotations

import hashlib
import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

_COMPONENT = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
_TYPE = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
VERTICES, INDICES = 34962, 34963


class GlbWriter:
    """Collects; `root` is the JSON tree without its buffers, views and accessors."""

    def __init__(self, generator: str) -> None:
        self.root: dict[str, Any] = {"asset": {"version": "2.0", "generator": generator}}
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []
        self._chunks: list[bytes] = []
        self._size = 0
        self._known: dict[tuple[object, ...], int] = {}
        self._extensions: set[str] = set()

    def use(self, extension: str) -> None:
        """Name an extension that the file uses."""
        self._extensions.add(extension)

    def add(self, array: str, entry: dict[str, Any]) -> int:
        """Append `entry` to the top-level array, or find an equal one; returns its index."""
        entries = self.root.setdefault(array, [])
        key = (array, json.dumps(entry, sort_keys=True))
        if key not in self._known:
            self._known[key] = len(entries)
            entries.append(entry)
        return self._known[key]

    def append(self, array: str, entry: dict[str, Any]) -> int:
        """Append `entry` to the top-level array as one of its own."""
        self.root.setdefault(array, []).append(entry)
        return len(self.root[array]) - 1

    def view(self, data: bytes, target: int = 0, stride: int = 0) -> int:
        """A buffer view of these bytes, aligned to 4."""
        key = ("view", hashlib.sha256(data).digest(), target, stride)
        if key not in self._known:
            entry: dict[str, Any] = {"buffer": 0, "byteOffset": self._size, "byteLength": len(data)}
            if stride:
                entry["byteStride"] = stride
            if target:
                entry["target"] = target
            self._known[key] = len(self._views)
            self._views.append(entry)
            self._chunks.append(data + bytes(-len(data) % 4))
            self._size += len(self._chunks[-1])
        return self._known[key]

    def accessor(self, values: NDArray[Any], *, normalized: bool = False, target: int = 0, bounds: bool = False) -> int:
        """An accessor of [n] or [n, c]. Rows of vertices are padded to whole words, as the format asks for."""
        rows = np.ascontiguousarray(values.reshape(len(values), -1))
        size, kind = rows.shape[1] * rows.dtype.itemsize, rows.dtype.str[1:]
        stored = rows.astype(rows.dtype.newbyteorder("<"), copy=False).view(np.uint8).reshape(len(rows), size)
        stride = 0
        if target == VERTICES and size % 4:
            stride = size + -size % 4
            stored = np.pad(stored, ((0, 0), (0, stride - size)))
        entry: dict[str, Any] = {
            "bufferView": self.view(stored.tobytes(), target, stride), "componentType": _COMPONENT[kind],
            "count": len(rows), "type": _TYPE[rows.shape[1]],
        }  # fmt: skip
        if normalized:
            entry["normalized"] = True
        if bounds:
            entry["min"], entry["max"] = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
        key = ("accessor", json.dumps(entry, sort_keys=True))
        if key not in self._known:
            self._known[key] = len(self._accessors)
            self._accessors.append(entry)
        return self._known[key]

    def bytes(self) -> bytes:
        """The file; the same content gives the same bytes."""
        root = dict(self.root)
        if self._extensions:
            root["extensionsUsed"] = sorted(self._extensions)
        if self._accessors:
            root["accessors"] = self._accessors
        if self._views:
            root["bufferViews"] = self._views
            root["buffers"] = [{"byteLength": self._size}]
        text = json.dumps(root, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode("utf-8")
        text += b" " * (-len(text) % 4)
        body = struct.pack("<II", len(text), 0x4E4F534A) + text
        if self._size:
            body += struct.pack("<II", self._size, 0x004E4942) + b"".join(self._chunks)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body
