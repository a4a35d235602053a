"""Parts of the FBX importer that stand alone: point caches, in-between shapes, uv transforms, packed images."""

from __future__ import annotations

import math
import struct
from pathlib import Path

import numpy as np
import pytest

from engine.assets.material import TextureRef
from engine.core.errors import FormatError
from importers.fbx import images
from importers.fbx.geometry_cache import MOST_FRAMES, PointCache, frame_weights, read_cache, thinned
from importers.fbx.morphs import crossings, effective_weights
from importers.fbx.uv_transforms import apply_matrix

FRAMES = np.arange(12, dtype=float).reshape(2, 2, 3)


def maya_cache(wide: bool, kind: bytes = b"FVCA") -> bytes:
    align, code = (8, ">Q") if wide else (4, ">I")

    def chunk(tag: bytes, data: bytes) -> bytes:
        return tag + bytes(align - 4) + struct.pack(code, len(data)) + data + bytes(-len(data) % align)

    def group(data: bytes) -> bytes:
        return (b"FOR8" if wide else b"FOR4") + bytes(align - 4) + struct.pack(code, len(data)) + data

    out = group(b"CACH" + chunk(b"VRSN", b"0.1\0") + chunk(b"STIM", struct.pack(">i", 0)))
    for k, frame in enumerate(FRAMES):
        values = frame.astype(">f4" if kind == b"FVCA" else ">f8").tobytes()
        body = chunk(b"TIME", struct.pack(">i", 250 * k)) + chunk(b"CHNM", b"shape\0") + chunk(kind, values)
        out += group(b"MYCH" + body + chunk(b"CHNM", b"shape_normals\0") + chunk(b"FVCA", bytes(24)))
    return out


@pytest.mark.parametrize("wide", [True, False])
@pytest.mark.parametrize("kind", [b"FVCA", b"DVCA"])
def test_maya_cache(tmp_path: Path, wide: bool, kind: bytes) -> None:
    (tmp_path / "c.xml").write_text("<Autodesk_Cache_File/>", encoding="utf-8")
    (tmp_path / "c.mcx").write_bytes(maya_cache(wide, kind))
    cache = read_cache(tmp_path / "c.xml", "shape", 2, 24.0, 1 << 20)
    np.testing.assert_allclose(cache.times, [0.0, 250 / 6000])
    np.testing.assert_array_equal(cache.points, FRAMES)
    with pytest.raises(FormatError, match="no frame of 3"):
        read_cache(tmp_path / "c.xml", "shape", 3, 24.0, 1 << 20)


def test_pc2(tmp_path: Path) -> None:
    path = tmp_path / "c.pc2"
    path.write_bytes(b"POINTCACHE2\0" + struct.pack("<iiffi", 1, 2, 12.0, 6.0, 2) + FRAMES.astype("<f4").tobytes())
    cache = read_cache(path, "", 2, 24.0, 1 << 20)
    np.testing.assert_allclose(cache.times, [0.5, 0.75])
    np.testing.assert_array_equal(cache.points, FRAMES)
    for bad in (path.read_bytes()[:-1], b"POINTCACHE2\0", b"nothing at all, but long enough to be read"):
        path.write_bytes(bad)
        with pytest.raises(FormatError):
            read_cache(path, "", 2, 24.0, 1 << 20)


@pytest.mark.parametrize("cut", range(0, 200, 7))
def test_a_cut_cache_is_refused_or_read_in_part(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "c.mcx"
    path.write_bytes(maya_cache(True)[: -cut or None])
    try:
        assert 1 <= len(read_cache(path, "shape", 2, 24.0, 1 << 20).times) <= 2
    except FormatError:
        assert cut > 0


def test_frames_are_mixed_by_their_neighbours() -> None:
    times = np.array([-1.0, 0.0, 0.25, 1.0, 1.5, 9.0])
    np.testing.assert_allclose(
        frame_weights(np.array([0.0, 1.0, 2.0]), times),
        [[1, 0, 0], [1, 0, 0], [0.75, 0.25, 0], [0, 1, 0], [0, 0.5, 0.5], [0, 0, 1]],
    )
    np.testing.assert_allclose(frame_weights(np.array([3.0]), times), np.ones((6, 1)))
    many = thinned(PointCache(np.arange(5000.0), np.zeros((5000, 1, 3))))
    assert len(many.times) == MOST_FRAMES
    assert many.times[[0, -1]].tolist() == [0.0, 4999.0]


@pytest.mark.parametrize(
    ("targets", "weight", "expected"),
    [
        ((1.0,), 0.25, [0.25]),
        ((1.0,), -0.5, [-0.5]),
        ((1.0,), 2.0, [2.0]),
        ((0.5, 1.0), 0.25, [0.5, 0.0]),
        ((0.5, 1.0), 0.75, [0.5, 0.5]),
        ((0.5, 1.0), 1.5, [-1.0, 2.0]),
        ((0.5, 1.0), -0.5, [-1.0, 0.0]),
        ((-0.5, 1.0), -0.25, [0.5, 0.0]),
        ((-0.5, 1.0), 0.25, [0.0, 0.25]),
        ((), 1.0, []),
    ],
)
def test_in_between_shapes(targets: tuple[float, ...], weight: float, expected: list[float]) -> None:
    np.testing.assert_allclose(effective_weights(targets, np.array([weight]))[0], expected, atol=1e-12)


def test_keys_are_added_where_a_weight_passes_a_target() -> None:
    found = crossings((0.5, 1.0), np.array([0.0, 2.0, 3.0]), np.array([-1.0, 1.0, 0.75]))
    assert sorted(found.tolist()) == [1.0, 1.5]


@pytest.mark.parametrize("angle", [0.0, 0.5, math.pi / 2, -2.0])
def test_uv_transforms_do_the_same_from_the_other_corner(angle: float) -> None:
    c, s = math.cos(angle), math.sin(angle)
    linear = np.array([[c, -s], [s, c]]) @ np.diag([2.0, 3.0])
    matrix = np.concatenate([linear, [[0.1], [0.2]]], axis=1)
    reference = TextureRef("")
    assert apply_matrix(matrix.tolist(), reference)
    uv = np.array([0.3, 0.9])
    theirs = matrix @ [uv[0], 1.0 - uv[1], 1.0]  # v grows upwards there
    c, s = math.cos(reference.rotation), math.sin(reference.rotation)
    ours = np.array([[c, s], [-s, c]]) @ (np.array(reference.scale) * uv) + reference.offset
    np.testing.assert_allclose(ours, [theirs[0], 1.0 - theirs[1]], atol=1e-12)


def test_shear_is_admitted() -> None:
    assert not apply_matrix([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0]], TextureRef(""))
    assert not apply_matrix([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], TextureRef(""))


def test_packed_images() -> None:
    grey = np.full((2, 2, 4), 51, np.uint8)
    bright = np.full((2, 2, 4), 204, np.uint8)
    bright[..., 3] = grey[..., 3] = 255
    assert images.metal_rough(grey, bright)[0, 0].tolist() == [255, 51, 204, 255]
    assert images.metal_rough(None, bright)[0, 0].tolist() == [255, 255, 204, 255]
    assert images.metal_gloss(grey, None)[0, 0].tolist() == [255, 204, 255, 255]
    assert images.color_with_alpha(bright, grey)[0, 0].tolist() == [204, 204, 204, 51]
    assert images.color_without(bright, grey)[0, 0].tolist() == [204, 204, 204, 204]
