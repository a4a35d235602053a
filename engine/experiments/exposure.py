"""Automatic exposure against the same mean in float64: from darkness to glare, and what leaving it out would show.

The picture before tone mapping is the input of both: the truth sorts all of its luminances and takes the log-mean
between the percentiles to middle grey; the device has a histogram of quarters of a stop. Pictures are shown as each
exposes them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial, grid
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import picture_size, radiance, redrawn
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.render.passes.auto_exposure import GREY
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.perceptual import flip
from engine.report.records import Floor

Bytes = NDArray[np.uint8]

SCENES = (MADE + "metals", MADE + "blocks")
#: of the lights, against what the scene has
STOPS = (-6.0, 0.0, 6.0)
#: darker ones do not count (shaders/passes/exposure_histogram.comp)
DARKEST = 2.0**-16


def knobs(ctx: Context) -> list[dict[str, Any]]:
    stops = STOPS[::2] if ctx.quick else STOPS
    found = grid(scene=own_or(ctx, SCENES[:1] if ctx.quick else SCENES), form=("metered", "off"), light=stops)
    return [{**k, "case": f"{short(str(k['scene']))} {k['light']:+g}"} for k in found]


def view(ctx: Context, scene: OpenScene, light: float, **settings: Any) -> View:
    width, height = picture_size(ctx)
    lit = {"environment_intensity": min(2.0**light, 100.0), "sun_intensity": min(2.0**light, 100.0)}
    how = RenderSettings(samples=1, background="environment", **lit, **settings)
    return View(scene.camera(width / height), width, height, how)


def wanted(scene: OpenScene, seen: View) -> float:
    """Stops that bring the log-mean of the luminances between the percentiles to middle grey."""
    luminance = np.sort(radiance(scene, seen) @ np.array([0.2126, 0.7152, 0.0722]))
    counted = np.log2(luminance[luminance > DARKEST])
    low, high = (float(getattr(seen.settings, f"auto_{end}")) for end in ("low", "high"))
    first, last = (round(part * len(counted)) for part in (low, high))
    return float(GREY - counted[first : max(last, first + 1)].mean()) if len(counted) else 0.0


def picture(scene: OpenScene, seen: View) -> Bytes:
    return np.asarray(scene.render(seen).color.read(), np.uint8)[..., :3]


def run(ctx: Context, chosen: Knobs) -> Trial:
    name, light, form = str(chosen["scene"]), float(chosen["light"]), str(chosen["form"])
    scene = open_scene(ctx, name)
    bare = view(ctx, scene, light)
    own = float(scene.scene.look.exposure)
    best = wanted(scene, bare)
    seen = view(ctx, scene, light, auto_exposure=form == "metered")

    def judge() -> Outcome:
        stops = float(scene.render(seen).stats.counters.get("auto_exposure_ev", own))
        got, truth = picture(scene, seen), picture(scene, view(ctx, scene, light, exposure=best - own))
        error = {"stops": abs(stops - best), "flip": flip(got, truth)[0]}
        label = f"{short(name)}, lights by {light:+g} stops, {form}"
        return Outcome(error, pictures=beside_truth(ctx, label, got, "the mean in float64", truth))

    return redrawn(ctx, scene, seen, judge)


EXPERIMENT = Experiment(
    title="Automatic exposure against a mean in float64",
    method="histogram of luminance on the device, log-mean between two percentiles to middle grey; whole frame",
    truth="the same mean over all pixels, sorted, in float64",
    metric="stops",
    unit="stops",
    knobs=knobs,
    default={"form": "metered"},
    curve="form",
    problem="case",
    run=run,
    needs=frozenset({"gpu"}),
    own_scene=True,
    timed="gpu",
    format_floor=Floor(1.0 / 64.0, "a sixteenth of a bin of the histogram"),
    time_label="median frame time",
    note="No order is expected. `off` is the scene's own exposure: its error is how far the light is from what it was"
    " set for.",
)  # fmt: skip
