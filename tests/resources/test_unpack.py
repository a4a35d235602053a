"""Textures decoded for software rasterisers: kept from one start to the next, byte for byte."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.assets.texture import TextureAsset
from engine.gpu.types import Device
from engine.resources import unpack


def noise(size: int, *, layers: int = 1, cube: bool = False) -> TextureAsset:
    """Blocks of random bits: every one of BC1 is a picture."""
    generator = np.random.default_rng(5)
    counts = [max(-(-(size >> i) // 4), 1) ** 2 for i in range(size.bit_length())]
    levels = [[generator.bytes(8 * count) for count in counts] for _ in range(layers)]
    return TextureAsset("bc1", size, size, [list(images) for images in levels], cube=cube)


def plain(asset: TextureAsset) -> list[bytes]:
    return [bytes(data) for images in asset.levels for data in images]


@pytest.mark.parametrize(("layers", "cube"), [(1, False), (6, True)])
def test_what_is_kept_is_what_was_decoded(
    gl_device: Device, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, layers: int, cube: bool
) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path))
    asset = noise(256 if layers == 1 else 64, layers=layers, cube=cube)
    decoded = unpack.unpacked(gl_device, asset)
    first = unpack.unpacked_once(gl_device, asset)
    monkeypatch.setattr(unpack, "unpacked", None)  # not again
    second = unpack.unpacked_once(gl_device, asset)
    assert plain(first) == plain(second) == plain(decoded)
    assert (second.format, second.cube, second.layers) == (decoded.format, cube, layers)


def test_what_is_damaged_is_decoded_again(gl_device: Device, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path))
    asset = noise(256)
    first = unpack.unpacked_once(gl_device, asset)
    (kept,) = (tmp_path / unpack.FOLDER).iterdir()
    kept.write_bytes(kept.read_bytes()[:-1] + b"?")
    assert plain(unpack.unpacked_once(gl_device, asset)) == plain(first)


def test_other_texels_are_another_texture(gl_device: Device, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path))
    asset = noise(256)
    other = TextureAsset("bc1", 256, 256, [[bytes(len(data)) for data in asset.levels[0]]])
    assert plain(unpack.unpacked_once(gl_device, asset)) != plain(unpack.unpacked_once(gl_device, other))
