"""A mirror where the answer is known: a floor that mirrors glowing bars, pixel by pixel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.material import MaterialAsset
from engine.assets.primitives import card
from engine.assets.scene import EnvironmentAsset
from engine.experiments.harness.gi_answers import BLACK, FLAT
from engine.experiments.harness.pixel_truth import radiance
from engine.experiments.harness.rooms import matt
from engine.experiments.harness.scenes import MadeScene
from engine.gpu.types import Device
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.settings import RenderSettings
from engine.render.view import View

F8 = NDArray[np.float64]

SIDE = 128
#: metres: where the bars stand, how wide and high they are
BARS, BEHIND, WIDTH, HEIGHT = np.linspace(-1.2, 1.2, 13), -0.5, 0.05, 1.0
GLOW = 0.6


@dataclass(frozen=True, slots=True)
class Mirrored:
    """Parts of the floor's pixels: `missed`, a bar that is not there; `false`, one that should not be. `picture`
    f8[h,w]: brightness; `truth`: the same where it is known, else nan."""

    missed: float
    false: float
    picture: F8
    truth: F8


def bars(device: Device, **settings: Any) -> Mirrored:
    """What the renderer says of the floor."""
    scene = MadeScene("bars", device)
    try:
        scene.scene.environment = EnvironmentAsset(
            kind="none", sun_illuminance=0.0, background="color", background_color=BLACK
        )
        scene.scene.look.tone_map = "none"
        metal = {"base_color": (1.0, 1.0, 1.0, 1.0), "metallic": 1.0, "roughness": 0.0}
        scene.add(card(6.0), MaterialAsset("mirror", params=metal), rotation=FLAT)
        for x in BARS:
            scene.add(card(1.0), matt(BLACK, emissive=(GLOW,) * 3), (x, HEIGHT / 2, BEHIND), scale=(WIDTH, HEIGHT, 1.0))
        camera = Camera(look_at((0.0, 1.2, 2.6), (0.0, 0.2, 0.0)), 0.8)
        how = RenderSettings(samples=1, tone_map="none", reflections=True, **settings)
        seen = radiance(scene, View(camera, SIDE, SIDE, how)).mean(axis=1).reshape(SIDE, SIDE)
    finally:
        scene.close()
    truth = mirrored_bars(camera)
    known = np.isfinite(truth)
    dark = seen < GLOW / 2
    return Mirrored(
        float(np.mean(dark[known & (truth > 0.0)])), float(np.mean(~dark[known & (truth == 0.0)])), seen, truth
    )


def mirrored_bars(camera: Camera) -> F8:
    """Brightness f8[h,w] of the floor's pixels; nan for others, and where a pixel shows an edge of something."""
    corners = [_at(camera, dx, dy) for dx in (0.02, 0.98) for dy in (0.02, 0.98)]
    same = np.all([c == corners[0] for c in corners], axis=0)
    return np.where(same, corners[0], np.nan)


def _at(camera: Camera, dx: float, dy: float) -> F8:
    x, y = np.meshgrid((np.arange(SIDE) + dx) / SIDE * 2.0 - 1.0, 1.0 - (np.arange(SIDE) + dy) / SIDE * 2.0)
    clip = np.stack([x, y, np.full_like(x, 0.5), np.ones_like(x)], axis=-1)
    p = clip @ np.linalg.inv(camera.clip_from_world(1.0)).T
    d = p[..., :3] / p[..., 3:] - camera.position
    floor = camera.position + d * (-camera.position[1] / np.minimum(d[..., 1:2], -1e-9))
    on = (d[..., 1] < 0.0) & (np.abs(floor[..., 0]) < 3.0) & (floor[..., 2] > BEHIND) & (floor[..., 2] < 3.0)
    # the mirrored way, d with y turned, to the plane of the bars
    way = (BEHIND - floor[..., 2]) / np.minimum(d[..., 2], -1e-9)
    met = floor[..., 0] + way * d[..., 0], -way * d[..., 1]
    bar = (np.abs(met[0][..., None] - BARS) < WIDTH / 2).any(axis=-1) & (met[1] < HEIGHT)
    # what is outside of the picture, or near its border, is not known
    at = np.stack([met[0], met[1], np.full_like(met[0], BEHIND), np.ones_like(met[0])], axis=-1)
    at = at @ camera.clip_from_world(1.0).T
    inside = (np.abs(at[..., :2] / at[..., 3:]) < 0.75).all(axis=-1)
    return np.where(on & (inside | ~bar), np.where(bar, GLOW, 0.0), np.nan)
