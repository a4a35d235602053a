"""Ambient occlusion against rays: method, places looked at, half size.

The picture's view of that name is the visibility itself. The truth is the cosine-weighted part of the hemisphere over
each pixel's facet that rays find free, where what they meet counts less with its distance by the fall-off of the
methods: so an infinite number of samples would still leave what depth does not show, and the method's own bias.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import (
    PixelTruth,
    by_rays,
    greys,
    radiance,
    redrawn,
    truth,
    truths,
    worst_noise,
)
from engine.experiments.harness.pixel_truth import picture_size as size
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.render.occlusion import METHODS, radius_of
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.perceptual import flip

F8 = NDArray[np.float64]

SCENES = (MADE + "room", MADE + "blocks")
#: (directions, steps) of horizons; places of the spiral
SLICES, PLACES = ((1, 2), (1, 4), (2, 4), (3, 4), (2, 8), (4, 8), (8, 16)), (4, 8, 16, 32, 64)
RAYS = 64


def knobs(ctx: Context) -> list[dict[str, Any]]:
    """Every method at every number of places; the default at half size; on every scene."""
    default = RenderSettings()
    slices, places = (SLICES[1::2], PLACES[::2]) if ctx.quick else (SLICES, PLACES)
    found: list[dict[str, Any]] = []
    for scene in scenes(ctx):
        rows: list[dict[str, Any]] = [
            {"method": m, "directions": d, "steps": s, "half": False} for m in ("gtao", "hbao") for d, s in slices
        ]
        rows += [{"method": "alchemy", "directions": 1, "steps": n, "half": False} for n in places]
        rows += [{"method": "gtao", "directions": d, "steps": s, "half": True} for d, s in slices]
        own = {"method": METHODS[-1], "directions": default.ao_directions, "steps": default.ao_steps, "half": False}
        found += [{"scene": scene, **row} for row in (rows if own in rows else [own, *rows])]
    return found


def scenes(ctx: Context) -> list[str]:
    return own_or(ctx, SCENES[:1] if ctx.quick else SCENES)


def settings(chosen: Knobs) -> RenderSettings:
    return RenderSettings(
        samples=1, view="ambient_occlusion", ambient_occlusion=str(chosen["method"]), shadows=False,
        ao_directions=int(chosen["directions"]), ao_steps=int(chosen["steps"]), ao_half=bool(chosen["half"]),
    )  # fmt: skip


def view(ctx: Context, scene: OpenScene, chosen: Knobs) -> View:
    width, height = size(ctx)
    return View(scene.camera(width / height), width, height, settings(chosen))


def seen(ctx: Context, scene: OpenScene, name: str) -> PixelTruth:
    from engine.experiments.truth.traced_scene import surface_seen, traced
    from engine.experiments.truth.visibility import ambient_occlusion

    bare = view(ctx, scene, {"method": "gtao", "directions": 1, "steps": 1, "half": False})
    world = traced(scene, bare.settings)
    met, surface = surface_seen(world, bare.camera, *size(ctx))
    if not met.any():
        raise InputError(f"{short(name)}: nothing solid is seen", hint="turn the camera")
    radius = radius_of(bare.settings, *scene.scene.bounds())

    def rays(which: str) -> F8:
        turned = ctx.rng(f"ao {which}")
        return ambient_occlusion(world.rays, surface.place, surface.face, RAYS, turned, radius, fades=True)

    key = {"rays": RAYS, "radius": radius}
    visible, noise = by_rays(ctx, f"ao-{short(name)}", world, bare.camera, size(ctx), key, rays)
    return PixelTruth(np.flatnonzero(met), visible, noise)


def prepare(ctx: Context) -> Iterable[tuple[float, str]]:
    problems = [(name, name) for name in scenes(ctx)]
    return truths(ctx, problems, "rays into the surroundings", lambda scene, name, _: seen(ctx, scene, name))


def run(ctx: Context, chosen: Knobs) -> Trial:
    name = str(chosen["scene"])
    found = truth(ctx, name)
    scene = open_scene(ctx, name)
    return redrawn(ctx, scene, view(ctx, scene, chosen), lambda: judge(ctx, scene, chosen, found))


def judge(ctx: Context, scene: OpenScene, chosen: Knobs, found: PixelTruth) -> Outcome:
    ours = radiance(scene, view(ctx, scene, chosen))[found.rows, 0]
    off = ours - found.value
    a, b = greys(size(ctx), found.rows, ours, found.value)
    error = {
        "rmse": float(np.sqrt(np.mean(off**2))), "bias": float(np.mean(off)), "flip": flip(a, b)[0],
        "worst": float(np.abs(off).max()),
    }  # fmt: skip
    pictures = []
    if (chosen["directions"], chosen["steps"]) in ((2, 8), (1, 16)):
        label = f"{chosen['method']}{', half size' if chosen['half'] else ''}"
        pictures = beside_truth(ctx, label, a, f"{2 * RAYS} rays", b)
    return Outcome(error, pictures=pictures)


EXPERIMENT = Experiment(
    title="Ambient occlusion against rays",
    method="from depth alone: horizons in slices (gtao, hbao) or a spiral of places (alchemy); whole frame",
    truth="cosine-weighted visibility by rays from each pixel's place, with the methods' fall-off",
    metric="rmse",
    unit="visibility",
    knobs=knobs,
    default={"method": METHODS[-1], "directions": 2, "steps": 8, "half": False},
    curve="method",
    problem="scene",
    run=run,
    prepare=prepare,
    orders=[
        Order(0.0, "depth shows fronts only: more places end at the method's bias", "places",
              step=lambda k: 1.0 / (float(k["directions"]) * float(k["steps"])), curve="alchemy", tolerance=0.5),
    ],
    needs=frozenset({"gpu", "rays"}),
    own_scene=True,
    timed="gpu",
    noise_floor=worst_noise,
    step_label="1 / places",
    time_label="median frame time",
)  # fmt: skip
