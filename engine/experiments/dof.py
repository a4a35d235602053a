"""Depth of field against a lens: the mean of pictures from all over it, each with the plane of focus held still.

The error of a pinhole (`off`) is that of leaving the blur out. What is hidden from the middle of the lens and seen from
its rim is in no single picture: that error stays, however many places are looked at.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import radiance, redrawn
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.math.color import to_u1
from engine.render.focus import lens_width, pixels_per_slope
from engine.render.motion.jitter import pixel_jitter
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.perceptual import flip

F8 = NDArray[np.float64]

SCENES = (MADE + "blocks", MADE + "metals")
TAPS = (16, 32, 64, 128)
#: in focus, of the distance to the middle of the scene; pixels of height that a point half as far off as that is wide
NEARER, WIDE = 0.6, 0.08
GOLDEN = math.pi * (3.0 - math.sqrt(5.0))


def size(ctx: Context) -> tuple[int, int]:
    return (160, 107) if ctx.quick else (320, 213)


def lens_places(ctx: Context) -> int:
    return 48 if ctx.quick else 256


def knobs(ctx: Context) -> list[dict[str, Any]]:
    taps = (64,) if ctx.quick else TAPS
    return [
        {"scene": scene, "form": form, "taps": n}
        for scene in own_or(ctx, SCENES[:1] if ctx.quick else SCENES)
        for form, counts in (("gathered", taps), ("off", (0,)))
        for n in counts
    ]


def view(ctx: Context, scene: OpenScene, **settings: Any) -> View:
    width, height = size(ctx)
    return View(scene.camera(width / height), width, height, RenderSettings(samples=1, anisotropy=16.0, **settings))


def lens(ctx: Context, scene: OpenScene) -> dict[str, Any]:
    """Settings of a lens that is wide enough to see what it does, whatever the scene's size."""
    bare = view(ctx, scene)
    low, high = scene.scene.bounds()
    camera = bare.camera
    focus = NEARER * max(float(((low + high) / 2.0 - camera.position) @ -camera.world_from_camera[:3, 2]), 1e-3)
    unit = lens_width(camera, RenderSettings(sensor=1.0, f_stop=1.0)) * pixels_per_slope(camera, bare.height) / focus
    wanted = WIDE * bare.height / unit
    return {"depth_of_field": True, "focus": focus, "sensor": min(wanted, 1000.0), "f_stop": max(1000.0 / wanted, 0.5)
            if wanted > 1000.0 else 1.0}  # fmt: skip


def truth(ctx: Context, scene: OpenScene) -> F8:
    """f8[h*w,3]: the mean over the lens."""
    chosen = lens(ctx, scene)
    bare, count = view(ctx, scene), lens_places(ctx)
    camera, focus = bare.camera, float(chosen["focus"])
    radius, pixels = lens_width(camera, RenderSettings(**chosen)) / 2.0, pixels_per_slope(camera, bare.height)
    total = np.zeros((bare.width * bare.height, 3))
    for i in range(count):
        off = radius * math.sqrt((i + 0.5) / count)
        u, v = off * math.cos(i * GOLDEN), off * math.sin(i * GOLDEN)
        pose = camera.world_from_camera.copy()
        pose[:3, 3] += u * pose[:3, 0] + v * pose[:3, 1]
        moved = replace(camera, world_from_camera=pose)
        x, y = pixel_jitter(i, count)  # what is in focus is smooth, too
        total += radiance(scene, replace(bare, camera=moved, shift=(x + u * pixels / focus, y - v * pixels / focus)))
    return total / count


def run(ctx: Context, chosen: Knobs) -> Trial:
    name = str(chosen["scene"])
    scene = open_scene(ctx, name)
    best = ctx.once(f"lens {name}", lambda: truth(ctx, scene))
    on = {**lens(ctx, scene), "focus_taps": int(chosen["taps"])} if chosen["form"] == "gathered" else {}
    # edges that are sharp are smooth in both, so that the blur is what differs
    still = view(ctx, scene, antialias="taa", taa_frames=8, **on)
    seen = replace(still, seconds=1.0 / 60.0)

    def judge() -> Outcome:
        ours = radiance(scene, still)
        a, b = (to_u1(np.clip(c, 0.0, 1.0).reshape(seen.height, seen.width, 3)) for c in (ours, best))
        off = np.clip(ours, 0.0, 1.0) - np.clip(best, 0.0, 1.0)
        error = {
            "rmse": float(np.sqrt(np.mean(off**2))), "flip": flip(a, b)[0],
            "lost": float(1.0 - ours.sum() / best.sum()),
        }  # fmt: skip
        label = f"{short(name)}, {chosen['form']} {chosen['taps']}"
        shown = chosen["taps"] in (0, 64)
        return Outcome(
            error, pictures=beside_truth(ctx, label, a, f"{lens_places(ctx)} places of the lens", b) if shown else []
        )

    return redrawn(ctx, scene, seen, judge)


EXPERIMENT = Experiment(
    title="Depth of field against a lens",
    method="gathered at half size, what is before the plane of focus apart from what is behind it; whole frame",
    truth="the mean of pictures from 256 places of the lens",
    metric="rmse",
    unit="of display white",
    knobs=knobs,
    default={"form": "gathered", "taps": 64},
    curve="form",
    problem="scene",
    run=run,
    needs=frozenset({"gpu"}),
    own_scene=True,
    timed="gpu",
    time_label="median frame time",
    note="No order is expected: more places looked at end at what one picture does not show. `lost` is the part of all"
    " light that the picture has too little of.",
)  # fmt: skip
