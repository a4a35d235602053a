"""Numbers that stand both in Python and in a shader are the same; the filter experiment's truth is."""

from __future__ import annotations

import re

import numpy as np
import pytest

from engine.core.paths import shaders_dir
from engine.experiments.shadow_filter import cut_area
from engine.render.shadows import bias, fit, quality, sun
from engine.render.view_block import MAX_CASCADES

TEXT = (shaders_dir() / "lib/shadows.glsl").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("FOOTPRINT", (bias.FOOTPRINT,)), ("CONSTANT", (bias.HARDWARE_CONSTANT, bias.CONSTANT)),
        ("MAX_SLOPE", (bias.HARDWARE_MAX_SLOPE, bias.MAX_SLOPE)), ("LIFT", (bias.HARDWARE_LIFT, bias.LIFT)),
        ("MARGIN", (fit.MARGIN,)),
    ],
)  # fmt: skip
def test_constants_agree(name: str, value: tuple[float, ...]) -> None:
    found = re.findall(rf"const float SHADOW_{name} = (\S+);", TEXT)
    assert tuple(bias.FOOTPRINT if x == "SHADOW_FOOTPRINT" else float(x) for x in found) == value


def test_the_shader_knows_every_filter() -> None:
    assert quality.FILTERS == (
        "none", "pcf", "vogel8", "vogel16", "pcss", "poisson8", "poisson16", "poisson24",
        "esm", "vsm", "evsm2", "evsm4", "msm",
    )  # fmt: skip
    assert quality.FILTERS.index("esm") == int(re.findall(r"SHADOW_MOMENTS \(SHADOW_FILTER >= (\d+)\)", TEXT)[0])
    low, high = re.findall(r"SHADOW_HARDWARE \(SHADOW_FILTER >= (\d+) && SHADOW_FILTER <= (\d+)\)", TEXT)[0]
    assert frozenset(quality.FILTERS[int(low) : int(high) + 1]) == quality.HARDWARE
    moments = (shaders_dir() / "lib/shadow_moments.glsl").read_text(encoding="utf-8")
    assert max(int(n) for n in re.findall(r"SHADOW_FILTER == (\d+)", moments)) == len(quality.FILTERS) - 1


def test_all_cascades_that_a_view_may_ask_for_have_room() -> None:
    from engine.render.settings import RenderSettings

    most = next(p.max for p in RenderSettings.PARAMS if p.name == "shadow_cascades")
    assert most == MAX_CASCADES
    assert np.isfinite(np.float32(1.0 / (sun.EVERYWHERE * 2))).all()


def test_the_cut_of_a_disc() -> None:
    """Against the sum over a fine grid of the disc."""
    axis = (np.arange(2000) + 0.5) / 1000 - 1
    x, y = np.meshgrid(axis, axis)
    disc = x * x + y * y < 1.0
    for d in (-1.0, -0.7, 0.0, 0.3, 1.0):
        assert cut_area(np.array(d)) == pytest.approx((disc & (x < d)).sum() / disc.sum(), abs=1e-4)
    assert cut_area(np.array([-5.0, 5.0])).tolist() == [0.0, 1.0]


def test_auto_is_a_filter() -> None:
    assert quality.filter_for("auto") in quality.FILTERS
    assert [quality.filter_for(f) for f in quality.FILTERS] == list(quality.FILTERS)
