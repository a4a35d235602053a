"""DDS: every format round trip, old headers, real files against Pillow, damaged files."""

from __future__ import annotations

import random
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from engine.assets.dds import DXGI, parse_dds, read_dds, write_dds
from engine.assets.texture import TextureAsset, level_size, mip_extent
from engine.core.errors import FormatError, LucarnaError


def make(format: str, w: int, h: int, *, layers: int = 1, depth: int = 1, mips: int = 0, **more: Any) -> TextureAsset:
    rng = np.random.default_rng(3)
    mips = mips or max(w, h, depth).bit_length()
    levels = [
        [rng.bytes(level_size(format, *(mip_extent(e, m) for e in (w, h, depth)))) for m in range(mips)]
        for _ in range(layers)
    ]
    return TextureAsset(format, w, h, levels, depth, **more)


def content(texture: TextureAsset) -> list[list[bytes]]:
    return [[bytes(image) for image in layer] for layer in texture.levels]


@pytest.mark.parametrize("format", sorted(DXGI))
@pytest.mark.parametrize(
    ("w", "h", "layers", "depth", "cube"),
    [(16, 8, 1, 1, False), (1, 1, 1, 1, False), (13, 7, 3, 1, False), (8, 8, 12, 1, True), (8, 4, 1, 5, False)],
)
def test_round_trip(tmp_path: Path, format: str, w: int, h: int, layers: int, depth: int, cube: bool) -> None:
    texture = make(format, w, h, layers=layers, depth=depth, cube=cube, extras={"a": [1.5, {"b": None}]})
    write_dds(tmp_path / "t.dds", texture)
    read = read_dds(tmp_path / "t.dds")
    assert (read.format, read.width, read.height, read.depth, read.cube) == (format, w, h, depth, cube)
    assert content(read) == content(texture)
    assert read.extras == texture.extras
    assert read.name == "t"
    write_dds(tmp_path / "u.dds", read)
    assert (tmp_path / "t.dds").read_bytes() == (tmp_path / "u.dds").read_bytes()


def test_alpha_mode_lives_in_the_header(tmp_path: Path) -> None:
    texture = make("bc3", 4, 4, extras={"alpha_mode": "premultiplied"})
    write_dds(tmp_path / "t.dds", texture)
    raw = (tmp_path / "t.dds").read_bytes()
    assert b"LCRN" not in raw
    assert raw[144] == 2
    assert read_dds(tmp_path / "t.dds").extras == texture.extras


@pytest.mark.parametrize(
    "texture",
    [
        make("bc7", 16, 16, layers=5, cube=True),
        make("rgba8", 4, 8, layers=6, cube=True),
        make("r8", 4, 4, mips=4),
        TextureAsset("bc7", 8, 8, [[b"short"]]),
        TextureAsset("bc2", 4, 4, [[bytes(16)]]),
        TextureAsset("r8", 0, 4, [[b""]]),
        TextureAsset("r8", 4, 4, []),
    ],
)
def test_wrong_textures_are_not_written(tmp_path: Path, texture: TextureAsset) -> None:
    with pytest.raises(FormatError):
        write_dds(tmp_path / "t.dds", texture)
    assert not list(tmp_path.iterdir())


def legacy(
    flags: int, fourcc: bytes, bits: int, masks: tuple[int, ...], w: int, h: int, body: bytes, **f: int
) -> bytes:
    header = [0] * 31
    header[0], header[1], header[2], header[3] = 124, 0x1007, h, w
    header[5], header[6] = f.get("depth", 0), f.get("mips", 0)
    header[18], header[19], header[20], header[21] = 32, flags, int.from_bytes(fourcc, "little"), bits
    header[22:26] = masks
    header[26], header[27] = 0x1000, f.get("caps2", 0)
    return b"DDS " + struct.pack("<31I", *header) + body


NO_MASKS = (0, 0, 0, 0)


@pytest.mark.parametrize(
    ("code", "format"),
    [
        (b"DXT1", "bc1"), (b"DXT5", "bc3"), (b"ATI1", "bc4"), (b"BC4U", "bc4"), (b"ATI2", "bc5"), (b"BC5U", "bc5"),
        (struct.pack("<I", 111), "r16f"), (struct.pack("<I", 112), "rg16f"), (struct.pack("<I", 113), "rgba16f"),
        (struct.pack("<I", 114), "r32f"), (struct.pack("<I", 115), "rg32f"), (struct.pack("<I", 116), "rgba32f"),
    ],
)  # fmt: skip
def test_legacy_codes(code: bytes, format: str) -> None:
    body = bytes(range(64)) * 8
    read = parse_dds(memoryview(legacy(4, code, 0, NO_MASKS, 5, 6, body)), "t.dds")
    assert read.format == format
    assert bytes(read.levels[0][0]) == body[: level_size(format, 5, 6)]


