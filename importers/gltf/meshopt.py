"""Decoder of EXT_meshopt_compression and KHR_meshopt_compression: compressed buffer views back to their bytes.

Source: the extensions' specifications, appendix A (bit-stream) and B (filters) (Kapoulkine and St. Pierre, Khronos 2021
and 2025). The codecs are sequential, so Python walks groups of 16 values; all that happens within them is numpy.

    ATTRIBUTES  meshopt_attributes.py: byte deltas in groups of 16, cumulated down the rows
    TRIANGLES   one code byte a triangle, with FIFOs of edges and vertices
    INDICES     zigzag deltas against one of two baselines
    filters     octahedral, quaternion, exponential, colour: meshopt_filters.py
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from importers.gltf.meshopt_attributes import Damaged, attributes
from importers.gltf.meshopt_filters import FILTERS

Bytes = NDArray[np.uint8]

MODES = ("ATTRIBUTES", "TRIANGLES", "INDICES")
_U32 = 0xFFFFFFFF


def decode(data: bytes, count: int, stride: int, mode: str, filter: str = "NONE") -> Bytes:
    """The decompressed bytes u1[count * stride]. Raises Damaged where the stream is no such thing."""
    if mode == "ATTRIBUTES":
        if stride % 4 or not 4 <= stride <= 256:
            raise Damaged(f"a stride of {stride} bytes is not possible; it must be 4 to 256 and divisible by 4")
        rows = attributes(data, count, stride)
        if filter != "NONE":
            name, strides = FILTERS.get(filter, (None, ()))
            if name is None:
                raise Damaged(f"the filter {filter!r} is none of NONE, {', '.join(FILTERS)}")
            if strides and stride not in strides:
                raise Damaged(f"the filter {filter} does not go with a stride of {stride} bytes")
            rows = name(rows)
        return np.ascontiguousarray(rows).reshape(-1)
    if mode not in MODES:
        raise Damaged(f"the mode {mode!r} is none of {', '.join(MODES)}")
    if stride not in (2, 4):
        raise Damaged(f"indices of {stride} bytes are not possible; 2 or 4 are")
    values = _triangles(data, count) if mode == "TRIANGLES" else _indices(data, count)
    return np.asarray(values, np.uint32).astype("<u2" if stride == 2 else "<u4").view(np.uint8)


def _varint(data: bytes, at: int) -> tuple[int, int]:
    """(value, position after it) of an unsigned LEB128 number of at most five bytes."""
    value, shift = 0, 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 127) << shift
        if byte < 128:
            return value & _U32, at
        shift += 7
        if shift > 28:
            raise Damaged("a number has more than five bytes")


def _triangles(data: bytes, count: int) -> list[int]:
    if count % 3:
        raise Damaged(f"{count} indices are no whole number of triangles")
    total = count // 3
    if not data or data[0] & 0xF0 != 0xE0 or data[0] & 15 > 1:
        raise Damaged("the stream of triangles does not start with its header byte")
    if len(data) < 1 + total + 16:
        raise Damaged(f"{len(data):,} bytes are too few for {total:,} triangles")
    # version 0 has no codes for the neighbours of the last index
    fresh_limit = 13 if data[0] & 15 else 15
    codes, table = data[1 : 1 + total], data[-16:]
    at, end = 1 + total, len(data) - 16
    next_index, last = 0, 0
    edges: list[tuple[int, int]] = [(0, 0)] * 16
    vertices: list[int] = [0] * 16
    edge_at = vertex_at = 0
    out: list[int] = []

    def explicit() -> int:
        nonlocal at, last
        value, at = _varint(data, at)
        last = last + (~(value >> 1) if value & 1 else value >> 1) & _U32
        return last

    for code in codes:
        high, low = code >> 4, code & 15
        if high < 15:
            a, b = edges[(edge_at - 1 - high) & 15]
            if low < fresh_limit:
                if low == 0:
                    c = next_index
                    next_index += 1
                else:
                    c = vertices[(vertex_at - 1 - low) & 15]
                push = low == 0
            else:
                if low == 15:
                    c = explicit()
                else:
                    c = last = last + (1 if low == 14 else -1) & _U32
                push = True
            if push:
                vertices[vertex_at] = c
                vertex_at = (vertex_at + 1) & 15
            edges[edge_at] = (c, b)
            edges[(edge_at + 1) & 15] = (a, c)
            edge_at = (edge_at + 2) & 15
        else:
            if low < 14:
                pair, fresh_a = table[low], True
            else:
                if at >= end:
                    raise Damaged("the stream of triangles ends too early")
                pair, fresh_a = data[at], low == 14
                at += 1
                if pair == 0:
                    next_index = 0
            z, w = pair >> 4, pair & 15
            if fresh_a:
                a = next_index
                next_index += 1
            else:
                a = -1
            # The order of reading matters: all `next` ones before the explicit ones, which follow in order a, b, c
            if z == 0:
                b = next_index
                next_index += 1
            else:
                b = vertices[(vertex_at - z) & 15]
            if w == 0:
                c = next_index
                next_index += 1
            else:
                c = vertices[(vertex_at - w) & 15]
            if low >= 14:
                if not fresh_a:
                    a = explicit()
                if z == 15:
                    b = explicit()
                if w == 15:
                    c = explicit()
            vertices[vertex_at] = a
            vertex_at = (vertex_at + 1) & 15
            if z in (0, 15):
                vertices[vertex_at] = b
                vertex_at = (vertex_at + 1) & 15
            if w in (0, 15):
                vertices[vertex_at] = c
                vertex_at = (vertex_at + 1) & 15
            edges[edge_at] = (b, a)
            edges[(edge_at + 1) & 15] = (c, b)
            edges[(edge_at + 2) & 15] = (a, c)
            edge_at = (edge_at + 3) & 15
        out += (a, b, c)
        if at > end:
            raise Damaged("the stream of triangles ends too early")
    if at != end:
        raise Damaged(f"{end - at} bytes follow the last triangle")
    return [value & _U32 for value in out]


def _indices(data: bytes, count: int) -> list[int]:
    if not data or data[0] & 0xF0 != 0xD0 or data[0] & 15 > 1:
        raise Damaged("the stream of indices does not start with its header byte")
    if len(data) < 1 + count + 4:
        raise Damaged(f"{len(data):,} bytes are too few for {count:,} indices")
    last = [0, 0]
    at, end = 1, len(data) - 4
    out: list[Any] = []
    for _ in range(count):
        if at >= end:
            raise Damaged("the stream of indices ends too early")
        value, at = _varint(data, at)
        which = value & 1
        last[which] = last[which] + (~(value >> 2) if value & 2 else value >> 2) & _U32
        out.append(last[which])
    if at != end:
        raise Damaged(f"{end - at} bytes follow the last index")
    return out
