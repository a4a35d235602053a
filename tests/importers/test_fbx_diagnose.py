"""Where a refused FBX file is broken: known faults at known places."""

from __future__ import annotations

import struct

import pytest

from importers.fbx.diagnose import diagnose

MAGIC = b"Kaydara FBX Binary  \x00\x1a\x00"


def _record(start: int, name: bytes, inner: bytes = b"", *, end: int = 0) -> bytes:
    size = 13 + len(name) + len(inner)
    return struct.pack("<IIIB", end or start + size, 0, 0, len(name)) + name + inner


def _file(*records: bytes) -> bytes:
    return MAGIC + struct.pack("<I", 7400) + b"".join(records) + bytes(13)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"; FBX 7.4.0\nA: {\n\tB: 1\n}\n", ""),
        (b'; FBX\nA: {\n\tB: "never closed\n}\n', "line 3: a text is not closed"),
        (b"; FBX\nA: {\n\tB: 1,nan,2\n}\n", "line 3: nan is no number"),
        (b'; FBX\nA: "nan, {" {\n\tB: 1 ; {\n}\n', ""),
        (b"; FBX\nA: {\nB: {\n}\n", "the bracket of line 2 is never closed"),
        (b"; FBX\nA: 1\n}\n", "line 3: a bracket closes"),
        (b"; FBX\nA: " + b"{\n" * 1200, "line 1002: brackets are nested deeper"),
        (_file(_record(27, b"A"), _record(41, b"B")), ""),
        (_file(_record(27, b"A", end=99999)), "the record at byte 27 ends at byte 99,999"),
        (_file(_record(27, b"A"))[:35], "the file ends at byte 35, within a record that begins at byte 27"),
        (MAGIC, "the file ends in its header"),
        (b"", ""),
    ],
)
def test_reason(data: bytes, reason: str) -> None:
    found = diagnose(data)
    assert found.startswith(reason)
    assert bool(found) == bool(reason)
