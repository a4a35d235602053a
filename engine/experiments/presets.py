"""Presets on the front: what each takes, and how far it is from the picture with everything at its best.

Each preset stands beside the same with another way to smooth edges, so that a preset that is not the best for its time
is seen to be not. Pictures rest: TAA is judged when it has gathered its frames, and timed by the frame.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.antialias import live
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import picture_size, redrawn
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.experiments.picture_lights import has_samples
from engine.math.color import srgb_to_linear, to_u1
from engine.render.motion.jitter import pixel_jitter
from engine.render.presets import PRESETS
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.metrics import rmse
from engine.report.perceptual import flip
from engine.report.records import Floor

Bytes = NDArray[np.uint8]

SCENES = (MADE + "blocks",)
OWN = "preset"
#: the same in the other ways to smooth edges
OTHERS = ("none", "fxaa", "smaa", "taa", "msaa")


def places(ctx: Context) -> int:
    """In each pixel of the truth."""
    return 16 if ctx.quick else 64


def knobs(ctx: Context) -> list[dict[str, Any]]:
    names = tuple(PRESETS)[:3:2] if ctx.quick else tuple(PRESETS)
    edges = ("none",) if ctx.quick else tuple(e for e in OTHERS if e != "msaa" or has_samples(ctx, 4))
    return [
        {"scene": scene, "edges": way, "preset": name}
        for scene in own_or(ctx, SCENES) for way in (OWN, *edges) for name in names
    ]  # fmt: skip


def settings(chosen: Knobs) -> RenderSettings:
    values = dict(PRESETS[str(chosen["preset"])])
    way = str(chosen["edges"])
    if way != OWN:
        values |= {"samples": 4 if way == "msaa" else 1, "antialias": "none" if way == "msaa" else way}
    return RenderSettings(**values)


def view(ctx: Context, scene: OpenScene, how: RenderSettings) -> View:
    width, height = picture_size(ctx)
    return View(scene.camera(width / height), width, height, how, seconds=1.0 / 60.0)


def picture(scene: OpenScene, seen: View) -> Bytes:
    return np.asarray(scene.render(seen).color.read(), np.uint8)[..., :3]


def truth(ctx: Context, scene: OpenScene) -> Bytes:
    """All knobs of all presets at their ends, and many places in each pixel, averaged in linear light."""
    values = {**PRESETS["ultra"], "antialias": "none", "ao_directions": 8, "ao_steps": 16}
    seen = view(ctx, scene, RenderSettings(**values))
    total = np.zeros((seen.height, seen.width, 3))
    count = places(ctx)
    for i in range(count):
        seen.shift = pixel_jitter(i, count)
        total += srgb_to_linear(picture(scene, seen) / 255.0)
    return to_u1(total / count)


def run(ctx: Context, chosen: Knobs) -> Trial:
    name = str(chosen["scene"])
    scene = open_scene(ctx, name)
    best = ctx.once(f"all of {name}", lambda: truth(ctx, scene))
    seen = view(ctx, scene, settings(chosen))

    def judge() -> Outcome:
        temporal = seen.settings.antialias == "taa"
        for step in live(seen, int(seen.settings.taa_frames)) if temporal else [seen]:
            got = picture(scene, step)
        error = {"flip": flip(got, best)[0], "rmse_8_bit": rmse(got, best)}
        label = f"{short(name)}, {chosen['preset']}"
        shown = chosen["edges"] == OWN
        return Outcome(error, pictures=beside_truth(ctx, label, got, "everything at its best", best) if shown else [])

    return redrawn(ctx, scene, seen, judge)


EXPERIMENT = Experiment(
    title="Quality presets on the front",
    method="each preset, and the same with each way to smooth edges; whole frame",
    truth="the best of every knob, 64 places in each pixel averaged in linear light",
    metric="rmse_8_bit",
    unit="8-bit steps",
    knobs=knobs,
    default={"edges": OWN, "preset": "medium"},
    curve="edges",
    problem="scene",
    run=run,
    needs=frozenset({"gpu"}),
    own_scene=True,
    timed="gpu",
    format_floor=Floor(1.0, "one step of 8 bits"),
    time_label="median frame time",
    note="A preset is good where no other point is quicker and nearer. Pictures stand still here: while the camera"
    " turns, TAA is softer (see `antialias`).",
)  # fmt: skip
