"""Presets on the front: what each takes, and how far it is from the picture with everything at its best.

Each preset stands beside the same with another way to smooth edges, and without or with depth drawn first, so that a
preset that is not the best for its time is seen to be not. Half of the time things rest and half of it they move: the
error is the rms of that of a picture that has rested and that of one in a turn; frames are timed while the camera
turns, when shadow maps are drawn anew and TAA has all of its work.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.antialias import STEP, live, turned
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import picture_size, redrawn
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.experiments.harness.verdict import beats
from engine.experiments.picture_lights import has_samples
from engine.math.color import srgb_to_linear, to_u1
from engine.render.motion.jitter import pixel_jitter
from engine.render.presets import PRESETS
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.metrics import rmse
from engine.report.perceptual import flip
from engine.report.records import Floor, Point, Table

Bytes = NDArray[np.uint8]

SCENES = (MADE + "blocks",)
OWN = "preset"
#: the same in the other ways to smooth edges, and with depth drawn first or not
OTHERS = ("none", "fxaa", "smaa", "taa", "msaa", "depth")


def places(ctx: Context) -> int:
    """In each pixel of the truth."""
    return 16 if ctx.quick else 64


def knobs(ctx: Context) -> list[dict[str, Any]]:
    names = tuple(PRESETS)[:3:2] if ctx.quick else tuple(PRESETS)
    edges = ("none",) if ctx.quick else tuple(e for e in OTHERS if e != "msaa" or has_samples(ctx, 4))
    return [
        {"scene": scene, "edges": way, "preset": name}
        for scene in own_or(ctx, SCENES) for way in (OWN, *edges) for name in names
        if way == OWN or values({"edges": way, "preset": name}) != values({"edges": OWN, "preset": name})
    ]  # fmt: skip


def settings(chosen: Knobs) -> RenderSettings:
    values = dict(PRESETS[str(chosen["preset"])])
    way = str(chosen["edges"])
    if way == "depth":
        values["depth_first"] = not values["depth_first"]
    elif way != OWN:
        values |= {"samples": 4 if way == "msaa" else 1, "antialias": "none" if way == "msaa" else way}
    return RenderSettings(**values)


def values(chosen: Knobs) -> dict[str, Any]:
    return settings(chosen).values()


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
    camera = seen.camera

    def judge() -> Outcome:
        temporal = seen.settings.antialias == "taa"
        error, pictures = {}, []
        for where, turning in (("at_rest", False), ("turning", True)) if temporal else (("at_rest", False),):
            for step in live(replace(seen, camera=camera), int(seen.settings.taa_frames) // 2, turning=turning):
                got = picture(scene, step if temporal else seen)
                if not temporal:
                    break
            error[where], error[f"flip_{where}"] = rmse(got, best), flip(got, best)[0]
            if chosen["edges"] == OWN:
                label = f"{short(name)}, {chosen['preset']}" + (f", {where.replace('_', ' ')}" if temporal else "")
                pictures += beside_truth(ctx, label, got, "everything at its best", best)
        error.setdefault("turning", error["at_rest"])
        error.setdefault("flip_turning", error["flip_at_rest"])
        error["rmse_8_bit"] = float(np.hypot(error["at_rest"], error["turning"]) / np.sqrt(2.0))
        error["flip"] = (error.pop("flip_at_rest") + error.pop("flip_turning")) / 2.0
        return Outcome(error, pictures=pictures)

    def turn(seen: View, odd: bool) -> None:
        seen.camera = turned(camera, STEP * odd)

    return redrawn(ctx, scene, seen, judge, turn)


def tables(ctx: Context, points: Sequence[Point]) -> Iterator[Table]:
    """Where each preset lies, scene by scene."""
    rows = []
    for point in points:
        if point.knobs["edges"] != OWN or point.ms is None:
            continue
        same = [p for p in points if p.knobs["scene"] == point.knobs["scene"] and p.ms is not None and p is not point]
        better = [p for p in same if beats(p, point, EXPERIMENT.metric)]
        verdict = ", ".join(f"{p.knobs['preset']} with {p.knobs['edges']}" for p in better)
        rows.append([
            short(str(point.knobs["scene"])), str(point.knobs["preset"]), f"{point.ms.median:.1f}",
            f"{min(point.samples):.1f}", f"{point.error['at_rest']:.2f}", f"{point.error['turning']:.2f}",
            f"{point.error['rmse_8_bit']:.2f}", f"beaten by {verdict}" if verdict else "on the front",
        ])  # fmt: skip
    yield Table(
        "Where the presets lie",
        ["scene", "preset", "median [ms]", "least [ms]", "rmse at rest [8-bit steps]", "turning", "both", "verdict"],
        rows, "Beaten: with 95 % confidence another is quicker with no more error, or nearer and no slower.",
    )  # fmt: skip


EXPERIMENT = Experiment(
    title="Quality presets on the front",
    method="each preset, and the same with each way to smooth edges and with depth first or not; whole frame while the"
    " camera turns",
    truth="the best of every knob, 64 places in each pixel averaged in linear light",
    metric="rmse_8_bit",
    unit="8-bit steps",
    knobs=knobs,
    default={"edges": OWN},  # every one of them
    curve="edges",
    problem="scene",
    run=run,
    tables=tables,
    patience=2.0,
    needs=frozenset({"gpu"}),
    own_scene=True,
    timed="gpu",
    format_floor=Floor(1.0, "one step of 8 bits"),
    time_label="median frame time",
    note="A preset is good where no other point is quicker and nearer. The error is the rms of that at rest and that"
    " in a turn by a quarter of a degree a frame.",
)  # fmt: skip
