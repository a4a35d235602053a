"""Edges of the sun's shadows whose right answer is a formula: how soft they are, and what leaks through two casters.

`penumbra`: a straight edge at four heights over a floor, under a sun of 3 degrees. The part of its disc that is seen
beside the edge is that which a chord cuts off (engine.experiments.shadow_filter.cut_area). `two casters`: a place that
a low card hides from all of the sun, over which a high card ends: any light there has leaked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.primitives import plane
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import brightness, greys, redrawn
from engine.experiments.harness.samples import environment, floor, surface
from engine.experiments.harness.scenes import MADE, MadeScene
from engine.experiments.shadow_filter import cut_area
from engine.experiments.sun_shadows import FILTERS, another_sun, by_kind
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.settings import RenderSettings
from engine.render.shadows.quality import MOMENTS
from engine.render.view import View

F8 = NDArray[np.float64]

PENUMBRA, CASTERS = "penumbra", "two casters"
#: degrees
SUN = 3.0
#: texels, of three cascades
MAP = 512
#: metres of the edges over the floor, one behind the other
HEIGHTS = (0.25, 0.5, 1.0, 2.0)
SOFTNESS = (1.0, 3.0, 8.0)
SIZE = (192, 192)


def knobs(ctx: Context) -> list[dict[str, Any]]:
    """Every filter, softer and softer where it has a fixed width; on the casters those that can leak, with and without
    taking the least light for none."""
    found: list[dict[str, Any]] = []
    soft = SOFTNESS[1:2] if ctx.quick else SOFTNESS
    plain = {"precision": "single", "leak": RenderSettings().shadow_leak, "size": MAP}
    for filter in FILTERS:
        fixed = filter not in ("none", "pcf", "pcss")
        found += [{"scene": PENUMBRA, "filter": filter, "softness": s, **plain} for s in (soft if fixed else (1.5,))]
    kinds = [f for f in FILTERS if f in MOMENTS]
    found += [{"scene": CASTERS, "filter": f, "softness": 3.0, **plain} for f in ("pcf", *kinds)]
    found += [{"scene": CASTERS, "filter": f, "softness": 3.0, **plain, "leak": 0.0} for f in kinds]
    half = {**plain, "precision": "half"}
    found += [{"scene": s, "filter": f, "softness": 3.0, **half} for s in (PENUMBRA, CASTERS) for f in ("evsm4", "msm")]
    return by_kind(found)


@dataclass(frozen=True, slots=True)
class Made:
    scene: MadeScene
    truth: F8


def made(ctx: Context, name: str) -> Made:
    """The scene and what is seen of the sun at each pixel, f8[h*w]; the caller closes it."""
    assert ctx.device is not None, "the experiment needs a device"
    scene = MadeScene(MADE + name, ctx.device)
    environment(scene, "none", sun=3.0, sun_elevation=math.pi / 4, sun_azimuth=-math.pi / 2)
    floor(scene, 8.0)
    grey = surface(base_color=(0.5, 0.5, 0.5, 1.0), metallic=0.0, roughness=1.0)
    across = (np.arange(SIZE[0]) + 0.5) / SIZE[0] * 2.0 - 1.0
    if name == CASTERS:
        scene.add(plane(3.0), grey, (-4.0, 4.0, 0.0))
        scene.add(plane(4.0), grey, (-1.0, 2.0, 0.0))
        scene.view_from = above((1.5, 0.0), 0.3)
        return Made(scene, np.zeros(SIZE[0] * SIZE[1]))
    half = 0.5
    truth = np.zeros(SIZE[::-1])
    strip = SIZE[1] // len(HEIGHTS)
    for i, height in enumerate(HEIGHTS):
        # its shadow ends at x = 0: the sun is 45 degrees high in -X
        ends = [(k * strip / SIZE[1] * 2.0 - 1.0) * half for k in (i, i + 1)]
        ends = [ends[0] - half * (i == 0), ends[1] + half * (i == len(HEIGHTS) - 1)]  # beyond the picture
        scene.add(
            plane(1.0), grey, (-height - 0.5, height, sum(ends) / 2.0), scale=(1.0, 1.0, ends[1] - ends[0])
        )  # fmt: skip
        # across the sun's rays, the edge is x sin 45 from the middle of its disc, whose radius there is r
        r = math.sqrt(2.0) * height * math.tan(math.radians(SUN / 2.0))
        truth[i * strip : (i + 1) * strip] = cut_area(across * half * math.sqrt(0.5) / r)
    scene.view_from = above((0.0, 0.0), half)
    return Made(scene, truth.ravel())


def above(center: tuple[float, float], half: float, height: float = 8.0) -> Camera:
    """Straight down from `height`; picture right is +X, picture down is +Z."""
    x, z = center
    return Camera(look_at((x, height, z), (x, 0.0, z), (0.0, 0.0, -1.0)), ymag=half, znear=0.1, zfar=20.0)


def judged_rows(name: str) -> NDArray[np.int64]:
    """Pixels that count: the middle of each strip, which no end of another edge reaches."""
    inside = np.ones(SIZE[::-1], bool)
    if name == PENUMBRA:
        strip = SIZE[1] // len(HEIGHTS)
        row = np.arange(SIZE[1]) % strip
        inside[np.abs(row - strip // 2) > strip // 8] = False
        inside[:, np.abs(np.arange(SIZE[0]) - SIZE[0] / 2.0) > 0.23 * SIZE[0]] = False  # the lowest card is seen there
    return np.flatnonzero(inside.ravel())


def settings(chosen: Knobs, **more: Any) -> RenderSettings:
    return RenderSettings(
        samples=1, background="color", tone_map="none", sun_angle=SUN, shadow_filter=str(chosen["filter"]),
        shadow_softness=float(chosen["softness"]), shadow_precision=str(chosen["precision"]),
        shadow_leak=float(chosen["leak"]), shadow_size=int(chosen["size"]),
        **more,
    )  # fmt: skip


def run(ctx: Context, chosen: Knobs) -> Trial:
    name = str(chosen["scene"])
    found = made(ctx, name)
    scene = found.scene
    seen = View(scene.view_from, *SIZE, settings(chosen))
    rows = judged_rows(name)

    def judge() -> Outcome:
        full = brightness(scene, View(scene.view_from, *SIZE, settings(chosen, shadows=False)))[rows]
        ours = np.clip(brightness(scene, seen)[rows] / np.maximum(full, 1e-9), 0.0, 1.0)
        off = ours - found.truth[rows]
        error = {
            "rmse": float(np.sqrt(np.mean(off**2))), "leak": float(np.maximum(off, 0.0).mean()),
            "worst": float(np.abs(off).max()),
        }  # fmt: skip
        pictures = []
        if chosen["softness"] in (1.5, 3.0) and chosen["precision"] == "single" and name == PENUMBRA:
            a, b = greys(SIZE, rows, ours, found.truth[rows])
            caption = f"{chosen['filter']}, {chosen['softness']:g} texels"
            pictures = beside_truth(ctx, caption, a, "the sun's disc, cut", b)
        return Outcome(error, pictures=pictures)

    return redrawn(ctx, scene, seen, judge, another_sun)


EXPERIMENT = Experiment(
    title="Edges of the sun's shadows: softness and leaks",
    method="every filter, of fixed softness (texels) or, for pcss, as wide as the sun makes it; drawn anew",
    truth="the part of the sun's disc that a straight edge leaves; 0 under two casters",
    metric="rmse",
    unit="visibility",
    knobs=knobs,
    default={},
    advisory=True,
    curve="kind",
    problem="scene",
    run=run,
    needs=frozenset({"gpu"}),
    timed="gpu",
    time_label="median frame time",
    note="A filter of fixed width is right at one distance from what casts; the edges here lie at four.",
)  # fmt: skip
