"""Every ramp and every set of colours that carries a meaning, as people with fewer cones see it."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pytest

from editor import skeleton_overlay, theme
from editor.texture_view import INF_COLOR, NAN_COLOR
from engine.core.paths import shaders_dir
from engine.math.color import linear_to_srgb
from engine.render.legends import STOPS
from engine.report.perceptual import magma
from tests.support.color_vision import VISIONS, apart, lab

#: ΔE*ab under which two patches that are far apart in a picture are mixed up; side by side 2.3 is seen (Mahy 1994)
DISTANCE = 15.0
PLACES = np.linspace(0.0, 1.0, 17)


def glsl_colors(file: str, pattern: str) -> list[tuple[float, ...]]:
    """Display colours of the vec3s, scene-linear, in the part of a shader that `pattern` finds."""
    part = re.search(pattern, (shaders_dir() / file).read_text(encoding="utf-8"), re.DOTALL)
    assert part is not None
    found = [tuple(float(n) for n in v.split(",")) for v in re.findall(r"vec3\(([\d.]+, [\d.]+, [\d.]+)\)", part[0])]
    return [tuple(row) for row in linear_to_srgb(np.array(found)).tolist()]


def at_stops(stops: Sequence[Sequence[float]]) -> np.ndarray:
    table = np.asarray(stops, np.float64)
    across = PLACES * (len(table) - 1)
    return np.stack([np.interp(across, np.arange(len(table)), table[:, i]) for i in range(3)], axis=1)


RAMPS = {
    "debug views, light tiles": (at_stops(STOPS), 60.0),
    "differences, FLIP": (magma(PLACES[None])[0] / 255.0, 60.0),
    "bone masks": (np.array([skeleton_overlay.mask_color(w)[:3] for w in PLACES]), 15.0),
}
SETS = {
    "influences": glsl_colors("lib/skin_views.glsl", r"vec3 count_color.*?\n}"),
    "cascades": glsl_colors("lib/shadows.glsl", r"vec3\[4\]\(.*?\);"),
    "marked pixels": [(1.0, 0.0, 1.0), (1.0, 1.0, 0.0), (0.0, 1.0, 1.0), (1.0, 0.5, 0.0)],
    "marked texels": [tuple(c / 255.0 for c in color) for color in (NAN_COLOR, INF_COLOR)],
    "ghosts": [skeleton_overlay.GHOST_BEFORE, skeleton_overlay.GHOST_AFTER],
    "bars and curves": [c[:3] for c in theme.SERIES],
    "axes": [c[:3] for c in theme.AXES],
    "axes of bones": [c[:3] for c in skeleton_overlay.AXES],
    "severities": [c[:3] for c in (theme.GOOD, theme.WARNING, theme.ERROR, theme.INFO)],
}


@pytest.mark.parametrize("vision", VISIONS)
@pytest.mark.parametrize("name", RAMPS)
def test_ramps_grow_lighter_all_along(name: str, vision: str) -> None:
    colors, least = RAMPS[name]
    lightness = lab(colors, vision)[:, 0]
    assert (np.diff(lightness) > 0.0).all(), np.round(lightness, 1)
    assert lightness[-1] - lightness[0] > least


@pytest.mark.parametrize("vision", VISIONS)
@pytest.mark.parametrize("name", SETS)
def test_colours_with_a_meaning_stay_apart(name: str, vision: str) -> None:
    distance, pair = apart(SETS[name], vision)
    assert distance > DISTANCE, f"{name}: {pair} are {distance:.1f} apart"


def test_the_simulation_knows_what_is_known() -> None:
    """White and black stay; red and green meet for a deuteranope and not for others; D65 white is L* 100."""
    assert lab([[1.0, 1.0, 1.0]], "normal")[0] == pytest.approx((100.0, 0.0, 0.0), abs=0.02)
    for vision in VISIONS:
        assert lab([[1.0, 1.0, 1.0]], vision)[0] == pytest.approx((100.0, 0.0, 0.0), abs=0.1)
    clash = [(0.80, 0.42, 0.20), (0.55, 0.55, 0.20)]
    assert apart(clash, "deuteranopia")[0] < 0.35 * apart(clash, "normal")[0]


def test_legend_and_shader_have_the_same_influences() -> None:
    shown = linear_to_srgb(np.array(skeleton_overlay.INFLUENCES))
    assert np.allclose(shown, SETS["influences"])
