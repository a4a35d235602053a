"""Light between surfaces where the answer is known: two plates, a furnace, a closed box, a lamp that goes out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.primitives import card, cube
from engine.assets.scene import EnvironmentAsset
from engine.experiments.harness.pixel_truth import radiance
from engine.experiments.harness.rooms import matt
from engine.experiments.harness.samples import build
from engine.experiments.harness.scenes import MadeScene
from engine.gpu.types import Device
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.settings import RenderSettings
from engine.render.view import View

F8 = NDArray[np.float64]

FLAT = quat.from_axis_angle((1.0, 0.0, 0.0), -math.pi / 2)  # a card that faces +Z comes to face +Y
BLACK = (0.0, 0.0, 0.0)
#: frames that a lamp shines, and that are looked at after it went out
LIT_FRAMES, DARK_FRAMES = 12, 24


@dataclass(frozen=True, slots=True)
class Answer:
    """`allowed`: of the error, in the unit of both."""

    what: str
    truth: float
    ours: float
    allowed: float

    @property
    def error(self) -> float:
        return self.ours - self.truth

    @property
    def ok(self) -> bool:
        return abs(self.error) <= self.allowed


def wall_seen(d: float, a: float = 1.0, h: float = 1.0) -> float:
    """Form factor from a spot of the floor, d before the middle of a wall of half width a and height h (Howell,
    "A Catalog of Radiation Heat Transfer Configuration Factors", two of its perpendicular rectangles B-4)."""
    r = math.hypot(d, h)
    return (math.atan(a / d) - d / r * math.atan(a / r)) / math.pi


def answers(device: Device) -> Iterator[Answer]:
    """Each with what the renderer says."""
    for make in (_two_plates, _furnace, _closed_boxes):
        scene = MadeScene("known answers", device)
        try:
            yield from make(scene)
        finally:
            scene.close()


def lag(device: Device, *, smooth: bool) -> int:
    """Frames until a hundredth of its light is left of a lamp in a box that goes out; DARK_FRAMES if more."""
    scene = build("box", device)
    try:
        how = RenderSettings(samples=1, gi="many", gi_smooth=smooth, tone_map="none")
        seen = View(scene.camera(1.0), 48, 48, how, seconds=1.0 / 60.0)
        before = max(float(radiance(scene, seen).mean()) for _ in range(LIT_FRAMES))
        scene.scene.lights.set(0, intensity=0.0)
        left = [float(radiance(scene, seen).mean()) for _ in range(DARK_FRAMES)]
        return next((i for i, light in enumerate(left) if light < 0.01 * before), DARK_FRAMES)
    finally:
        scene.close()


def _two_plates(scene: MadeScene) -> Iterator[Answer]:
    _around(scene, None)
    scene.add(card(4.0), matt(BLACK), rotation=FLAT)
    scene.add(card(1.0), matt(BLACK, emissive=(1.0, 1.0, 1.0)), (0.0, 0.5, -0.5), scale=(2.0, 1.0, 1.0))
    camera = Camera(look_at((0.0, 2.2, 2.6), (0.0, 0.1, 0.1)), 0.9)
    seen = _light(scene, camera, 128, gi="one", view="indirect", gi_directions=4, gi_steps=48, gi_half=False)
    for d in (0.2, 0.4, 0.8, 1.2):
        p = camera.clip_from_world(1.0) @ np.array([0.0, 0.0, d - 0.5, 1.0])
        y, x = int((1.0 - p[1] / p[3]) * 64), int((p[0] / p[3] + 1.0) * 64)
        found = float(seen[y - 1 : y + 2, x - 1 : x + 2].mean())
        yield Answer(f"form factor of a wall, {d} m before it", wall_seen(d), found, 0.02)


def _furnace(scene: MadeScene) -> Iterator[Answer]:
    """All that is seen sends out a half and reflects a half of surroundings of 1."""
    _around(scene, (1.0, 1.0, 1.0))
    material = matt((0.5, 0.5, 0.5), emissive=(0.5, 0.5, 0.5))
    scene.add(card(4.0), material, rotation=FLAT)
    scene.add(card(4.0), material, (0.0, 1.0, -0.5))
    camera = Camera(look_at((0.3, 1.6, 2.2), (0.0, 0.4, -0.2)), 0.5)
    seen = _light(scene, camera, 64, gi="many", gi_bounces=8, gi_half=False)[4:-4, 4:-4]
    yield Answer("furnace, mean", 1.0, float(seen.mean()), 0.005)
    yield Answer("furnace, its worst pixel", 1.0, float(seen.flat[np.argmax(np.abs(seen - 1.0))]), 0.01)


def _closed_boxes(scene: MadeScene) -> Iterator[Answer]:
    """e (1 - rho^(n + 1)) / (1 - rho) after n bounces: what is not in the picture is as what is."""
    camera = Camera(look_at((0.0, 0.0, 0.95), (0.0, 0.0, 0.0)), 1.6)
    for glow, albedo in ((0.25, 0.5), (0.1, 0.8)):
        _around(scene, None)
        material = matt((albedo,) * 3, emissive=(glow,) * 3)
        material.features = ["double_sided"]
        node = scene.add(cube(2.0), material)
        for bounces in (1, 16):
            how: dict[str, Any] = {"gi": "one"} if bounces == 1 else {"gi": "many", "gi_bounces": bounces}
            found = float(_light(scene, camera, 64, gi_unseen="seen", gi_radius=10.0, **how).mean())
            truth = glow * (1.0 - albedo ** (bounces + 1)) / (1.0 - albedo)
            what = "one bounce, e (1 + rho)" if bounces == 1 else f"{bounces} bounces, e / (1 - rho)"
            yield Answer(f"closed box, rho {albedo}: {what}", truth, found, 0.04 * truth)
        scene.scene.nodes.set_visible([node], False)
        scene.scene.update()


def _around(scene: MadeScene, color: tuple[float, float, float] | None) -> None:
    """Surroundings of one colour, or darkness."""
    scene.scene.environment = EnvironmentAsset(
        kind="uniform" if color else "none", color=color or BLACK, sun_illuminance=0.0, background="color",
        background_color=BLACK,
    )  # fmt: skip
    scene.scene.look.tone_map = "none"


def _light(scene: MadeScene, camera: Camera, side: int, **settings: Any) -> F8:
    view = View(camera, side, side, RenderSettings(samples=1, tone_map="none", **settings))
    return radiance(scene, view).reshape(side, side, 3)
