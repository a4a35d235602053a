"""Bloom against the halos that it stands for, convolved in float64 with the picture mirrored at its borders.

The picture without bloom is the input of both, so that nothing but the halvings differs. `misplaced` is the part of the
scattered light that comes down elsewhere than the halos say; `lost` the part of all light that the picture has too
little of (or, below 0, too much).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial, grid
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import redrawn
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.math.color import to_u1
from engine.math.glare import halos
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.perceptual import flip
from engine.report.records import Extreme

F8 = NDArray[np.float64]

SCENES = (MADE + "metals", MADE + "blocks")
RADII = (0.01, 0.03, 0.1, 0.3)
#: of the light, scattered
PART = 0.5


def size(ctx: Context) -> tuple[int, int]:
    return (192, 128) if ctx.quick else (480, 320)


def knobs(ctx: Context) -> list[dict[str, Any]]:
    radii = RADII[1:3] if ctx.quick else RADII
    named = own_or(ctx, SCENES[:1] if ctx.quick else SCENES)
    found = grid(scene=named, form=("bloom", "calm", "off"), radius=radii)
    # one radius shows what the scenes after the first are about
    few = [k for k in found if k["scene"] == named[0] or k["radius"] == RADII[2]]
    return [{**k, "case": f"{short(str(k['scene']))} {k['radius']:g}"} for k in few]


def view(ctx: Context, scene: OpenScene, **settings: Any) -> View:
    width, height = size(ctx)
    return View(scene.camera(width / height), width, height, RenderSettings(samples=1, **settings))


def linear(scene: OpenScene, seen: View) -> F8:
    hdr = scene.render(seen, hdr=True).hdr
    assert hdr is not None, "asked for"
    return np.asarray(hdr.read(), np.float64)[..., :3]


def run(ctx: Context, chosen: Knobs) -> Trial:
    name, radius = str(chosen["scene"]), float(chosen["radius"])
    scene = open_scene(ctx, name)
    bare = ctx.once(f"bare {name}", lambda: linear(scene, view(ctx, scene)))
    truth = ctx.once(f"halos {name} {radius}", lambda: (1.0 - PART) * bare + PART * halos(bare, radius))
    part = 0.0 if chosen["form"] == "off" else PART
    seen = view(ctx, scene, bloom=part, bloom_radius=radius, bloom_calm=chosen["form"] == "calm")

    def judge() -> Outcome:
        ours = linear(scene, seen)
        a, b = to_u1(np.clip(ours, 0.0, 1.0)), to_u1(np.clip(truth, 0.0, 1.0))
        error = {
            "misplaced": float(np.abs(ours - truth).sum() / np.abs(bare - truth).sum()),
            "lost": float(1.0 - ours.sum() / bare.sum()),
            "rmse": float(np.sqrt(np.mean((ours - truth) ** 2))),
            "flip": flip(a, b)[0],
        }
        label = f"{short(name)}, {chosen['form']}, radius {radius:g}"
        shown = radius == RADII[2] and part > 0.0
        return Outcome(error, pictures=beside_truth(ctx, label, a, "halos in float64", b) if shown else [])

    return redrawn(ctx, scene, seen, judge)


def extremes(ctx: Context) -> Iterator[Extreme]:
    """The sum of light where halvings cannot be even, or there are none."""
    scene = open_scene(ctx, SCENES[0])
    try:
        for width, height in ((1, 1), (2, 1), (17, 9), (33, 65)):
            camera = scene.camera(width / height)
            pair = [
                linear(scene, View(camera, width, height, RenderSettings(samples=1, bloom=part, bloom_radius=1.0)))
                for part in (0.0, 1.0)
            ]
            change = float(pair[1].sum() / pair[0].sum()) - 1.0
            yield Extreme(f"{width}x{height}, all light scattered", f"sum of light {change:+.2g}", abs(change) < 0.01)
    finally:
        scene.close()


EXPERIMENT = Experiment(
    title="Bloom against Gaussian halos",
    method="halved by quadratic B-splines and brought back up, weighted by the halos' variances; whole frame",
    truth="the mean of the picture under six Gaussians, each half as wide as the one before, in float64",
    metric="misplaced",
    unit="of the scattered light",
    knobs=knobs,
    default={"form": "bloom", "radius": 0.1},
    curve="form",
    problem="case",
    run=run,
    needs=frozenset({"gpu"}),
    own_scene=True,
    timed="gpu",
    extremes=extremes,
    time_label="median frame time",
    note="No order is expected: the number of halvings follows from the radius. What is misplaced is the difference"
    " between splines and Gaussians. `calm` counts bright texels less: what it loses is its price.",
)
