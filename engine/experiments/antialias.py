"""Smooth edges: several samples a pixel, a filter over the finished picture, many frames, against 64 pixels for each.

What one sample a pixel has missed no filter brings back; it only makes steps into slopes. Highlights and textures are
shaded once a pixel in all of them but TAA: their error is in every other point. A choice must hold in motion: every
mode is judged by the worse of two errors, of a picture that has rested for twice the frames that TAA gathers and of the
last one of a turn by a quarter of a degree a frame. Its time is that of one frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.moving_shapes import edges, left_behind, thin_line
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
from engine.report.records import Floor, Point, Table

Bytes = NDArray[np.uint8]

SCENES = (MADE + "metals", MADE + "blocks")
#: radians that the camera turns by in a frame; frames that it has turned for
STEP, TURNED = math.radians(0.25), 16
#: pixels of the truth for each pixel, each way
FINER = 8
#: degrees that an edge is turned by
ANGLES = (0.0, 2.0, 7.0, 14.0, 22.0, 31.0, 35.0, 40.0, 43.5, 45.0)


def size(ctx: Context) -> tuple[int, int]:
    return (128, 96) if ctx.quick else (256, 192)


def scenes(ctx: Context) -> tuple[str, ...]:
    return tuple(own_or(ctx, SCENES[:1] if ctx.quick else SCENES))


def knobs(ctx: Context) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for scene in scenes(ctx):
        found += [{"scene": scene, "form": form, "samples": 1} for form in ("none", "fxaa", "smaa")]
        frames = (16,) if ctx.quick else (4, 8, 16, 32)
        found += [{"scene": scene, "form": "taa", "samples": n} for n in frames]
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


def live(seen: View, frames: int, *, turning: bool = False) -> Iterator[View]:
    """The views of a run of pictures that begins with a cut, the last of them as `seen` looks."""
    for left in range(TURNED if turning else 2 * frames, -1, -1):
        camera = turned(seen.camera, STEP * left) if turning else seen.camera
        yield replace(seen, camera=camera, seconds=1.0 / 60.0, cut=left == (TURNED if turning else 2 * frames))


def run(ctx: Context, chosen: Knobs) -> Trial:
    name, form, count = str(chosen["scene"]), str(chosen["form"]), int(chosen["samples"])
    width, height = size(ctx)
    scene = open_scene(ctx, name)
    best = ctx.once(f"truth {name}", lambda: truth(scene, width, height))
    temporal = form == "taa"
    how: dict[str, Any] = {
        "samples": 1 if temporal else count,
        "antialias": form if form != "msaa" else "none",
        "taa_frames": count if temporal else RenderSettings().taa_frames,
    }
    seen = view(scene, width, height, **how)
    seen.seconds = 1.0 / 60.0

    def judge() -> Outcome:
        label, error, pictures = f"{short(name)}, {form} {count}", {}, []
        for where, turning in (("at_rest", False), ("turning", True)):
            for step in live(seen, count if temporal else 0, turning=turning):
                got = picture(scene, step)
            error[where], error[f"flip_{where}"] = rmse(got, best), flip(got, best)[0]
            if count == (16 if temporal else min(count, 4)) and (temporal or not turning):
                told = f"{label}, {where.replace('_', ' ')}"
                pictures += beside_truth(ctx, told, got, f"{FINER**2} pixels for one", best)
        error["rmse_8_bit"] = max(error["at_rest"], error["turning"])
        error["flip"] = max(error.pop("flip_at_rest"), error.pop("flip_turning"))
        return Outcome(error, pictures=pictures)

    return redrawn(ctx, scene, seen, judge)


def tables(ctx: Context, points: Sequence[Point]) -> Iterator[Table]:
    """Both errors of every mode: which of them it is judged by."""
    for scene in scenes(ctx):
        rows = [
            [
                f"{p.knobs['form']} {p.knobs['samples']}", f"{p.error['at_rest']:.2f}", f"{p.error['turning']:.2f}",
                f"{p.error['rmse_8_bit']:.2f}", f"{p.ms.median:.2f}" if p.ms else "",
            ]
            for p in points
            if p.status == "ok" and p.knobs["scene"] == scene
        ]  # fmt: skip
        yield Table(
            f"{short(scene)}: at rest and while the camera turns by {math.degrees(STEP):g} degrees a frame",
            ["mode", "rmse at rest [8-bit steps]", "turning", "the worse", "time [ms]"], rows,
            "What keeps nothing between frames has one picture for both: the last one of the turn looks from the same"
            " place.",
        )  # fmt: skip
    yield by_angle(ctx)
    yield memory()
    yield in_motion(ctx)


def modes(ctx: Context) -> dict[str, dict[str, Any]]:
    """The ways to smooth edges, by name."""
    found: dict[str, dict[str, Any]] = {"none": {"samples": 1}}
    if not ctx.quick:
        found["fxaa"] = {"samples": 1, "antialias": "fxaa"}
        found["smaa, lines alone"] = {"samples": 1, "antialias": "smaa", "smaa_patterns": "lines"}
        found["smaa"] = {"samples": 1, "antialias": "smaa"}
        found["taa 16, thin 0"] = {"samples": 1, "antialias": "taa", "taa_frames": 16, "taa_thin": 0.0}
    found["taa 16"] = {"samples": 1, "antialias": "taa", "taa_frames": 16}
    return found | {f"msaa {n}": {"samples": n} for n in ((4,) if ctx.quick else (4, 8)) if has_samples(ctx, n)}


def by_angle(ctx: Context) -> Table:
    """One edge and four corners: where filters of the finished picture know what they see, and where not."""
    assert ctx.device is not None, "the experiment needs a device"
    angles = (0.0, 35.0) if ctx.quick else ANGLES
    rows = []
    for mode, how in modes(ctx).items():
        found = [edges(ctx.device, how, math.radians(angle)) for angle in angles]
        rows.append(
            [mode, *(f"{error:.1f}" for error in found), f"{math.sqrt(sum(e * e for e in found) / len(found)):.1f}"]
        )
    return Table(
        "A bright card, turned by so many degrees: rmse of the pixels that it covers in part",
        ["mode", *(f"{angle:g}" for angle in angles), "rms of all"], rows,
        "In 255ths of the card's light, at rest, against the covered parts of pixels. With 0 its edges are upright.",
    )  # fmt: skip


def memory() -> Table:
    """What TAA keeps from frame to frame."""
    width, height = 1920, 1080
    kept = (("mean of the frames", "rgba16f", 8), ("what was seen: depth, what flickers, motion", "rgba16f", 8))
    rows = [[what, form, f"{2 * size * width * height / 1e6:.0f}"] for what, form, size in kept]
    rows.append(["motion", "rg16f", f"{4 * width * height / 1e6:.0f}"])
    return Table(
        f"What TAA holds at {width}x{height}", ["texture", "format", "MB"], rows, "Kept ones twice: old and new."
    )


def in_motion(ctx: Context) -> Table:
    """What a frame drags along, and what becomes of a line thinner than a pixel."""
    assert ctx.device is not None, "the experiment needs a device"
    rows = []
    for mode, how in modes(ctx).items():
        still, moving = thin_line(ctx.device, how, 0.0), thin_line(ctx.device, how)
        # what keeps nothing between frames knows nothing of others
        restless = thin_line(ctx.device, how, 0.0, restless=True) if how.get("antialias") == "taa" else still
        rows.append([
            mode, f"{100.0 * left_behind(ctx.device, how):.2g} %",
            *(f"{100.0 * line.light:.3g} %" for line in (still, moving, restless)),
            f"{100.0 * moving.flicker:.2g} %", f"{100.0 * moving.gaps:.2g} %",
        ])  # fmt: skip
    return Table(
        "What moves: a card that goes 3 pixels a frame, and a line of half a pixel that goes a third of one",
        ["mode", "light left behind the card", "light of the line at rest", "moving", "at rest, others move",
         "flickers by", "missing"], rows,
        "Left behind: the brightest pixel that the card is not near any more, of the card's light. The line: of"
        " the light that it has; standard deviation from frame to frame while it moves; columns with less than a"
        " quarter of it then.",
    )  # fmt: skip


EXPERIMENT = Experiment(
    title="Anti-aliasing against supersampling",
    method="one sample a pixel, with FXAA or SMAA, over frames (TAA), or 2, 4 and 8 samples (MSAA); whole frame; the"
    " worse of at rest and turning",
    truth="64 pixels for each pixel, averaged in linear light after the tone map",
    metric="rmse_8_bit",
    unit="8-bit steps",
    knobs=knobs,
    default={"form": "msaa", "samples": 4},
    curve="form",
    problem="scene",
    run=run,
    tables=tables,
    needs=frozenset({"gpu"}),
    own_scene=True,
    timed="gpu",
    format_floor=Floor(1.0, "one step of 8 bits"),
    time_label="median frame time",
    note="No order is expected: edges by n samples fall between n^-1/2 and n^-3/4, but what is not an edge (highlights,"
    " textures) is shaded once a pixel whatever n is, and stays as an error.",
)  # fmt: skip
