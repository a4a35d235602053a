"""How far off is what a slab of glass shows, seen aslant, against Snell's law: bent or not.

A ray leaves the body where its thickness ends, and the picture is looked up there (KHR_materials_volume): right where
what is behind is near the slab, and the less the farther it is. The wall's colour says which place of it a pixel shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.panes import WALL, Slab
from engine.experiments.harness.pixel_truth import radiance, redrawn
from engine.experiments.truth.traced_scene import camera_rays
from engine.render.settings import REFRACTIONS, RenderSettings
from engine.render.view import View
from engine.report.records import Floor, Point, Table

#: (thickness, gap), metres
SLABS = {"thin, near": (0.1, 0.1), "thick, near": (0.5, 0.1), "thick, far": (0.5, 2.0)}
DEFAULT = {"method": "tested"}
#: of the picture, left out at each border: what is beyond cannot be known
BORDER = 0.2


def size(ctx: Context) -> tuple[int, int]:
    return (96, 64) if ctx.quick else (480, 320)


def knobs(ctx: Context) -> list[dict[str, Any]]:
    return [{"slab": slab, "method": method} for slab in SLABS for method in REFRACTIONS]


def pixel_at(slab: Slab, height: int) -> float:
    """Metres of the wall's middle to a pixel."""
    away = np.linalg.norm(slab.camera.position - (0.0, 0.0, slab.wall))
    return float(2.0 * np.tan(slab.camera.yfov / 2.0) * away / height)


def run(ctx: Context, chosen: Knobs) -> Trial:
    assert ctx.device is not None, "the experiment needs a device"
    slab, (width, height) = Slab(*SLABS[str(chosen["slab"])]), size(ctx)
    scene = slab.build(ctx.device)
    settings = RenderSettings(samples=1, tone_map="none", refraction=str(chosen["method"]))
    view = View(scene.camera(width / height), width, height, settings)
    start, d = camera_rays(view.camera, width, height, np.arange(width * height), np.full((width * height, 2), 0.5))
    truth = slab.exact(start, d)
    y, x = np.mgrid[0:height, 0:width]
    inner = (np.minimum(x, width - 1 - x) >= BORDER * width) & (np.minimum(y, height - 1 - y) >= BORDER * height)
    pixel = pixel_at(slab, height)

    def judge() -> Outcome:
        shown = (radiance(scene, view)[:, :2] - 0.5) * 2.0 * WALL
        off = np.linalg.norm(shown - truth, axis=1)[inner.reshape(-1)] / pixel
        per_height = 100.0 / height
        return Outcome({"rms": float(np.sqrt(np.mean(off**2))) * per_height, "worst": float(off.max()) * per_height})

    return redrawn(ctx, scene, view, judge)


def floor(ctx: Context) -> Floor:
    """Places are read out of half floats between 0.25 and 1."""
    slab, (_, height) = Slab(*SLABS["thin, near"]), size(ctx)
    return Floor(float(2.0**-11 * 2.0 * WALL / np.sqrt(12.0) / pixel_at(slab, height) * 100.0 / height), "half floats")


def tables(ctx: Context, points: Sequence[Point]) -> list[Table]:
    rows = [
        [str(p.knobs["slab"]), str(p.knobs["method"]), f"{p.ms.median:.3g}", *(f"{v:.3g}" for v in p.error.values())]
        for p in points if p.ms is not None
    ]  # fmt: skip
    heads = ["slab", "refraction", "ms", *(points[0].error if points else ())]
    return [Table("Places that a slab shows", heads, rows, "Per cent of the picture's height; whole frames.")]


EXPERIMENT = Experiment(
    title="What a slab of glass shows, against Snell's law",
    method="the picture of what is solid, looked up where the refracted ray leaves the body; whole frame",
    truth="rays through a slab of parallel walls, to the wall behind it",
    metric="rms",
    unit="% of the picture's height",
    knobs=knobs,
    default=DEFAULT,
    curve="method",
    problem="slab",
    run=run,
    tables=tables,
    needs=frozenset({"gpu"}),
    timed="gpu",
    noise_floor=floor,
    time_label="median frame time",
    advisory=True,  # the default's test pays where something stands in front of glass, which these slabs lack
    note="No order is expected: how far off it is depends on what is behind the slab, not on work. `tested` costs its"
    " test here and gains nothing: nothing stands in front of these slabs, so `bent` is as good.",
)
