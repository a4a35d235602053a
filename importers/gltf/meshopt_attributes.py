"""The attribute codec of meshopt compression: rows of bytes from groups of 16 deltas a byte column.

    stream = header | blocks of at most 256 rows | tail (the row before the first one)
    block  = per byte column: 2 bits of mode a group | the groups
    group  = 16 deltas of 0, (1,) 2, 4 or 8 bits; a delta of all ones stands for a whole byte after the group

Version 1 (KHR_meshopt_compression) adds: a control byte a four columns (other widths, all zero, or plain bytes), and
deltas over 2 bytes, or by xor over 4.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import FormatError

Bytes = NDArray[np.uint8]


class Damaged(FormatError):
    """The compressed stream breaks its format."""


def _ones(bits: int) -> NDArray[np.int64]:
    """For each byte value: how many of its fields of `bits` are all ones."""
    value, mask = np.arange(256), (1 << bits) - 1
    return np.asarray(sum(((value >> shift) & mask == mask).astype(np.int64) for shift in range(0, 8, bits)))


def _fields(bits: int) -> Bytes:
    """u1[256, 8 / bits]: the fields of each byte, the most significant first (single bits: the least)."""
    shifts = np.arange(0, 8, bits) if bits == 1 else np.arange(8 - bits, -1, -bits)
    return ((np.arange(256)[:, None] >> shifts) & ((1 << bits) - 1)).astype(np.uint8)


_ONES = {bits: _ones(bits) for bits in (1, 2, 4)}
_FIELDS = {bits: _fields(bits) for bits in (1, 2, 4)}


def attributes(data: bytes, count: int, stride: int) -> Bytes:
    """u1[count, stride]. Raises Damaged."""
    version = data[0] & 15 if data and data[0] & 0xF0 == 0xA0 else -1
    if version not in (0, 1):
        raise Damaged("the stream of attributes does not start with its header byte")
    tail = stride + (stride // 4 if version else 0)
    end = len(data) - max(tail, 24 if version else 32)
    if end < 1:
        raise Damaged(f"{len(data):,} bytes are too few for a stream of attributes")
    baseline = np.frombuffer(data, np.uint8, stride, len(data) - tail)
    channels = data[len(data) - stride // 4 :] if version else bytes(stride // 4)
    deltas = _deltas(data, end, count, stride, version)
    out = np.empty((count, stride), np.uint8)
    for k in range(0, stride, 4):
        out[:, k : k + 4] = _undo(deltas[k : k + 4, :count], channels[k // 4], baseline[k : k + 4])
    return out


def _deltas(data: bytes, end: int, count: int, stride: int, version: int) -> Bytes:
    """u1[stride, count rounded up to 16]: the stored values, still deltas."""
    raw = np.frombuffer(data, np.uint8)
    # how many values of all ones lie before each byte: the size of a group is then a subtraction
    sums = {bits: np.concatenate([[0], np.cumsum(table[raw])]).tolist() for bits, table in _ONES.items()}
    groups: dict[int, tuple[list[int], list[int]]] = {bits: ([], []) for bits in (1, 2, 4, 8)}
    width = -(-count // 16) * 16
    out = np.zeros((stride, width), np.uint8)
    block = min((8192 // stride) & ~15, 256)
    at, limit = 1, end
    for first in range(0, count, block):
        rows = min(block, count - first)
        controls = at
        at += stride // 4 if version else 0
        count_groups = -(-rows // 16)
        for column in range(stride):
            modes: tuple[int, ...] = (0, 2, 4, 8)
            if version:
                control = data[controls + column // 4] >> (column % 4 * 2) & 3 if controls + column // 4 < limit else 0
                if control == 2:
                    continue
                if control == 3:
                    if at + rows > limit:
                        raise Damaged("the stream of attributes ends too early")
                    out[column, first : first + rows] = raw[at : at + rows]
                    at += rows
                    continue
                modes = (1, 2, 4, 8) if control else (0, 1, 2, 4)
            header = at
            at += -(-count_groups // 4)
            place = column * width + first
            for group in range(count_groups):
                if at > limit:
                    raise Damaged("the stream of attributes ends too early")
                bits = modes[data[header + (group >> 2)] >> ((group & 3) * 2) & 3]
                if bits:
                    starts, places = groups[bits]
                    starts.append(at)
                    places.append(place)
                    at += bits * 2
                    if bits != 8:
                        if at > limit:
                            raise Damaged("the stream of attributes ends too early")
                        at += sums[bits][at] - sums[bits][at - bits * 2]
                place += 16
    if at != limit:
        raise Damaged(f"the stream of attributes has {abs(limit - at)} bytes too {'many' if at < limit else 'few'}")
    flat = out.reshape(-1)
    for bits, (starts, places) in groups.items():
        if starts:
            values = _unpack(raw, np.asarray(starts), bits)
            flat[np.asarray(places)[:, None] + np.arange(16)] = values
    return out


def _unpack(raw: Bytes, starts: NDArray[np.int64], bits: int) -> Bytes:
    """u1[n,16]: the values of the groups that start there."""
    packed: Bytes = raw[starts[:, None] + np.arange(bits * 2)]
    if bits == 8:
        return packed
    values = _FIELDS[bits][packed].reshape(len(starts), 16)
    escaped = values == (1 << bits) - 1
    extra = starts[:, None] + bits * 2 + np.cumsum(escaped, axis=1) - 1
    return np.asarray(np.where(escaped, raw[np.minimum(extra, len(raw) - 1)], values), np.uint8)


def _undo(deltas: Bytes, channel: int, baseline: Bytes) -> Bytes:
    """u1[n,4] from four columns of deltas u1[4,n]. `channel`: of bytes (0), of pairs (1), by xor of all four (2)."""
    kind = channel & 3
    rows: NDArray[Any] = np.ascontiguousarray(deltas.T)
    if kind == 2:
        words = rows.view("<u4")[:, 0]
        turn = np.uint32(channel >> 4)
        turned = words >> turn | words << ((np.uint32(32) - turn) & np.uint32(31)) if turn else words
        start = baseline.copy().view("<u4")[0]
        chained = np.bitwise_xor.accumulate(np.concatenate([[start], turned]).astype("<u4"))[1:]
        return np.asarray(chained.view(np.uint8).reshape(-1, 4), np.uint8)
    if kind == 3:
        raise Damaged(f"channel mode {kind} is not known")
    dtype = np.dtype("<u2" if kind else "u1")
    values = rows.view(dtype)
    one = dtype.type(1)
    plain = (values >> one) ^ (dtype.type(0) - (values & one))
    summed = np.cumsum(plain, axis=0, dtype=dtype) + baseline.copy().view(dtype)
    return np.asarray(np.ascontiguousarray(summed.astype(dtype)).view(np.uint8), np.uint8)
