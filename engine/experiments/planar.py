"""Flat mirrors against a path tracer: pictures of several sizes, the screen's own reflections, the environment alone.

The floor is smooth, a little rough, and rougher. The truth has light of two surfaces, as a mirror's picture has: what
it shows is lit by lamps. Where a pixel does not show the floor, it is the truth's: nothing but mirrors is judged.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pixel_truth import radiance, redrawn
from engine.experiments.harness.scenes import MADE, open_scene, short
from engine.experiments.harness.shown_light import judge_picture, shown_floor, traced_pictures
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.records import Point, Table

SCENES = tuple(MADE + name for name in ("water", "polish", "satin"))
#: method -> settings
METHODS: dict[str, dict[str, Any]] = {
    "environment": {"planar_mirrors": 0},
    "screen": {"planar_mirrors": 0, "reflections": True},
    "planar": {"planar_mirrors": 1},
}
SCALES = (0.25, 0.5, 1.0)
DEFAULT = {"method": "planar", "scale": 1.0}


def size(ctx: Context) -> tuple[int, int, int]:
    """Width, height, paths for each pixel."""
    return (84, 56, 96) if ctx.quick else (240, 160, 256)


def knobs(ctx: Context) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for name in SCENES:
        found += [{"scene": name, "method": method, "scale": 0.0} for method in METHODS if method != "planar"]
        found += [{"scene": name, "method": "planar", "scale": s} for s in (SCALES[1:] if ctx.quick else SCALES)]
    return found


def settings(chosen: Knobs) -> RenderSettings:
    """Scene-linear light alone."""
    how = {**METHODS[str(chosen["method"])], "local_shadows": "all"}
    if chosen["scale"]:
        how["planar_scale"] = float(chosen["scale"])
    return RenderSettings(samples=1, tone_map="none", **how)


def view(ctx: Context, scene: Any, chosen: Knobs) -> View:
    width, height, _ = size(ctx)
    return View(scene.camera(width / height), width, height, settings(chosen))


def prepare(ctx: Context) -> Generator[tuple[float, str], None, None]:
    """Path trace every scene, and find the pixels of its floor."""
    wanted = {name: (name, f"planar-{short(name)}", 2) for name in SCENES}
    yield from traced_pictures(ctx, wanted, size(ctx), lambda *_: settings(DEFAULT))
    for name in SCENES:
        if not isinstance(ctx.scratch[name], LucarnaError):
            ctx.scratch[name, "floor"] = floor_seen(ctx, name)


def floor_seen(ctx: Context, name: str) -> NDArray[np.bool_]:
    """bool[h * w, 1]: whether the pixel's middle shows the scene's floor, which lies at a height of 0."""
    from engine.experiments.truth.traced_scene import surface_seen, traced

    width, height, _ = size(ctx)
    scene = open_scene(ctx, name)
    try:
        met, surface = surface_seen(traced(scene, settings(DEFAULT)), scene.camera(width / height), width, height)
    finally:
        scene.close()
    floor = np.zeros(width * height, np.bool_)
    floor[met] = np.abs(surface.place[:, 1]) < 1e-4
    return floor[:, None]


def run(ctx: Context, chosen: Knobs) -> Trial:
    film = ctx.scratch[chosen["scene"]]
    if isinstance(film, LucarnaError):
        raise film
    scene = open_scene(ctx, str(chosen["scene"]))
    seen = view(ctx, scene, chosen)
    label = f"{short(str(chosen['scene']))}: {chosen['method']}" if chosen["scale"] in (0.0, DEFAULT["scale"]) else ""

    def judge() -> Outcome:
        truth = film.mean.reshape(-1, 3)
        mirrors = np.where(ctx.scratch[chosen["scene"], "floor"], radiance(scene, seen), truth)
        return judge_picture(ctx, mirrors, film.mean, label)

    return redrawn(ctx, scene, seen, judge)


def tables(ctx: Context, points: Sequence[Point]) -> list[Table]:
    rows = []
    for p in points:
        if p.ms is not None:
            what = f"{p.knobs['method']} {p.knobs['scale']:g}" if p.knobs["scale"] else str(p.knobs["method"])
            errors = (f"{p.error[name]:.3g}" for name in ("shown_rmse", "flip", "energy"))
            rows.append([short(str(p.knobs["scene"])), what, f"{p.ms.median:.3g}", *errors])
    heads = ["floor", "what it mirrors", "ms", "display rmse", "FLIP", "energy"]
    return [Table("What a floor mirrors", heads, rows, "Times of whole frames; errors over the picture, of the floor.")]


EXPERIMENT = Experiment(
    title="Flat mirrors against a path tracer",
    method="the scene drawn from behind the floor, blurred by roughness and distance; whole frame",
    truth="path tracing on embree with the same surfaces and lights, of two surfaces",
    metric="shown_rmse",
    unit="display value",
    knobs=knobs,
    default=DEFAULT,
    curve="method",
    problem="scene",
    run=run,
    prepare=prepare,
    tables=tables,
    needs=frozenset({"gpu", "rays"}),
    timed="gpu",
    noise_floor=shown_floor,
    time_label="median frame time",
    note="No order is expected: what one picture shows is exact, and how a lobe widens on its way is a model.",
)
