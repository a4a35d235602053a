"""Shadow maps of the sun against rays to it: cascades, size, filter.

What the picture knows of the sun's visibility is read out of it: with the surroundings off, a pixel with shadows over
the same pixel without is the part of the sun that the renderer lets through. The truth is the part of the sun's disc
that rays from that pixel's place reach; a pixel is misclassified where one says more and the other less than half.
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
from engine.render.settings import RenderSettings
from engine.render.shadows.quality import DEFAULT, FILTER_CHOICES
from engine.render.view import View
from engine.report.perceptual import flip
from engine.report.records import Floor

F8 = NDArray[np.float64]

SCENE = MADE + "blocks"
FILTERS = tuple(f for f in FILTER_CHOICES if f != "auto")
SIZES, CASCADES = (256, 512, 1024, 2048), (1, 2, 3, 4)
#: rays to the sun's disc from each pixel
RAYS = 64


def size(ctx: Context) -> tuple[int, int]:
    return (160, 107) if ctx.quick else (320, 213)


def knobs(ctx: Context) -> list[dict[str, Any]]:
    """Every filter at every size; cascades at the default size and filter; each on every scene."""
    sizes = SIZES[1:3] if ctx.quick else SIZES
    found = []
    for scene in own_or(ctx, [SCENE]):
        base = {"scene": scene, "filter": "auto", "cascades": DEFAULT.cascades, "size": DEFAULT.size}
        rows = [base]
        rows += [{**base, "filter": f, "size": s} for f in FILTERS for s in (SIZES if f == "none" else sizes)]
        rows += [{**base, "cascades": c} for c in CASCADES if c != DEFAULT.cascades]
        found += rows
    return found


def settings(chosen: Knobs, **more: Any) -> RenderSettings:
    """The sun alone."""
    return RenderSettings(
        samples=1, background="color", tone_map="none", environment_intensity=0.0, shadow_filter=str(chosen["filter"]),
        shadow_cascades=int(chosen["cascades"]), shadow_size=int(chosen["size"]), **more,
    )  # fmt: skip


@dataclass(slots=True)
class Lit:
    """The first sun over the picture's pixels. `rows`: pixels (row by row) that it could light; `visible`: the part of
    its disc that each of them sees, of two independent sets of rays; `full`: their brightness without shadows."""

    rows: NDArray[np.int64]
    visible: F8
    noise: float
    full: F8
    rest: F8


def view(ctx: Context, scene: OpenScene, chosen: Knobs, **more: Any) -> View:
    width, height = size(ctx)
    return View(scene.camera(width / height), width, height, settings(chosen, **more))


def light(scene: OpenScene, seen: View) -> F8:
    """Brightness f8[h*w] of a picture."""
    hdr = scene.render(seen, hdr=True).hdr
    assert hdr is not None, "asked for"
    brightness: F8 = np.asarray(hdr.read(), np.float64)[..., :3].sum(axis=-1).ravel()
    return brightness


def truth(ctx: Context, scene: OpenScene, name: str) -> Lit:
    from engine.experiments.truth.reference import content_hash
    from engine.experiments.truth.traced_scene import surface_seen, traced
    from engine.experiments.truth.visibility import sun_visibility

    chosen = {"filter": "none", "cascades": 1, "size": 16}
    bare = view(ctx, scene, chosen, shadows=False)
    world = traced(scene, bare.settings)
    if world.lamps.count == 0 or world.lamps.rows["type"][0] != 0:
        raise InputError(f"{short(name)} has no sun", hint="give a scene with one: its environment's, or a directional")
    own = scene.scene.environment.sun_illuminance > 0.0
    if world.lamps.count > 1 and not own:
        raise InputError(
            f"{short(name)}: its sun cannot be told from its other lights",
            hint="hide them, or let the environment have it",
        )
    width, height = size(ctx)
    met, surface = surface_seen(world, bare.camera, width, height)
    full = light(scene, bare)
    rest = light(scene, view(ctx, scene, chosen, shadows=False, sun_intensity=0.0)) if own else np.zeros_like(full)
    towards = -world.lamps.rows["direction"][0].astype(np.float64)
    towards /= np.linalg.norm(towards)
    half = np.radians(bare.settings.sun_angle) / 2.0
    bright = (full - rest)[met]
    facing = np.minimum(surface.normal @ towards, surface.face @ towards) > 0.05
    # brighter than the picture's half floats are coarse, beside what else is there and by itself
    least = 1e-3 * float(np.percentile(bright, 99.0)) if bright.size else 0.0
    keep = facing & (bright > np.maximum(0.02 * full[met], max(least, 1e-3)))
    if not keep.any():
        raise InputError(f"{short(name)}: the sun lights nothing that is seen", hint="turn the camera or the sun")

    def rays() -> dict[str, Any]:
        at = surface.place[keep]
        both = [
            sun_visibility(world.rays, at, surface.face[keep], towards, half, RAYS, ctx.rng(f"sun {i}")) for i in (0, 1)
        ]
        return {"first": both[0], "second": both[1], "noise_floor": np.sqrt(np.mean((both[0] - both[1]) ** 2)) / 2.0}

    found = ctx.references.get(
        f"sun-{short(name)}",
        {"scene": content_hash(world), "camera": repr((bare.camera.world_from_camera.tolist(), bare.camera.yfov,
         bare.camera.ymag)), "size": size(ctx), "rays": RAYS, "half": half, "kept": keep}, rays, seed=ctx.seed,
    )  # fmt: skip
    rows = np.flatnonzero(met)[keep]
    return Lit(rows, (found["first"] + found["second"]) / 2.0, float(found["noise_floor"]), full, rest)


def prepare(ctx: Context) -> Iterable[tuple[float, str]]:
    names = own_or(ctx, [SCENE])
    for i, name in enumerate(names):
        yield i / len(names), f"rays to the sun, {short(name)}"
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
    turned = [False]

    def work() -> None:
        # another sun than before by a hair, so that maps are drawn again, as they are where anything moves
        turned[0] = not turned[0]
        seen.settings.environment_rotation = 1e-5 if turned[0] else 0.0
        scene.render(seen)
        device.finish()

    def assess(_: object) -> Outcome:
        return judge(ctx, scene, chosen, found)

    return Trial(work, assess, gpu=True, close=scene.close)


def judge(ctx: Context, scene: OpenScene, chosen: Knobs, lit: Lit) -> Outcome:
    got = light(scene, view(ctx, scene, chosen))[lit.rows]
    whole = (lit.full - lit.rest)[lit.rows]
    ours = np.clip((got - lit.rest[lit.rows]) / whole, 0.0, 1.0)
    off = ours - lit.visible
    error = {
        "rmse": float(np.sqrt(np.mean(off**2))), "misclassified": float(np.mean((ours > 0.5) != (lit.visible > 0.5))),
        "too_dark": float(np.mean(off < -0.5)), "too_light": float(np.mean(off > 0.5)),
    }  # fmt: skip
    width, height = size(ctx)
    pictures = []
    canvas = [np.full(width * height, 0.02) for _ in range(2)]
    for values, part in zip(canvas, (ours, lit.visible), strict=True):
        values[lit.rows] = 0.08 + 0.72 * part
    a, b = (to_u1(np.repeat(v.reshape(height, width, 1), 3, axis=2)) for v in canvas)
    error["flip"] = flip(a, b)[0]
    if chosen["size"] == DEFAULT.size and chosen["cascades"] == DEFAULT.cascades:
        pictures = beside_truth(ctx, f"{chosen['filter']}, {chosen['size']}", a, f"{2 * RAYS} rays to the sun", b)
    return Outcome(error, pictures=pictures)


def noise_floor(ctx: Context) -> Floor | None:
    found = [v.noise for k, v in ctx.scratch.items() if isinstance(v, Lit)]
    return Floor(max(found), "the rays' noise") if found else None


EXPERIMENT = Experiment(
    title="Shadows of the sun against rays",
    method="cascaded shadow maps: filter, width in texels, number of cascades; drawn anew for every frame",
    truth="the part of the sun's disc (its setting: 0.53 degrees) that rays from each pixel's place reach",
    metric="rmse",
    unit="visibility",
    knobs=knobs,
    default={"filter": "auto", "cascades": DEFAULT.cascades, "size": DEFAULT.size},
    curve="filter",
    problem="scene",
    run=run,
    prepare=prepare,
    orders=[
        Order(0.5, "an edge is off by part of a texel, and so is the area between: rmse is its root", "1 / texels",
              step=lambda k: 1.0 / float(k["size"]), curve="none", cost=1.0, tolerance=0.2),
    ],
    needs=frozenset({"gpu", "rays"}),
    own_scene=True,
    timed="gpu",
    noise_floor=noise_floor,
    step_label="1 / texels",
    time_label="median frame time",
    note="auto is what the device can afford: one hardware-filtered lookup on a software rasteriser, eight on a GPU.",
)  # fmt: skip
