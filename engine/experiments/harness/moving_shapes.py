"""Shapes that move before a still camera: what smoothing over frames drags along, and what becomes of a thin line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.material import MaterialAsset
from engine.assets.primitives import card
from engine.assets.scene import EnvironmentAsset
from engine.experiments.harness.scenes import MadeScene
from engine.gpu.types import Device
from engine.math import quat
from engine.math.color import srgb_to_linear
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.settings import RenderSettings
from engine.render.view import View

F8 = NDArray[np.float64]

SIZE = (96, 72)
#: metres that the picture is high; of a card in it that is one metre from rim to rim
HEIGHT = 2.0
PIXEL = HEIGHT / SIZE[1]
LIGHT = 0.7
#: pictures in a row; the second half of them is judged
FRAMES = 32
#: of the line, in pixels; radians that it is turned by
WIDTH, LEANS = 0.5, 0.1


@dataclass(frozen=True, slots=True)
class Line:
    """`light`: shown, of what it has; `flicker`: its standard deviation from frame to frame, of the same; `gaps`: the
    part of its columns that show less than a quarter of its light."""

    light: float
    flicker: float
    gaps: float


def left_behind(device: Device, settings: dict[str, Any], step: float = 3.0) -> float:
    """A card goes `step` pixels a frame: the brightest pixel that is not at it, nor next to it, of its light."""
    places = [(step * PIXEL * (i - FRAMES / 2), 0.0, 0.0) for i in range(FRAMES)]
    *_, now = _shown(device, places, (0.6, 0.6, 1.0), 0.0, settings)
    *_, bare = _shown(device, places[-1:], (0.6, 0.6, 1.0), 0.0, {"samples": 1})
    height, width = bare.shape
    padded = np.pad(bare, 2)
    near = [padded[y : y + height, x : x + width] for y in range(5) for x in range(5)]
    return float(now[np.max(near, axis=0) == 0.0].max()) / LIGHT


def thin_line(device: Device, settings: dict[str, Any], step: float = 1.0 / 3.0) -> Line:
    """A line across the picture that sinks by `step` pixels a frame, or rests (0)."""
    places = [(0.0, -step * PIXEL * (i - FRAMES / 2), 0.0) for i in range(FRAMES)]
    pictures = list(_shown(device, places, (4.0 * HEIGHT, WIDTH * PIXEL, 1.0), LEANS, settings))
    columns = np.stack([p.sum(axis=0) for p in pictures[FRAMES // 2 :]]) / (LIGHT * WIDTH / np.cos(LEANS))
    light = columns.mean(axis=1)
    return Line(float(light.mean()), float(light.std()), float((columns < 0.25).mean()))


def _shown(
    device: Device, places: list[tuple[float, float, float]], size: tuple[float, float, float], leans: float,
    settings: dict[str, Any],
) -> Iterator[F8]:  # fmt: skip
    """f8[h,w] linear light of a frame for each of the places of a card that shines on black."""
    made = MadeScene("moving shape", device)
    try:
        made.scene.environment = EnvironmentAsset(
            kind="none", sun_illuminance=0.0, background="color", background_color=(0.0, 0.0, 0.0)
        )
        made.scene.look.tone_map = "none"
        params = {"base_color": (0.0, 0.0, 0.0, 1.0), "specular": 0.0, "emissive": (1.0, 1.0, 1.0)}
        material = MaterialAsset("glow", params={**params, "emissive_strength": LIGHT})
        turn = quat.from_axis_angle((0.0, 0.0, 1.0), leans)
        node = made.add(card(1.0), material, places[0], turn, size)
        camera = Camera(look_at((0.0, 0.0, 4.0), (0.0, 0.0, 0.0)), 2.0 * float(np.arctan(HEIGHT / 8.0)))
        view = View(camera, *SIZE, RenderSettings(**settings), seconds=1.0 / 60.0)
        at = places[0]
        for place in places:
            if place != at:  # what is set has changed
                made.scene.nodes.set_translation([node], [place])
                made.scene.update()
                at = place
            pixels = np.asarray(made.render(view).color.read(), np.float64)
            yield srgb_to_linear(pixels[..., 0] / 255.0)
    finally:
        made.close()
