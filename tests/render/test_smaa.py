"""SMAA's areas against fine sums; a thin line, which must not be eaten."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from engine.assets.primitives import card
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


@pytest.mark.parametrize("degrees", [0.0, 10.0])
def test_a_thin_line_keeps_its_light(stage, surface, degrees) -> None:
    """A line of two pixels across the picture: no more than a twentieth of its light goes or comes."""
    stage.dark()
    half = np.radians(degrees) / 2.0
    white = surface(base_color=(0.0, 0.0, 0.0, 1.0), specular=0.0, emissive=(1.0, 1.0, 1.0))
    stage.add(card(1.0), white, scale=(3.0, 2.0 / 40.0, 1.0), rotation=(0.0, 0.0, np.sin(half), np.cos(half)))
    bare, smooth = (stage.ldr((48, 40), front_camera(0.5, 1.2), antialias=a)[..., 0] / 255.0 for a in ("none", "smaa"))
    linear = [np.where(p > 0.04045, ((p + 0.055) / 1.055) ** 2.4, p / 12.92).sum() for p in (bare, smooth)]
    assert linear[1] == pytest.approx(linear[0], rel=0.05)
