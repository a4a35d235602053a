"""Ambient occlusion against rays: method, places looked at, half size.

The picture's view of that name is the visibility itself. The truth is the cosine-weighted part of the hemisphere over
each pixel's facet that rays find free, where what they meet counts less with its distance by the fall-off of the
methods: so an infinite number of samples would still leave what depth does not show, and the method's own bias.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError, LucarnaError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.math.color import to_u1
from engine.render.occlusion import METHODS, radius_of
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.perceptual import flip
from engine.report.records import Floor

F8 = NDArray[np.float64]

SCENES = (MADE + "room", MADE + "blocks")
#: (directions, steps) of horizons; places of the spiral
SLICES, PLACES = ((1, 2), (1, 4), (2, 4), (3, 4), (2, 8), (4, 8), (8, 16)), (4, 8, 16, 32, 64)
RAYS = 64


def size(ctx: Context) -> tuple[int, int]:
    return (160, 107) if ctx.quick else (320, 213)


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


@dataclass(slots=True)
class Seen:
    """`rows`: pixels that show a surface; `visible`: the truth there, of two sets of rays; `noise`: their rmse."""

    rows: NDArray[np.int64]
    visible: F8
    noise: float


def view(ctx: Context, scene: OpenScene, chosen: Knobs) -> View:
    width, height = size(ctx)
    return View(scene.camera(width / height), width, height, settings(chosen))


def truth(ctx: Context, scene: OpenScene, name: str) -> Seen:
    from engine.experiments.truth.reference import content_hash
    from engine.experiments.truth.traced_scene import surface_seen, traced
    from engine.experiments.truth.visibility import ambient_occlusion

    bare = view(ctx, scene, {"method": "gtao", "directions": 1, "steps": 1, "half": False})
    world = traced(scene, bare.settings)
    width, height = size(ctx)
    met, surface = surface_seen(world, bare.camera, width, height)
    if not met.any():
        raise InputError(f"{short(name)}: nothing solid is seen", hint="turn the camera")
    radius = radius_of(bare.settings, *scene.scene.bounds())

    def rays() -> dict[str, Any]:
        both = [
            ambient_occlusion(world.rays, surface.place, surface.face, RAYS, ctx.rng(f"ao {i}"), radius, fades=True)
            for i in (0, 1)
        ]
        return {"first": both[0], "second": both[1], "noise_floor": np.sqrt(np.mean((both[0] - both[1]) ** 2)) / 2.0}

    found = ctx.references.get(
        f"ao-{short(name)}",
        {"scene": content_hash(world), "camera": repr((bare.camera.world_from_camera.tolist(), bare.camera.yfov,
         bare.camera.ymag)), "size": size(ctx), "rays": RAYS, "radius": radius}, rays, seed=ctx.seed,
    )  # fmt: skip
    return Seen(np.flatnonzero(met), (found["first"] + found["second"]) / 2.0, float(found["noise_floor"]))


def prepare(ctx: Context) -> Iterable[tuple[float, str]]:
    names = scenes(ctx)
    for i, name in enumerate(names):
        yield i / len(names), f"rays into the surroundings, {short(name)}"
        try:
            scene = open_scene(ctx, name)
            try:
                ctx.scratch[name] = truth(ctx, scene, name)
            finally:
                scene.close()
        except LucarnaError as error:
            ctx.scratch[name] = error


def run(ctx: Context, chosen: Knobs) -> Trial:
    name = str(chosen["scene"])
    found = ctx.scratch[name]
    if isinstance(found, LucarnaError):
        raise found
    assert ctx.device is not None, "the experiment needs a device"
    device, scene = ctx.device, open_scene(ctx, name)
    seen = view(ctx, scene, chosen)

    def work() -> None:
        scene.render(seen)
        device.finish()

    def assess(_: object) -> Outcome:
        return judge(ctx, scene, chosen, found)

    return Trial(work, assess, gpu=True, close=scene.close)


def judge(ctx: Context, scene: OpenScene, chosen: Knobs, truth: Seen) -> Outcome:
    hdr = scene.render(view(ctx, scene, chosen), hdr=True).hdr
    assert hdr is not None, "asked for"
    width, height = size(ctx)
    ours = np.asarray(hdr.read(), np.float64)[..., 0].ravel()[truth.rows]
    off = ours - truth.visible
    canvas = [np.full(width * height, 0.02) for _ in range(2)]
    for values, part in zip(canvas, (ours, truth.visible), strict=True):
        values[truth.rows] = 0.8 * np.clip(part, 0.0, 1.0)
    a, b = (to_u1(np.repeat(v.reshape(height, width, 1), 3, axis=2)) for v in canvas)
    error = {
        "rmse": float(np.sqrt(np.mean(off**2))), "bias": float(np.mean(off)), "flip": flip(a, b)[0],
        "worst": float(np.abs(off).max()),
    }  # fmt: skip
    pictures = []
    if (chosen["directions"], chosen["steps"]) in ((2, 8), (1, 16)):
        label = f"{chosen['method']}{', half size' if chosen['half'] else ''}"
        pictures = beside_truth(ctx, label, a, f"{2 * RAYS} rays", b)
    return Outcome(error, pictures=pictures)


def noise_floor(ctx: Context) -> Floor | None:
    found = [v.noise for v in ctx.scratch.values() if isinstance(v, Seen)]
    return Floor(max(found), "the rays' noise") if found else None


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
    noise_floor=noise_floor,
    step_label="1 / places",
    time_label="median frame time",
)  # fmt: skip
