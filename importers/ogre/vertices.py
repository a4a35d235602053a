"""Vertex declarations: elements of any type in any number of buffers become the columns of a Geometry.

Source: Ogre 1.x and 13 API reference, VertexElementType and VertexElementSemantic (element numbers and layouts).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.core.findings import Findings
from importers.ogre.data import Floats, Geometry

POSITION, BLEND_WEIGHTS, BLEND_INDICES, NORMAL, DIFFUSE, SPECULAR, TEXTURE, BINORMAL, TANGENT = range(1, 10)
SEMANTICS = {
    POSITION: "position", BLEND_WEIGHTS: "blend weights", BLEND_INDICES: "blend indices", NORMAL: "normal",
    DIFFUSE: "diffuse colour", SPECULAR: "specular colour", TEXTURE: "texture coordinates", BINORMAL: "binormal",
    TANGENT: "tangent",
}  # fmt: skip

#: element type -> (scalar dtype, components, divisor that makes it normalised or 0)
_TYPES: dict[int, tuple[str, int, float]] = {
    **{n: ("f4", n + 1, 0) for n in range(4)},
    4: ("u4", 1, 0), 10: ("u4", 1, 0), 11: ("u4", 1, 0),
    **{5 + n: ("i2", n + 1, 0) for n in range(4)},
    9: ("u1", 4, 0),
    **{12 + n: ("f8", n + 1, 0) for n in range(4)},
    **{16 + n: ("u2", n + 1, 0) for n in range(4)},
    **{20 + n: ("i4", n + 1, 0) for n in range(4)},
    **{24 + n: ("u4", n + 1, 0) for n in range(4)},
    28: ("i1", 4, 0), 29: ("i1", 4, 127.0), 30: ("u1", 4, 255.0),
    31: ("i2", 2, 32767.0), 32: ("i2", 4, 32767.0), 33: ("u2", 2, 65535.0), 34: ("u2", 4, 65535.0),
    35: ("u4", 1, 0),
    **{36 + n: ("f2", n + 1, 0) for n in range(4)},
}  # fmt: skip
_COLOUR, _ARGB, _ABGR, _PACKED = 4, 10, 11, 35


@dataclass(frozen=True, slots=True)
class Element:
    """One line of a declaration: which buffer, type, meaning, byte offset in the vertex, number of its kind."""

    source: int
    type: int
    semantic: int
    offset: int
    index: int

    @property
    def size(self) -> int:
        """Bytes, or -1 for a type that is not known."""
        if self.type not in _TYPES:
            return -1
        scalar, components, _ = _TYPES[self.type]
        return np.dtype(scalar).itemsize * components


@dataclass(frozen=True, slots=True)
class Buffer:
    """Vertices of `stride` bytes, `order` '<' or '>'."""

    data: bytes
    stride: int
    order: Literal["<", ">"]


def decode(element: Element, buffer: Buffer, count: int) -> Floats:
    """f4[count,c] of one element; the caller has checked that it lies within the stride and the data."""
    scalar, components, divisor = _TYPES[element.type]
    kind = np.dtype(scalar).newbyteorder(buffer.order)
    raw = np.ndarray(
        (count, components), kind, buffer.data, element.offset, (buffer.stride, kind.itemsize)
    )  # fmt: skip
    if element.type in (_COLOUR, _ARGB, _ABGR):
        return _unpack_colour(raw[:, 0], element.type == _ABGR)
    if element.type == _PACKED:
        return _unpack_10_10_10_2(raw[:, 0])
    if element.type == 30 and element.semantic in (DIFFUSE, SPECULAR):
        return np.asarray(raw / np.float32(255.0), np.float32)
    with np.errstate(over="ignore", invalid="ignore"):
        values: NDArray[Any] = raw.astype(np.float32)
    return np.maximum(values / np.float32(divisor), np.float32(-1)) if divisor else values


def _unpack_colour(packed: NDArray[Any], abgr: bool) -> Floats:
    """f4[n,4] rgba of 32-bit colours: 0xAABBGGRR (OpenGL) or 0xAARRGGBB (Direct3D)."""
    shifts = (0, 8, 16, 24) if abgr else (16, 8, 0, 24)
    parts = [(packed >> np.uint32(shift)) & np.uint32(0xFF) for shift in shifts]
    return np.stack(parts, 1).astype(np.float32) / np.float32(255.0)


def _unpack_10_10_10_2(packed: NDArray[Any]) -> Floats:
    """f4[n,4] of signed 10-10-10-2, x in the lowest bits, each normalised to -1..1."""
    signed = packed.astype(np.int64)
    parts = [((signed >> shift) & 0x3FF) for shift in (0, 10, 20)]
    parts = [np.maximum(np.where(p > 511, p - 1024, p) / 511.0, -1.0) for p in parts]
    w = (signed >> 30) & 3
    parts.append(np.maximum(np.where(w > 1, w - 4, w).astype(np.float64), -1.0))
    return np.stack(parts, 1).astype(np.float32)


def to_geometry(elements: dict[tuple[int, int], tuple[Element, Floats]], findings: Findings, where: str) -> Geometry:
    """Columns by (semantic, index) as a Geometry. Elements that have no place in it are findings.

    Binormals are not kept: normal, tangent and uv say the same."""
    position = elements[POSITION, 0][1]
    geometry = Geometry(_widened(position, 3, 0.0))
    for (semantic, index), (element, values) in sorted(elements.items()):
        if semantic == POSITION and index == 0:
            continue
        if semantic == NORMAL and index == 0 and values.shape[1] >= 3:
            geometry.normal = np.ascontiguousarray(values[:, :3])
        elif semantic == TANGENT and index == 0 and values.shape[1] >= 3:
            geometry.tangent = _widened(values, 4, 1.0)
        elif semantic == DIFFUSE and index == 0 and values.shape[1] >= 3:
            geometry.color = _widened(values, 4, 1.0)
            if element.type == _COLOUR:
                findings.info(
                    "ogre.colour-order", "vertex colours of unspecified byte order are read as ARGB (Direct3D)", where,
                    "if red and blue are swapped, run OgreMeshUpgrader on the file",
                )  # fmt: skip
        elif semantic == TEXTURE and index < 2:
            if values.shape[1] > 2:
                findings.info("ogre.uv", f"uv set {index} has {values.shape[1]} components; two are used", where)
            geometry.uv[index] = _widened(values, 2, 0.0)
        elif semantic != BINORMAL:
            name = SEMANTICS.get(semantic, f"semantic {semantic}")
            findings.info("ogre.vertex-element", f"{name} {index} is not imported", where)
    return geometry


def _widened(values: Floats, width: int, fill: float) -> Floats:
    """The first `width` columns, filled up with `fill`."""
    if values.shape[1] >= width:
        return np.ascontiguousarray(values[:, :width])
    return np.concatenate([values, np.full((len(values), width - values.shape[1]), fill, np.float32)], axis=1)
