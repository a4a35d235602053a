"""Shapes before a still camera: what smoothing over frames drags along, what becomes of a thin line, and of an edge by
its angle."""

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
#: of a square card whose edges are looked at, in metres; points in each pixel of the truth, each way
CARD, POINTS = 1.2, 16


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
    if settings.get("antialias") != "taa":
        places = places[-1:]  # nothing is kept
    *_, now = _shown(device, places, (0.6, 0.6, 1.0), 0.0, settings)
    *_, bare = _shown(device, places[-1:], (0.6, 0.6, 1.0), 0.0, {"samples": 1})
    height, width = bare.shape
    padded = np.pad(bare, 2)
    near = [padded[y : y + height, x : x + width] for y in range(5) for x in range(5)]
    return float(now[np.max(near, axis=0) == 0.0].max()) / LIGHT


def thin_line(
    device: Device, settings: dict[str, Any], step: float = 1.0 / 3.0, *, restless: bool = False
) -> Line:  # fmt: skip
    """A line across the picture that sinks by `step` pixels a frame, or rests (0). `restless`: something else moves."""
    places = [(0.0, -step * PIXEL * (i - FRAMES / 2), 0.0) for i in range(FRAMES)]
    size = (4.0 * HEIGHT, WIDTH * PIXEL, 1.0)
    pictures = list(_shown(device, places, size, LEANS, settings, restless=restless))
    columns = np.stack([p.sum(axis=0) for p in pictures[FRAMES // 2 :]]) / (LIGHT * WIDTH / np.cos(LEANS))
    light = columns.mean(axis=1)
    return Line(float(light.mean()), float(light.std()), float((columns < 0.25).mean()))


def edges(device: Device, settings: dict[str, Any], angle: float) -> float:
    """A bright card turned by `angle` radians, at rest: rmse of light against the parts of pixels that it covers, which
    are counted in points, for all pixels that it covers in part; in 8-bit steps of linear light."""
    place = (0.3 * PIXEL, 0.4 * PIXEL, 0.0)
    frames = FRAMES if settings.get("antialias") == "taa" else 1
    *_, got = _shown(device, [place] * frames, (CARD, CARD, 1.0), angle, settings)
    width, height = SIZE
    y, x = (np.mgrid[: height * POINTS, : width * POINTS] + 0.5) / POINTS
    x, y = (x - width / 2.0) * PIXEL - place[0], (height / 2.0 - y) * PIXEL - place[1]
    u, v = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    inside = (np.abs(u) < CARD / 2.0) & (np.abs(v) < CARD / 2.0)
    part = inside.reshape(height, POINTS, width, POINTS).mean(axis=(1, 3))
    touched = (part > 0.0) & (part < 1.0)
    return float(255.0 * np.sqrt(np.mean((got / LIGHT - part)[touched] ** 2)))


def _shown(
    device: Device, places: list[tuple[float, float, float]], size: tuple[float, float, float], leans: float,
    settings: dict[str, Any], *, restless: bool = False,
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
        other = made.scene.nodes.add("somebody else")
        camera = Camera(look_at((0.0, 0.0, 4.0), (0.0, 0.0, 0.0)), 2.0 * float(np.arctan(HEIGHT / 8.0)))
        view = View(camera, *SIZE, RenderSettings(**settings), seconds=1.0 / 60.0)
        at = places[0]
        for number, place in enumerate(places):
            if restless:
                made.scene.nodes.set_translation([other], [(0.0, float(number), 0.0)])
                made.scene.update()
            if place != at:  # what is set has changed
                made.scene.nodes.set_translation([node], [place])
                made.scene.update()
                at = place
            pixels = np.asarray(made.render(view).color.read(), np.float64)
            yield srgb_to_linear(pixels[..., 0] / 255.0)
    finally:
        made.close()
