"""What each preset costs for a scene on this device: measured once, kept per device and driver.

choose(runtime, view, budget) ─► kept costs of this scene from this camera, or some frames of each preset ─► Chosen

What is measured is a frame in motion: the camera turns a little from frame to frame, and the presets take turns, so
that shadow maps are drawn anew and TAA does all of its work. A picture at rest keeps both: all presets look alike.
"""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

import numpy as np

from engine.app.runtime import Runtime
from engine.core.atomic import write_text
from engine.core.errors import OutputError
from engine.core.paths import user_cache_dir
from engine.gpu.types import Caps
from engine.math import quat
from engine.render.camera import Camera
from engine.render.presets import NAMES, PRESETS, Chosen, with_preset, within_budget
from engine.render.view import View
from engine.report.page.text import milliseconds as shown

#: frames before those that count: programs and histories are made
WARM = 2
#: frames that count: at least, at most; seconds after which the least are enough
ROUNDS, SECONDS = (3, 15), 6.0
#: radians that the camera turns by in a frame
TURN = math.radians(0.25)
#: scenes and sizes that are kept
KEPT = 64


@dataclass(frozen=True, slots=True)
class Cost:
    """Milliseconds of a frame: the least of `frames`, which what else the machine does raises the least; the median."""

    least: float
    median: float
    frames: int


def choose(runtime: Runtime, view: View, budget: float, *, again: bool = False) -> Chosen:
    """The best preset whose frame fits in `budget` milliseconds, as measured on the scene that is open, from the view's
    camera. `again`: measure even where there are kept costs."""
    caps = runtime.device.caps
    key = scene_key(runtime, view)
    kept = load(caps)
    found = None if again else kept.get(key)
    when = "before" if found is not None else "now"
    if found is None:
        found = measure(runtime, view)
        kept.pop(key, None)
        kept[key] = found
        save(caps, dict(list(kept.items())[-KEPT:]))
    what = f"this scene in motion at {view.width}x{view.height} on {caps.device}, measured {when},"
    chosen = within_budget({name: cost.least for name, cost in found.items()}, budget, what)
    return replace(chosen, table=table(found, chosen.preset, budget))


def table(costs: Mapping[str, Cost], chosen: str, budget: float) -> tuple[str, ...]:
    """Lines for people: what was measured, what fits, what was chosen."""
    lines = [f"{'preset':<8} {'least ms':>9} {'median ms':>10} {'frames':>7}   within {budget:g} ms"]
    for name, cost in costs.items():
        verdict = ("yes" if cost.least <= budget else "no") + (", chosen" if name == chosen else "")
        lines.append(f"{name:<8} {shown(cost.least):>9} {shown(cost.median):>10} {cost.frames:7d}   {verdict}")
    return tuple(lines)


def measure(runtime: Runtime, view: View, clock: Callable[[], float] = time.perf_counter) -> dict[str, Cost]:
    """What a frame costs by preset, as a window makes them while the camera turns. The presets take turns, so that what
    else the machine does meets all alike. `clock`: seconds."""
    views = {
        name: replace(view, settings=with_preset(view.settings, name), seconds=1.0 / 60.0, key=("calibration", name))
        for name in NAMES
    }
    times: dict[str, list[float]] = {name: [] for name in NAMES}

    def frame(name: str, number: int) -> float:
        start = clock()
        runtime.render(replace(views[name], camera=turned(view.camera, TURN * (number % 2))))
        runtime.device.finish()
        return 1e3 * (clock() - start)

    for name in NAMES:
        for number in range(WARM):
            frame(name, number)
    began = clock()
    for number in range(ROUNDS[1]):
        if number >= ROUNDS[0] and clock() - began > SECONDS:
            break
        for name, found in times.items():
            found.append(frame(name, WARM + number))
    return {name: Cost(min(found), median(found), len(found)) for name, found in times.items()}


def turned(camera: Camera, angle: float) -> Camera:
    """Turned about its own upright axis, radians."""
    turn = np.eye(4)
    turn[:3, :3] = quat.to_matrix3(quat.from_axis_angle(np.array([0.0, 1.0, 0.0]), angle))
    return replace(camera, world_from_camera=camera.world_from_camera @ turn)


def scene_key(runtime: Runtime, view: View) -> str:
    """What the cost depends on, besides the device: what is drawn, from where, the picture's size, the presets' values,
    and the settings that no preset names."""
    scene = runtime.scene
    rest = {k: v for k, v in view.settings.values().items() if k not in PRESETS["high"]}
    name = str(runtime.path or runtime.asset.name)
    parts = (
        name, repr(scene.counts()), repr(scene.environment), view.width, view.height, repr(PRESETS), repr(rest),
        repr(np.round(view.camera.world_from_camera, 3).tolist()), round(view.camera.yfov, 3), view.camera.ymag,
    )  # fmt: skip
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def file_of(caps: Caps) -> Path:
    """Where the costs of a device and driver lie."""
    name = hashlib.sha256(f"{caps.device}\n{caps.version}".encode()).hexdigest()[:16]
    return user_cache_dir() / "preset_costs" / f"{name}.json"


def load(caps: Caps) -> dict[str, dict[str, Cost]]:
    """Scene key -> preset -> cost; a file that makes no sense counts as none."""
    try:
        data = json.loads(file_of(caps).read_text(encoding="utf-8"))
        found = {str(key): {name: _cost(row[name]) for name in NAMES} for key, row in data["scenes"].items()}
        sound = all(
            math.isfinite(c.least) and 0.0 < c.least <= c.median for row in found.values() for c in row.values()
        )
        return found if sound else {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError):
        return {}


def _cost(row: list[float]) -> Cost:
    return Cost(float(row[0]), float(row[1]), int(row[2]))


def save(caps: Caps, scenes: Mapping[str, Mapping[str, Cost]]) -> None:
    """Keep the costs; a cache that cannot be written is none."""
    path = file_of(caps)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        rows = {key: {n: (c.least, c.median, c.frames) for n, c in row.items()} for key, row in scenes.items()}
        data = {"device": caps.device, "version": caps.version, "scenes": rows}
        write_text(path, json.dumps(data, indent=2) + "\n")
    except (OSError, OutputError):
        return