@pytest.mark.parametrize(
    ("flags", "bits", "masks", "texel", "rgba"),
    [
        (0x41, 32, (0xFF0000, 0xFF00, 0xFF, 0xFF000000), b"\x01\x02\x03\x04", (3, 2, 1, 4)),
        (0x40, 32, (0xFF0000, 0xFF00, 0xFF, 0xFF000000), b"\x01\x02\x03\x04", (3, 2, 1, 255)),
        (0x41, 32, (0xFF, 0xFF00, 0xFF0000, 0xFF000000), b"\x01\x02\x03\x04", (1, 2, 3, 4)),
        (0x40, 24, (0xFF0000, 0xFF00, 0xFF, 0), b"\x01\x02\x03", (3, 2, 1, 255)),
        (0x40, 16, (0xF800, 0x7E0, 0x1F, 0), struct.pack("<H", 0xF800 | 32 << 5), (255, 130, 0, 255)),
        (0x41, 16, (0x7C00, 0x3E0, 0x1F, 0x8000), struct.pack("<H", 0x801F), (0, 0, 255, 255)),
        (0x41, 16, (0xF00, 0xF0, 0xF, 0xF000), struct.pack("<H", 0x8421), (68, 34, 17, 136)),
        (0x20001, 16, (0xFF, 0, 0, 0xFF00), b"\x07\x09", (7, 7, 7, 9)),
        (0x2, 8, (0, 0, 0, 0xFF), b"\x09", (255, 255, 255, 9)),
    ],
)
def test_masks_become_rgba8(flags: int, bits: int, masks: tuple[int, ...], texel: bytes, rgba: Any) -> None:
    read = parse_dds(memoryview(legacy(flags, bytes(4), bits, masks, 2, 1, texel * 2)), "t.dds")
    assert read.format == "rgba8"
    assert bytes(read.levels[0][0]) == bytes(rgba) * 2


def test_luminance_is_r8_and_stays_mapped() -> None:
    read = parse_dds(memoryview(legacy(0x20000, bytes(4), 8, (255, 0, 0, 0), 2, 2, b"abcd")), "t.dds")
    assert (read.format, bytes(read.levels[0][0])) == ("r8", b"abcd")
    assert isinstance(read.levels[0][0], memoryview)


@pytest.mark.parametrize(
    ("raw", "message"),
    [
        (b"", "no DDS"),
        (b"DDS " + bytes(200), "header sizes"),
        (legacy(4, b"DXT1", 0, NO_MASKS, 65536, 65536, bytes(64)), "need 2147483776 bytes"),
        (legacy(4, b"DXT1", 0, NO_MASKS, 0, 4, bytes(64)), "width 0"),
        (legacy(4, b"DXT1", 0, NO_MASKS, 4, 4, bytes(64), mips=9), "mip levels"),
        (legacy(4, b"DXT1", 0, NO_MASKS, 4, 4, bytes(64), caps2=0x600), "lacks faces"),
        (legacy(4, b"YUY2", 0, NO_MASKS, 4, 4, bytes(64)), "not supported"),
        (legacy(0x40, bytes(4), 32, (0x5FF, 0xFFC00, 0x3FF00000, 0), 1, 1, bytes(64)), "not supported"),
        (legacy(4, b"DX10", 0, NO_MASKS, 4, 4, bytes(8)), "DX10"),
        (legacy(4, b"DX10", 0, NO_MASKS, 4, 4, struct.pack("<5I", 96, 3, 0, 1, 0) + bytes(64)), "DXGI format 96"),
        (legacy(4, b"DX10", 0, NO_MASKS, 4, 4, struct.pack("<5I", 98, 3, 0, 2**32 - 1, 0) + bytes(64)), "need"),
        (legacy(4, b"DX10", 0, NO_MASKS, 4, 4, struct.pack("<5I", 98, 3, 0, 0, 0) + bytes(64)), "array size"),
        (legacy(4, b"DX10", 0, NO_MASKS, 4, 4, struct.pack("<5I", 98, 9, 0, 1, 0) + bytes(64)), "dimension"),
    ],
)
def test_refused(raw: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        parse_dds(memoryview(raw), "t.dds")


def test_damaged_files_raise_only_our_errors() -> None:
    good = [
        legacy(4, b"DXT3", 0, NO_MASKS, 8, 8, bytes(200), mips=4),
        legacy(0x40, bytes(4), 24, (0xFF0000, 0xFF00, 0xFF, 0), 4, 4, bytes(48)),
        legacy(4, b"DX10", 0, NO_MASKS, 8, 8, struct.pack("<5I", 98, 3, 4, 1, 0) + bytes(6 * 64) + b"LCRN\2\0\0\0{}"),
    ]
    rng = random.Random(5)
    for trial in range(900):
        bad = bytearray(good[trial % 3])
        for _ in range(rng.randint(1, 3)):
            bad[rng.randrange(4, min(len(bad), 148))] = rng.choice((0, 1, 4, 32, 127, 255, rng.randrange(256)))
        if trial % 4 == 0:
            del bad[rng.randrange(len(bad)) :]
        try:
            parse_dds(memoryview(bytes(bad)), "t.dds")
        except LucarnaError:
            continue


def test_real_files(shared_assets: Path, tmp_path: Path) -> None:
    paths = sorted([*(shared_assets / "dds").rglob("*.dds"), *(shared_assets / "sdkmesh_head").rglob("*.dds")])
    assert len(paths) >= 20
    compared = 0
    for path in paths:
        texture = read_dds(path)
        write_dds(tmp_path / "copy.dds", texture)
        assert content(read_dds(tmp_path / "copy.dds")) == content(texture)
        if texture.format == "rgba8" and texture.depth == 1:
            with Image.open(path) as image:
                truth = np.asarray(image.convert("RGBA")).astype(int)
            ours = np.frombuffer(texture.levels[0][0], np.uint8).reshape(truth.shape)
            assert np.abs(ours - truth).max() <= 1, path.name
            compared += 1
    assert compared >= 5
    with pytest.raises(FormatError, match="need 2147483776 bytes; the file has 192"):
        read_dds(shared_assets / "malformed" / "huge.dds")
