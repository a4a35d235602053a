"""Shadows of a pane of coloured glass, by every type of light: what is left of the light, where it is a formula.

A floor, a pane of 1 m two metres over it, and one light: the sun, or a lamp four metres high. At each place of the
floor the truth is the part of the light that the pane lies before: it lets mix(white, its colour, its alpha) through.
The camera hangs under the pane and sees only the floor. Ours is read out of two pictures: with over without shadows.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.primitives import plane
from engine.assets.scene import LightAsset
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import radiance, redrawn
from engine.experiments.harness.samples import DOWN, environment, floor, surface
from engine.experiments.harness.scenes import MADE, MadeScene
from engine.experiments.local_shadows import another_filter
from engine.experiments.shadow_edges import above
from engine.math.color import to_u1
from engine.render.settings import RenderSettings
from engine.render.view import View

F8 = NDArray[np.float64]

HEIGHT, LAMP = 2.0, 4.0
COLOR, ALPHA = (0.9, 0.35, 0.15), 0.7
#: metres of half a lamp
SMALL = 0.2
LAMPS: dict[str, LightAsset] = {
    "spot": LightAsset("spot", intensity=30.0, inner_angle=0.8, outer_angle=0.9),
    "point": LightAsset("point", intensity=30.0),
    "ball": LightAsset("point", intensity=30.0, radius=SMALL),
    "rectangle": LightAsset("rectangle", intensity=60.0, width=2.0 * SMALL, height=2.0 * SMALL),
    "disk": LightAsset("disk", intensity=60.0, width=2.0 * SMALL, height=2.0 * SMALL),
}
SUN = "sun"
LIGHTS = (SUN, *LAMPS)
FILTERS = ("pcf", "vogel16", "pcss", "evsm4")
SIZE = (128, 128)
#: metres that the picture shows to each side
HALF = 1.6


def knobs(ctx: Context) -> list[dict[str, Any]]:
    """A lamp with a size chooses its filter itself, so that one says all."""
    return [
        {"light": light, "filter": f}
        for light in LIGHTS
        for f in (FILTERS[:1] if ctx.quick or light in ("ball", "rectangle", "disk") else FILTERS)
    ]


def made(ctx: Context, light: str) -> MadeScene:
    """The caller closes it."""
    assert ctx.device is not None, "the experiment needs a device"
    scene = MadeScene(MADE + light, ctx.device)
    environment(scene, "none", sun=3.0 * (light == SUN), sun_elevation=math.pi / 4, sun_azimuth=-math.pi / 2)
    floor(scene, 16.0, base_color=(0.5, 0.5, 0.5, 1.0), roughness=1.0)
    glass = surface("transparent", ("double_sided",), base_color=(*COLOR, ALPHA), metallic=0.0, roughness=0.1)
    scene.add(plane(1.0), glass, (-HEIGHT * (light == SUN), HEIGHT, 0.0))
    if light != SUN:
        scene.lamp(LAMPS[light], (0.0, LAMP, 0.0), DOWN)
    scene.view_from = above((0.0, 0.0), HALF, height=0.75 * HEIGHT)
    return scene


def hidden_part(light: str) -> F8:
    """f8[h*w]: of the light, at each pixel's place, what the pane is before."""
    along = (np.arange(SIZE[0]) + 0.5) / SIZE[0] * 2.0 - 1.0
    x, z = (a.ravel() * HALF for a in np.meshgrid(along, along))
    half = 0.5
    if light == SUN:
        return ((np.abs(x) < half) & (np.abs(z) < half)).astype(np.float64)
    steps = (np.arange(24) + 0.5) / 24.0 * 2.0 - 1.0
    at = np.array([(a, b) for a in steps for b in steps]) * (0.0 if light in ("spot", "point") else SMALL)
    if light in ("ball", "disk"):
        at = at[np.hypot(*at.T) < SMALL]
    part = HEIGHT / LAMP  # of the way to the lamp
    before = np.ones((len(x), len(at)), bool)
    for place, of_lamp in ((x, at[:, 0]), (z, at[:, 1])):
        before &= np.abs(place[:, None] * (1.0 - part) + of_lamp[None] * part) < half
    result: F8 = before.mean(axis=1)
    return result


def settings(chosen: Knobs, **more: Any) -> RenderSettings:
    return RenderSettings(
        samples=1, background="color", tone_map="none", translucent_shadows=True, local_shadows="all",
        shadow_filter=str(chosen["filter"]), **more,
    )  # fmt: skip


def run(ctx: Context, chosen: Knobs) -> Trial:
    light = str(chosen["light"])
    scene = made(ctx, light)
    seen = View(scene.view_from, *SIZE, settings(chosen))
    left = 1.0 - ALPHA * (1.0 - np.array(COLOR))
    right = 1.0 - hidden_part(light)[:, None] * (1.0 - left)

    def judge() -> Outcome:
        bare = settings({"filter": "none"}, shadows=False)
        bare.local_shadows = "off"
        full = radiance(scene, View(scene.view_from, *SIZE, bare))
        ours = np.clip(radiance(scene, seen) / np.maximum(full, 1e-9), 0.0, 1.0)
        off = ours - right
        inside = hidden_part(light) == 1.0
        error = {
            "rmse": float(np.sqrt(np.mean(off**2))), "worst": float(np.abs(off).max()),
            "colour": float(np.abs(ours[inside].mean(axis=0) - left).max()),
        }  # fmt: skip
        pictures = []
        if chosen["filter"] == FILTERS[0]:
            a, b = (to_u1(0.75 * part.reshape(*SIZE[::-1], 3)) for part in (ours, right))
            pictures = beside_truth(ctx, f"{light}, {chosen['filter']}", a, "the part that the pane hides", b)
        return Outcome(error, pictures=pictures)

    return redrawn(ctx, scene, seen, judge, another_filter)


EXPERIMENT = Experiment(
    title="Shadows of coloured glass",
    method="maps of what blended surfaces leave of the light, beside those of depth; drawn anew",
    truth="the part of the light that the pane hides, times what its colour and alpha leave",
    metric="rmse",
    unit="of the light, by channel",
    knobs=knobs,
    default={},
    advisory=True,
    curve="filter",
    problem="light",
    run=run,
    needs=frozenset({"gpu"}),
    timed="gpu",
    time_label="median frame time",
    note="colour: how far the mean of what is wholly in the pane's shadow is from the right colour.",
)  # fmt: skip
