"""Many lights at once: scattered evenly through a box, alike but for place, colour and brightness."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.scene import LightAsset
from engine.core.errors import InputError
from engine.core.param import ParamBlock, param
from engine.scene.scene import Scene

F8 = NDArray[np.float64]

KINDS = ("point", "spot", "rectangle", "disk")
#: turns -Z, where lights shine, down to -Y
DOWN = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))


class ScatterSettings(ParamBlock):
    """What is scattered. The same settings give the same lights."""

    kind: str = param("point", choices=KINDS, doc="what each light is")
    count: int = param(100, min=1, max=100_000, doc="how many lights")
    intensity: float = param(1.0, min=0.0, max=1e9, doc="candela; nit for rectangles and disks")
    spread: float = param(0.0, min=0.0, max=1.0, step=0.01, doc="how much dimmer than that some are; 1 = down to dark")
    range: float = param(2.0, min=0.0, max=1e9, unit="m", doc="where each light ends; 0 = never")
    first_color: tuple[float, float, float] = param(
        (1.0, 0.25, 0.05), min=0.0, max=1.0, type="color3", doc="one end of the colours"
    )
    last_color: tuple[float, float, float] = param(
        (0.1, 0.3, 1.0), min=0.0, max=1.0, type="color3", doc="the other end of the colours"
    )
    all_hues: bool = param(False, doc="colours of all hues instead, as bright as the first one")
    size: float = param(0.2, min=0.0, max=1e6, unit="m", doc="width and height of rectangles and disks")
    aim: str = param("down", choices=("down", "random"), doc="where spots, rectangles and disks shine")
    seed: int = param(1, min=0, max=9999, doc="another number gives another arrangement")
    drift: float = param(
        0.0, min=0.0, max=1e6, step=0.01, unit="m", doc="let each circle so far from its place, 16 s a turn; 0 = still"
    )
    box: bool = param(False, doc="within a box of your own, instead of that of the selection or the scene")
    box_low: tuple[float, float, float] = param(
        (-1.0, 0.0, -1.0), min=-1e9, max=1e9, step=0.05, unit="m", doc="one corner of the box"
    )
    box_high: tuple[float, float, float] = param(
        (1.0, 2.0, 1.0), min=-1e9, max=1e9, step=0.05, unit="m", doc="the opposite corner"
    )


def scatter_lights(scene: Scene, settings: ScatterSettings, low: ArrayLike, high: ArrayLike) -> int:
    """Add the lights within the world box from `low` to `high` f8[3], or the settings' own one, below a new node;
    returns that node's row. `settings.drift` is for drift.drift_clip.

    Raises InputError for a box that is not finite.
    """
    if settings.box:
        low = np.minimum(settings.box_low, settings.box_high)
        high = np.maximum(settings.box_low, settings.box_high)
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        raise InputError("the box to scatter lights in has no size", hint="select something, or give a box")
    rng = np.random.default_rng(settings.seed)
    count = settings.count
    at = low + _even(rng, count) * np.maximum(high - low, 0.0)
    top = scene.nodes.add(f"{count} {settings.kind} lights")
    turns = _random_turns(rng, count) if settings.aim == "random" else np.tile(DOWN, (count, 1))
    names = [f"{settings.kind.capitalize()} light {i + 1}" for i in range(count)]
    rows = scene.nodes.add_many(names, np.full(count, top), at, turns, np.ones((count, 3)))
    light = LightAsset(
        settings.kind, intensity=settings.intensity, range=settings.range, inner_angle=0.3, outer_angle=0.6,
        width=settings.size, height=settings.size,
    )  # fmt: skip
    dimmed = settings.intensity * (1.0 - settings.spread * rng.random(count))
    scene.lights.add_many(rows, light, _colors(rng, settings), dimmed)
    return top


def _even(rng: np.random.Generator, count: int) -> F8:
    """f8[n,3] in [0, 1)^3, no clumps: the additive recurrence of the root of x^4 = x + 1 (Roberts 2018), shifted."""
    root = 1.2207440846057596
    steps = np.array([1.0 / root, 1.0 / root**2, 1.0 / root**3])
    result: F8 = (rng.random(3) + np.arange(count)[:, None] * steps) % 1.0
    return result


def _random_turns(rng: np.random.Generator, count: int) -> F8:
    """Unit quaternions f8[n,4], evenly over all turns."""
    turns = rng.normal(size=(count, 4))
    result: F8 = turns / np.maximum(np.linalg.norm(turns, axis=1, keepdims=True), 1e-12)
    return result


def _colors(rng: np.random.Generator, settings: ScatterSettings) -> F8:
    share = rng.random((settings.count, 1))
    first, last = np.array(settings.first_color), np.array(settings.last_color)
    between: F8 = first + (last - first) * share
    pure = np.clip(np.abs((share * 6.0 + np.array([0.0, 4.0, 2.0])) % 6.0 - 3.0) - 1.0, 0.0, 1.0)
    return np.where(settings.all_hues, first.max() * (0.2 + 0.8 * pure), between)
