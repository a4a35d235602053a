"""Smooth edges: several samples a pixel, a filter over the finished picture, many frames, against 64 pixels for each.

What one sample a pixel has missed no filter brings back; it only makes steps into slopes. Highlights and textures are
shaded once a pixel in all of them but TAA: their error is in every other point. TAA is judged when the picture has
rested for twice its frames, and while the camera turns by a quarter of a degree a frame; its time is that of one frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import redrawn
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.experiments.picture_lights import has_samples
from engine.math import quat
from engine.math.color import srgb_to_linear, to_u1
from engine.render.camera import Camera
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.metrics import rmse
from engine.report.perceptual import flip
from engine.report.records import Floor

Bytes = NDArray[np.uint8]

SCENES = (MADE + "metals", MADE + "blocks")
#: TAA while the camera turns, by so much a frame, in radians; frames that it has turned for
TURNING, STEP, TURNED = "taa turning", math.radians(0.25), 16
#: pixels of the truth for each pixel, each way
FINER = 8


def size(ctx: Context) -> tuple[int, int]:
    return (128, 96) if ctx.quick else (256, 192)


def scenes(ctx: Context) -> tuple[str, ...]:
    return tuple(own_or(ctx, SCENES[:1] if ctx.quick else SCENES))


def knobs(ctx: Context) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for scene in scenes(ctx):
        found += [{"scene": scene, "form": form, "samples": 1} for form in ("none", "fxaa", "smaa")]
        frames = (16,) if ctx.quick else (4, 8, 16, 32)
        found += [{"scene": scene, "form": form, "samples": n} for form in ("taa", TURNING) for n in frames]
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


def turned(camera: Camera, angle: float) -> Camera:
    """Gone round the world's upright axis."""
    turn = np.eye(4)
    turn[:3, :3] = quat.to_matrix3(quat.from_axis_angle(np.array([0.0, 1.0, 0.0]), angle))
    return replace(camera, world_from_camera=turn @ camera.world_from_camera)


def live(seen: View, form: str, frames: int) -> Iterator[View]:
    """The views of a run of TAA, the last of them as `seen` looks."""
    for left in range(TURNED if form == TURNING else 2 * frames, -1, -1):
        camera = turned(seen.camera, STEP * left) if form == TURNING else seen.camera
        yield replace(seen, camera=camera, seconds=1.0 / 60.0)


def run(ctx: Context, chosen: Knobs) -> Trial:
    name, form, count = str(chosen["scene"]), str(chosen["form"]), int(chosen["samples"])
    width, height = size(ctx)
    scene = open_scene(ctx, name)
    best = ctx.once(f"truth {name}", lambda: truth(scene, width, height))
    temporal = form in ("taa", TURNING)
    how: dict[str, Any] = {
        "samples": 1 if temporal else count,
        "antialias": form if form in ("fxaa", "smaa") else "none",
    }
    if temporal:
        how |= {"antialias": "taa", "taa_frames": count}
    seen = view(scene, width, height, **how)
    if temporal:
        seen.seconds = 1.0 / 60.0

    def judge() -> Outcome:
        for step in live(seen, form, count) if temporal else [seen]:
            got = picture(scene, step)
        label = f"{short(name)}, {form} {count}"
        shown = count in (1, 4, 16) and (form != "taa" or count == 16)
        error = {"rmse_8_bit": rmse(got, best), "flip": flip(got, best)[0]}
        return Outcome(
            error, pictures=beside_truth(ctx, label, got, f"{FINER**2} pixels for one", best) if shown else []
        )

    return redrawn(ctx, scene, seen, judge)


EXPERIMENT = Experiment(
    title="Anti-aliasing against supersampling",
    method="one sample a pixel, with FXAA or SMAA, over frames (TAA), or 2, 4 and 8 samples (MSAA); whole frame",
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
