"""Why a file is no FBX that ufbx takes, where it does not say so itself: a quick look at brackets, quotes and records.

Binary records: Blender's description of the format (2013): end offset, property count and length (u4, from version
7500 u8), name length (u1), name, properties, then nested records up to the end offset.
"""

from __future__ import annotations

import re
import struct

_MAGIC = b"Kaydara FBX Binary  \x00"
#: what the reader allows
DEPTH = 1000
_MOST = 64 << 20
_STRAY = re.compile(rb"[:,]\s*[+-]?(?:nan|inf)\w*", re.IGNORECASE)


def diagnose(data: bytes) -> str:
    """The first fault found, with its place; empty where none is."""
    if data.startswith(_MAGIC):
        return _binary(data[:_MOST])
    return _ascii(data[:_MOST])


def _binary(data: bytes) -> str:
    if len(data) < 27:
        return f"the file ends in its header, after {len(data)} bytes"
    version = struct.unpack_from("<I", data, 23)[0]
    order = "<" if version < 1 << 16 else ">"
    version = struct.unpack_from(f"{order}I", data, 23)[0]
    layout, size = (f"{order}QQQB", 25) if version >= 7500 else (f"{order}IIIB", 13)
    at, ends = 27, [len(data)]
    while True:
        if at + size > len(data):
            return f"the file ends at byte {len(data):,}, within a record that begins at byte {at:,}"
        end, _, length, name = struct.unpack_from(layout, data, at)
        if end == 0:
            ends.pop()
            at += size
            if not ends:
                return ""
            continue
        if not at < end <= len(data):
            return f"the record at byte {at:,} ends at byte {end:,}; the file has {len(data):,}"
        inner = at + size + name + length
        if inner > end:
            return f"the record at byte {at:,} is shorter than its own properties"
        if inner < end:
            ends.append(end)
            if len(ends) > DEPTH:
                return f"records are nested deeper than {DEPTH} at byte {at:,}"
            at = inner
        else:
            at = end
        while len(ends) > 1 and at >= ends[-1]:
            at = ends.pop()


def _ascii(data: bytes) -> str:
    depth, opened = 0, [1]
    for number, line in enumerate(data.split(b"\n"), 1):
        code = line
        if b'"' in line:
            if line.count(b'"') % 2:
                return f"line {number}: a text is not closed by a quote"
            code = re.sub(rb'"[^"]*"', b"", line)
        code = code.partition(b";")[0]
        stray = _STRAY.search(code)
        if stray:
            return f"line {number}: {stray.group()[1:].strip().decode('ascii', 'replace')} is no number"
        for symbol in re.findall(rb"[{}]", code):
            depth += 1 if symbol == b"{" else -1
            if symbol == b"{":
                opened.append(number)
            elif len(opened) > 1:
                opened.pop()
            if depth < 0:
                return f"line {number}: a bracket closes what was never opened"
            if depth > DEPTH:
                return f"line {number}: brackets are nested deeper than {DEPTH}"
    return f"the bracket of line {opened[-1]} is never closed: the file ends too early" if depth else ""
