"""Smooth edges: several samples a pixel, or a filter over the finished picture, against 64 pixels for each.

What one sample a pixel has missed no filter brings back; it only makes steps into slopes. Highlights and textures are
shaded once a pixel in all of them: their error is in every point.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.experiments.picture_lights import has_samples
from engine.math.color import srgb_to_linear, to_u1
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.metrics import rmse
from engine.report.perceptual import flip
from engine.report.records import Floor

Bytes = NDArray[np.uint8]

SCENES = (MADE + "metals", MADE + "blocks")
#: pixels of the truth for each pixel, each way
FINER = 8


def size(ctx: Context) -> tuple[int, int]:
    return (128, 96) if ctx.quick else (256, 192)


def scenes(ctx: Context) -> tuple[str, ...]:
    return tuple(own_or(ctx, SCENES[:1] if ctx.quick else SCENES))


def knobs(ctx: Context) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for scene in scenes(ctx):
        found += [{"scene": scene, "form": form, "samples": 1} for form in ("none", "fxaa")]
        found += [{"scene": scene, "form": "msaa", "samples": n} for n in (2, 4, 8) if has_samples(ctx, n)]
    return found


def view(scene: OpenScene, width: int, height: int, **settings: Any) -> View:
    return View(scene.camera(width / height), width, height, RenderSettings(anisotropy=16.0, **settings))


def picture(scene: OpenScene, seen: View) -> Bytes:
    return np.asarray(scene.render(seen).color.read(), np.uint8)[..., :3]


def truth(scene: OpenScene, width: int, height: int) -> Bytes:
    """Averaged in linear light after the display's curve, as samples are."""
    fine = picture(scene, view(scene, width * FINER, height * FINER, samples=1))
    mean = srgb_to_linear(fine.reshape(height, FINER, width, FINER, 3) / 255.0).mean(axis=(1, 3))
    return to_u1(mean)


def run(ctx: Context, chosen: Knobs) -> Trial:
    assert ctx.device is not None, "the experiment needs a device"
    device, name = ctx.device, str(chosen["scene"])
    width, height = size(ctx)
    scene = open_scene(ctx, name)
    best = ctx.once(f"truth {name}", lambda: truth(scene, width, height))
    filtered = "fxaa" if chosen["form"] == "fxaa" else "none"
    seen = view(scene, width, height, samples=int(chosen["samples"]), antialias=filtered)

    def work() -> None:
        scene.render(seen)
        device.finish()

    def judge(_: object) -> Outcome:
        got = picture(scene, seen)
        label = f"{short(name)}, {chosen['form']} {chosen['samples']}"
        shown = chosen["form"] == "fxaa" or chosen["samples"] in (1, 4)
        error = {"rmse_8_bit": rmse(got, best), "flip": flip(got, best)[0]}
        return Outcome(
            error, pictures=beside_truth(ctx, label, got, f"{FINER**2} pixels for one", best) if shown else []
        )

    return Trial(work, judge, gpu=True, close=scene.close)


EXPERIMENT = Experiment(
    title="Anti-aliasing against supersampling",
    method="one sample a pixel, the same with FXAA, or 2, 4 and 8 samples (MSAA); whole frame",
    truth="64 pixels for each pixel, averaged in linear light after the tone map",
    metric="rmse_8_bit",
    unit="8-bit steps",
    knobs=knobs,
    default={"form": "msaa", "samples": 4},
    curve="form",
    problem="scene",
    run=run,
    needs=frozenset({"gpu"}),
    own_scene=True,
    timed="gpu",
    format_floor=Floor(1.0, "one step of 8 bits"),
    time_label="median frame time",
    note="No order is expected: edges by n samples fall between n^-1/2 and n^-3/4, but what is not an edge (highlights,"
    " textures) is shaded once a pixel whatever n is, and stays as an error.",
)  # fmt: skip
