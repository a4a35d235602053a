"""DDS pixels of more than 8 bits, and signed ones: known answers for each form."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from engine.assets.dds import parse_dds
from engine.core.errors import FormatError


def dds(body: bytes, *, dxgi: int = 0, flags: int = 4, code: bytes = b"DX10", bits: int = 0,
        masks: tuple[int, int, int, int] = (0, 0, 0, 0), size: tuple[int, int] = (2, 1)) -> memoryview:  # fmt: skip
    head = [0] * 31
    head[0:4] = [124, 0x1007, size[1], size[0]]
    head[18:20] = [32, flags]
    head[20:26] = [int.from_bytes(code, "little"), bits, *masks]
    head[26] = 0x1000
    extra = struct.pack("<5I", dxgi, 3, 0, 1, 0) if code == b"DX10" and flags & 4 else b""
    return memoryview(b"DDS " + struct.pack("<31I", *head) + extra + body)


def texels(data: memoryview) -> tuple[str, list[list[float]]]:
    texture = parse_dds(data, "t.dds")
    channels = len(texture.format) - len(texture.format.lstrip("rgba"))
    values = np.frombuffer(texture.levels[0][0], "<f2" if texture.format.endswith("16f") else "<f4")
    return texture.format, values.reshape(-1, channels).tolist()


@pytest.mark.parametrize(
    ("dxgi", "body", "format", "wanted"),
    [
        (11, struct.pack("<8H", 65535, 0, 0, 65535, 0, 65535, 0, 0), "rgba16f", [[1, 0, 0, 1], [0, 1, 0, 0]]),
        (13, struct.pack("<8h", -32768, 32767, 0, 32767, -32767, 0, 0, 0), "rgba16f", [[-1, 1, 0, 1], [-1, 0, 0, 0]]),
        (31, struct.pack("<8b", -128, 127, 0, 127, 0, -127, 0, 0), "rgba16f", [[-1, 1, 0, 1], [0, -1, 0, 0]]),
        (24, struct.pack("<2I", 1023 | 3 << 30, 1023 << 20), "rgba16f", [[1, 0, 0, 1], [0, 0, 1, 0]]),
        (26, struct.pack("<2I", 15 << 6, (14 << 5) << 22), "rgba16f", [[1, 0, 0, 1], [0, 0, 0.5, 1]]),
        (67, struct.pack("<2I", 256 | 16 << 27, 128 << 9 | 16 << 27), "rgba16f", [[1, 0, 0, 1], [0, 0.5, 0, 1]]),
        (35, struct.pack("<4H", 65535, 0, 0, 65535), "rg16f", [[1, 0], [0, 1]]),
        (51, struct.pack("<4b", 127, -127, 0, 127), "rg16f", [[1, -1], [0, 1]]),
        (56, struct.pack("<2H", 65535, 13107), "r32f", [[1.0], [float(np.float32(0.2))]]),
        (6, struct.pack("<6f", 1, 2, 3, 4, 5, 6), "rgba32f", [[1, 2, 3, 1], [4, 5, 6, 1]]),
    ],
)  # fmt: skip
def test_dx10_forms(dxgi: int, body: bytes, format: str, wanted: list[list[float]]) -> None:
    assert texels(dds(body, dxgi=dxgi)) == (format, wanted)
    with pytest.raises(FormatError, match="need"):
        parse_dds(dds(body[:-1], dxgi=dxgi), "t.dds")


@pytest.mark.parametrize(
    ("flags", "code", "bits", "masks", "body", "format", "wanted"),
    [
        (4, struct.pack("<I", 36), 0, (0,) * 4, struct.pack("<4H", 65535, 0, 0, 65535), "rgba16f", [[1, 0, 0, 1]]),
        (4, struct.pack("<I", 110), 0, (0,) * 4, struct.pack("<4h", -32767, 0, 0, 32767), "rgba16f", [[-1, 0, 0, 1]]),
        (0x41, b"", 32, (0x3FF00000, 0xFFC00, 0x3FF, 0xC0000000), struct.pack("<I", 1023 << 20 | 3 << 30), "rgba16f",
         [[1, 0, 0, 1]]),
        (0x40, b"", 32, (0xFFFF, 0xFFFF0000, 0, 0), struct.pack("<2H", 0, 65535), "rgba16f", [[0, 1, 0, 1]]),
        (0x20000, b"", 16, (0xFFFF, 0, 0, 0), struct.pack("<H", 65535), "r32f", [[1]]),
        (0x80000, b"", 16, (0xFF, 0xFF00, 0, 0), struct.pack("<2b", -127, 127), "rg16f", [[-1, 1]]),
        (0x80000, b"", 32, (0xFFFF, 0xFFFF0000, 0, 0), struct.pack("<2h", 32767, -32767), "rg16f", [[1, -1]]),
    ],
)  # fmt: skip
def test_legacy_forms(
    flags: int, code: bytes, bits: int, masks: tuple[int, int, int, int], body: bytes, format: str,
    wanted: list[list[float]],
) -> None:  # fmt: skip
    assert texels(dds(body, flags=flags, code=code, bits=bits, masks=masks, size=(1, 1))) == (format, wanted)


def test_signed_blocks() -> None:
    six = struct.pack("<bb", 127, -127) + bytes([0b10001000, 0b11000110, 0]) + bytes(3)  # picks 0, 1, 2, 3, 4, …
    format, values = texels(dds(six, dxgi=81, size=(4, 4)))
    assert format == "r16f"
    np.testing.assert_allclose([v[0] for v in values[:5]], [1, -1, 5 / 7, 3 / 7, 1 / 7], atol=1e-3)
    four = struct.pack("<bb", -127, 127) + bytes([0b11111110]) + bytes(5)  # picks 6, 7 and then 3
    format, pairs = texels(dds(six + four, dxgi=84, size=(3, 2)))
    assert (format, len(pairs)) == ("rg16f", 6)
    assert [p[1] for p in pairs[:2]] == [-1, 1]
    assert parse_dds(dds(six, code=b"BC4S", size=(4, 4)), "x").format == "r16f"
