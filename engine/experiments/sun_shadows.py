"""Shadow maps of the sun against rays to it: cascades, size, filter.

What the picture knows of the sun's visibility is read out of it: with the surroundings off, a pixel with shadows over
the same pixel without is the part of the sun that the renderer lets through. The truth is the part of the sun's disc
that rays from that pixel's place reach; a pixel is misclassified where one says more and the other less than half.
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
    brightness,
    by_rays,
    greys,
    redrawn,
    shadow_errors,
    truth,
    truths,
    worst_noise,
)
from engine.experiments.harness.pixel_truth import picture_size as size
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.render.settings import RenderSettings
from engine.render.shadows.quality import DEFAULT, FILTER_CHOICES
from engine.render.view import View
from engine.report.perceptual import flip

F8 = NDArray[np.float64]

SCENE = MADE + "blocks"
FILTERS = tuple(f for f in FILTER_CHOICES if f != "auto")
SIZES, CASCADES = (256, 512, 1024, 2048), (1, 2, 3, 4)
#: rays to the sun's disc from each pixel
RAYS = 64


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


def view(ctx: Context, scene: OpenScene, chosen: Knobs, **more: Any) -> View:
    width, height = size(ctx)
    return View(scene.camera(width / height), width, height, settings(chosen, **more))


def lit(ctx: Context, scene: OpenScene, name: str) -> PixelTruth:
    """`drawn`: pictures without shadows, and with what shines besides the sun."""
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
    met, surface = surface_seen(world, bare.camera, *size(ctx))
    full = brightness(scene, bare)
    rest = np.zeros_like(full)
    if own:
        rest = brightness(scene, view(ctx, scene, chosen, shadows=False, sun_intensity=0.0))
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

    def rays(which: str) -> F8:
        at, face = surface.place[keep], surface.face[keep]
        return sun_visibility(world.rays, at, face, towards, half, RAYS, ctx.rng(f"sun {which}"))

    key = {"rays": RAYS, "half": half, "kept": keep}
    visible, noise = by_rays(ctx, f"sun-{short(name)}", world, bare.camera, size(ctx), key, rays)
    return PixelTruth(np.flatnonzero(met)[keep], visible, noise, (full, rest))


def prepare(ctx: Context) -> Iterable[tuple[float, str]]:
    problems = [(name, name) for name in own_or(ctx, [SCENE])]
    return truths(ctx, problems, "rays to the sun", lambda scene, name, _: lit(ctx, scene, name))


def run(ctx: Context, chosen: Knobs) -> Trial:
    name = str(chosen["scene"])
    found = truth(ctx, name)
    scene = open_scene(ctx, name)
    return redrawn(ctx, scene, view(ctx, scene, chosen), lambda: judge(ctx, scene, chosen, found), another_sun)


def another_sun(seen: View, odd: bool) -> None:
    """By a hair, so that maps are drawn again, as they are where anything moves."""
    seen.settings.environment_rotation = 1e-5 if odd else 0.0


def judge(ctx: Context, scene: OpenScene, chosen: Knobs, found: PixelTruth) -> Outcome:
    full, rest = (part[found.rows] for part in found.drawn)
    got = brightness(scene, view(ctx, scene, chosen))[found.rows]
    ours = np.clip((got - rest) / (full - rest), 0.0, 1.0)
    error = shadow_errors(ours, found.value)
    a, b = greys(size(ctx), found.rows, ours, found.value)
    error["flip"] = flip(a, b)[0]
    pictures = []
    if chosen["size"] == DEFAULT.size and chosen["cascades"] == DEFAULT.cascades:
        pictures = beside_truth(ctx, f"{chosen['filter']}, {chosen['size']}", a, f"{2 * RAYS} rays to the sun", b)
    return Outcome(error, pictures=pictures)


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
    noise_floor=worst_noise,
    step_label="1 / texels",
    time_label="median frame time",
    note="auto is what the device can afford: one hardware-filtered lookup on a software rasteriser, eight on a GPU.",
)  # fmt: skip
