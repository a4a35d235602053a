"""SMAA's areas against fine sums; slanted lines and corners; a thin line, which must not be eaten."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from engine.assets.primitives import card
from engine.math.color import srgb_to_linear
from tests.support.shader_probe import ShaderProbe
from tests.support.stage import front_camera

pytestmark = pytest.mark.gl

FINE = 4000


def line(first, last, length: float, x):
    """Height of the line that an edge stands for: from where it ends, half a pixel up or down, to the other end or to
    the middle."""
    h0, h1 = 0.5 * (first[0] - first[1]), 0.5 * (last[0] - last[1])
    if first == (1, 1):
        h0 = -h1
    if last == (1, 1):
        h1 = -h0
    if h0 * h1 < 0.0:
        return h0 + (h1 - h0) * x / length
    return np.where(x < length / 2.0, h0 * (1.0 - 2.0 * x / length), h1 * (2.0 * x / length - 1.0))


def test_areas_are_those_under_the_line(gl_device, tmp_path: Path) -> None:
    ends = [(0, 0), (1, 0), (0, 1), (1, 1)]
    rows = [
        (first, last, float(before + after + 1), float(before))
        for first, last in itertools.product(ends, ends)
        for before, after in ((0, 0), (0, 1), (2, 0), (3, 4), (1, 12))
    ]
    probe = ShaderProbe(gl_device, tmp_path)
    got = probe(
        "result = vec4(smaa_area(first, last, size, at), 0.0, 0.0);", "lib/smaa_area.glsl",
        first=np.array([r[0] for r in rows]), last=np.array([r[1] for r in rows]),
        size=np.array([r[2] for r in rows]), at=np.array([r[3] for r in rows]),
    )[:, :2]  # fmt: skip
    for row, areas in zip(rows, got, strict=True):
        y = line(row[0], row[1], row[2], row[3] + (np.arange(FINE) + 0.5) / FINE)
        assert areas == pytest.approx((np.maximum(y, 0.0).mean(), np.maximum(-y, 0.0).mean()), abs=1e-4), row
    assert got.max() <= 0.5


def test_areas_of_a_stair_are_those_cut_off_by_its_line(gl_device, tmp_path: Path) -> None:
    """Of the pixel beyond an edge of a stair and of the one on this side, by points in them. The line goes through
    x = y + 1/2, shifted along x by up to half a pixel where it ends, straight or to the middle."""
    rows = [(*ends, n, at) for ends in itertools.product((-1, 0, 1), repeat=2) for n in (4, 7) for at in (0, 2, n - 1)]
    got = ShaderProbe(gl_device, tmp_path)(
        "result = vec4(smaa_stair(first, last, size, at), 0.0, 0.0);", "lib/smaa_area.glsl",
        first=np.array([float(r[0]) for r in rows]), last=np.array([float(r[1]) for r in rows]),
        size=np.array([float(r[2]) for r in rows]), at=np.array([float(r[3]) for r in rows]),
    )[:, :2]  # fmt: skip
    y, x = (np.mgrid[:500, :500] + 0.5) / 500.0  # y down

    def shift(row, where: float) -> float:
        h0, h1 = 0.5 * row[0], 0.5 * row[1]
        if h0 * h1 < 0.0:
            return h0 + (h1 - h0) * where
        return h0 * (1.0 - 2.0 * where) if where < 0.5 else h1 * (2.0 * where - 1.0)

    for row, areas in zip(rows, got, strict=True):
        _, _, length, at = row
        # this side's pixel: beyond is up and to the right; the other pixel: this side is down and to the left
        here = (x > y + 0.5 + shift(row, (at + 1) / length)).mean()
        beyond = (x < y - 0.5 + shift(row, at / length)).mean()
        assert areas == pytest.approx((beyond, here), abs=3e-3), row


def rms_off(stage, surface, degrees: float, patterns: str) -> float:
    """Of a bright card's edges, against 64 pixels for each."""
    stage.dark()
    half = np.radians(degrees) / 2.0
    white = surface(base_color=(0.0, 0.0, 0.0, 1.0), specular=0.0, emissive=(1.0, 1.0, 1.0))
    stage.add(card(0.6), white, (0.013, 0.021, 0.0), rotation=(0.0, 0.0, np.sin(half), np.cos(half)))
    camera, (width, height) = front_camera(0.5, 1.2), (48, 40)
    fine = srgb_to_linear(stage.ldr((8 * width, 8 * height), camera)[..., 0] / 255.0)
    truth = fine.reshape(height, 8, width, 8).mean(axis=(1, 3))
    got = stage.ldr((width, height), camera, antialias="smaa", smaa_patterns=patterns)[..., 0]
    return float(np.sqrt(np.mean((srgb_to_linear(got / 255.0) - truth) ** 2)))


@pytest.mark.parametrize("degrees", [35.0, 40.0])
def test_lines_near_the_diagonal_are_smoother(stage, surface, degrees) -> None:
    """Steps of one pixel, each by itself, are smoothed by an eighth of a pixel; as a line, by what lies beyond it."""
    assert rms_off(stage, surface, degrees, "all") < 0.75 * rms_off(stage, surface, degrees, "lines")


def test_an_upright_corner_stays_sharp(stage, surface) -> None:
    """A card on the pixels' raster has no stairs: it stays as it is to the byte; lines alone round its corners."""
    stage.dark()
    white = surface(base_color=(0.0, 0.0, 0.0, 1.0), specular=0.0, emissive=(1.0, 1.0, 1.0))
    stage.add(card(0.6), white)
    bare, corners, lines = (
        stage.ldr((48, 40), front_camera(0.5, 1.2), antialias=form, smaa_patterns=patterns)
        for form, patterns in (("none", "all"), ("smaa", "all"), ("smaa", "lines"))
    )
    assert len(np.unique(bare)) > 1
    assert np.array_equal(corners, bare)
    assert not np.array_equal(lines, bare)


@pytest.mark.parametrize("degrees", [0.0, 10.0])
def test_a_thin_line_keeps_its_light(stage, surface, degrees) -> None:
    """A line of two pixels across the picture: no more than a twentieth of its light goes or comes."""
    stage.dark()
    half = np.radians(degrees) / 2.0
    white = surface(base_color=(0.0, 0.0, 0.0, 1.0), specular=0.0, emissive=(1.0, 1.0, 1.0))
    stage.add(card(1.0), white, scale=(3.0, 2.0 / 40.0, 1.0), rotation=(0.0, 0.0, np.sin(half), np.cos(half)))
    bare, smooth = (stage.ldr((48, 40), front_camera(0.5, 1.2), antialias=a)[..., 0] / 255.0 for a in ("none", "smaa"))
    linear = [srgb_to_linear(picture).sum() for picture in (bare, smooth)]
    assert linear[1] == pytest.approx(linear[0], rel=0.05)
