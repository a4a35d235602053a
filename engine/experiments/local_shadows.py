"""Shadows of point and spot lights against rays to them: width of the atlas, filter.

One light shines at a time. With shadows over without is the part of it that the renderer lets through to a pixel; the
truth is one ray from the pixel's place to the light, which has no extent. So a filter, which makes an edge soft, costs
rmse here and moves no edge: `misclassified` counts pixels where one says more and the other less than half.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from engine.core.errors import InputError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import (
    PixelTruth,
    brightness,
    greys,
    redrawn,
    shadow_errors,
    truth,
    truths,
)
from engine.experiments.harness.pixel_truth import picture_size as size
from engine.experiments.harness.scenes import LIVE, MADE, open_scene, own_or, short
from engine.experiments.sun_shadows import by_kind
from engine.render.settings import RenderSettings
from engine.render.shadows.quality import FILTERS
from engine.render.view import View
from engine.report.perceptual import flip
from engine.scene.lights import LIGHT_TYPES

SCENES = (MADE + "room",)
LIGHTS = ("spot", "point")
SIZES = (256, 512, 1024, 2048, 4096)
SIZE = 2048  # what RenderSettings has


def knobs(ctx: Context) -> list[dict[str, Any]]:
    """Each kind of light by what views have, without a filter at every size, and by every filter at two."""
    sizes = SIZES[1:4] if ctx.quick else SIZES
    found: list[dict[str, Any]] = []
    for scene in own_or(ctx, SCENES):
        for light in LIGHTS:
            base = {"scene": scene, "light": light}
            rows = [{**base, "filter": "auto", "size": SIZE}]
            rows += [{**base, "filter": "none", "size": s} for s in sizes]
            if not ctx.quick:
                rows += [{**base, "filter": f, "size": s} for f in FILTERS if f != "none" for s in (SIZES[2], SIZE)]
            found += rows
    return by_kind(found)


def alone(scene: OpenScene, name: str, kind: str) -> None:
    """Leave the first light of `kind` on, alone, and no surroundings."""
    lights = scene.scene.lights
    rows = lights.shining()
    fit = rows[lights.type[rows] == LIGHT_TYPES.index(kind)]
    if len(fit) == 0:
        raise InputError(f"{short(name)} has no {kind} light", hint=f"give a scene with a {kind} light that shines")
    if len(rows) > 1 and name == LIVE:
        raise InputError(
            f"{short(name)}: its {kind} light cannot be told from its other lights",
            hint="hide them, or save the scene and give the file",
        )
    for row in rows[rows != fit[0]]:
        lights.set(int(row), intensity=0.0)
    scene.scene.update()


def view(ctx: Context, scene: OpenScene, chosen: Knobs, shadows: str) -> View:
    width, height = size(ctx)
    settings = RenderSettings(
        samples=1, background="color", tone_map="none", environment_intensity=0.0, sun_intensity=0.0, shadows=False,
        shadow_filter=str(chosen["filter"]), local_shadows=shadows, local_shadow_size=int(chosen["size"]),
    )  # fmt: skip
    return View(scene.camera(width / height), width, height, settings)


def lit(ctx: Context, scene: OpenScene, name: str, kind: str) -> PixelTruth:
    """`drawn`: the picture without shadows."""
    from engine.experiments.truth.traced_scene import lifted, surface_seen, traced

    alone(scene, name, kind)
    bare = view(ctx, scene, {"filter": "none", "size": SIZE}, "off")
    world = traced(scene, bare.settings)
    met, surface = surface_seen(world, bare.camera, *size(ctx))
    full = brightness(scene, bare)
    lamp = scene.scene.lights.world()[0]
    to = lamp["position"] - surface.place
    distance = np.linalg.norm(to, axis=1)
    towards = to / np.maximum(distance, 1e-12)[:, None]
    facing = np.minimum((surface.normal * towards).sum(axis=1), (surface.face * towards).sum(axis=1)) > 0.05
    bright = full[met]
    # brighter than the picture's half floats are coarse
    keep = facing & (bright > max(1e-3 * float(np.percentile(bright, 99.0)) if bright.size else 0.0, 1e-4))
    if not keep.any():
        raise InputError(f"{short(name)}: the {kind} light lights nothing that is seen", hint="turn the camera")
    start = lifted(surface.place[keep], surface.face[keep], towards[keep], world.rays.lift)
    blocked = world.rays.blocked(start, towards[keep], distance[keep] * (1.0 - 1e-5))
    return PixelTruth(np.flatnonzero(met)[keep], 1.0 - blocked.astype(np.float64), 0.0, (full,))


def prepare(ctx: Context) -> Iterable[tuple[float, str]]:
    problems = [(name, f"{name} {kind}") for name in own_or(ctx, SCENES) for kind in LIGHTS]
    return truths(
        ctx, problems, "rays to a light", lambda scene, name, key: lit(ctx, scene, name, key.rpartition(" ")[2])
    )


def run(ctx: Context, chosen: Knobs) -> Trial:
    name, kind = str(chosen["scene"]), str(chosen["light"])
    found = truth(ctx, f"{name} {kind}")
    scene = open_scene(ctx, name)
    alone(scene, name, kind)
    seen = view(ctx, scene, chosen, "all")
    return redrawn(ctx, scene, seen, lambda: judge(ctx, scene, chosen, found), another_filter)


def another_filter(seen: View, odd: bool) -> None:
    """A hair's breadth of the filter makes another view of a tile, so that it is drawn again."""
    seen.settings.shadow_softness = 1.5 + 1e-5 * odd


def judge(ctx: Context, scene: OpenScene, chosen: Knobs, found: PixelTruth) -> Outcome:
    got = brightness(scene, view(ctx, scene, chosen, "all"))[found.rows]
    ours = np.clip(got / found.drawn[0][found.rows], 0.0, 1.0)
    error = shadow_errors(ours, found.value)
    a, b = greys(size(ctx), found.rows, ours, found.value)
    error["flip"] = flip(a, b)[0]
    pictures = []
    if chosen["size"] == SIZE and chosen["filter"] != "auto":
        caption = f"{short(str(chosen['scene']))}, {chosen['light']}: {chosen['filter']}"
        pictures = beside_truth(ctx, caption, a, "a ray to the light", b)
    return Outcome(error, pictures=pictures)


EXPERIMENT = Experiment(
    title="Shadows of point and spot lights against rays",
    method="tiles of one depth map: width of the map (one light has half of it, or six quarters), filter; drawn anew",
    truth="a ray from each pixel's place to the light",
    metric="misclassified",
    unit="of lit pixels",
    knobs=knobs,
    default={"filter": "auto", "size": SIZE},
    curve="kind",
    problem="light",
    run=run,
    prepare=prepare,
    orders=[
        Order(1.0, "an edge is off by part of a texel, and so is the area between", "1 / texels",
              step=lambda k: 1.0 / float(k["size"]), curve="none", cost=1.0, tolerance=0.5),
    ],
    needs=frozenset({"gpu", "rays"}),
    own_scene=True,
    timed="gpu",
    step_label="1 / texels",
    time_label="median frame time",
)  # fmt: skip
