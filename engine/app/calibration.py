"""What each preset costs for a scene on this device: measured once, kept per device and driver.

choose(runtime, view, budget) ─► kept times of this scene at this size, or a few frames of each preset ─► Chosen
"""

from __future__ import annotations

import hashlib
import json
import math
import time
from dataclasses import replace
from pathlib import Path

from engine.app.runtime import Runtime
from engine.core.atomic import write_text
from engine.core.errors import OutputError
from engine.core.paths import user_cache_dir
from engine.gpu.types import Caps
from engine.render.presets import NAMES, PRESETS, Chosen, with_preset, within_budget
from engine.render.view import View

#: frames before those that count (programs, maps and histories are made), and those of which the quickest counts
WARM, TIMED = 3, 5
#: scenes and sizes that are kept
KEPT = 64


def choose(runtime: Runtime, view: View, budget: float, *, again: bool = False) -> Chosen:
    """The best preset whose frame fits in `budget` milliseconds, as measured on the scene that is open, from the view's
    camera. `again`: measure even where there are kept times."""
    caps = runtime.device.caps
    key = scene_key(runtime, view)
    kept = load(caps)
    found = None if again else kept.get(key)
    source = f"this scene at {view.width}x{view.height} on {caps.device}"
    if found is None:
        found = measure(runtime, view)
        kept.pop(key, None)
        kept[key] = found
        save(caps, dict(list(kept.items())[-KEPT:]))
        source += ", measured now,"
    else:
        source += ", measured before,"
    return within_budget(found, budget, source)


def measure(runtime: Runtime, view: View) -> dict[str, float]:
    """Milliseconds of a frame as a window makes them, by preset: the quickest of some, interleaved, so that what else
    the machine does counts little and meets all alike."""
    views = {
        name: replace(view, settings=with_preset(view.settings, name), seconds=1.0 / 60.0, key=("calibration", name))
        for name in NAMES
    }
    times: dict[str, list[float]] = {name: [] for name in NAMES}
    for one in views.values():
        for _ in range(WARM):
            runtime.render(one)
    for _ in range(TIMED):
        for name, one in views.items():
            runtime.render(one)  # what another preset left (maps of shadows) is made again, and does not count
            runtime.device.finish()
            start = time.perf_counter()
            runtime.render(one)
            runtime.device.finish()
            times[name].append(1e3 * (time.perf_counter() - start))
    return {name: min(values) for name, values in times.items()}


def scene_key(runtime: Runtime, view: View) -> str:
    """What the cost depends on, besides the device: what is drawn, the picture's size, the presets' values, and the
    settings that no preset names."""
    scene = runtime.scene
    rest = {k: v for k, v in view.settings.values().items() if k not in PRESETS["high"]}
    name = str(runtime.path or runtime.asset.name)
    parts = (name, repr(scene.counts()), view.width, view.height, repr(PRESETS), repr(rest))
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def file_of(caps: Caps) -> Path:
    """Where the times of a device and driver lie."""
    name = hashlib.sha256(f"{caps.device}\n{caps.version}".encode()).hexdigest()[:16]
    return user_cache_dir() / "preset_costs" / f"{name}.json"


def load(caps: Caps) -> dict[str, dict[str, float]]:
    """Scene key -> preset -> ms; a file that makes no sense counts as none."""
    try:
        data = json.loads(file_of(caps).read_text(encoding="utf-8"))
        found = {str(key): {name: float(row[name]) for name in NAMES} for key, row in data["scenes"].items()}
        sound = all(math.isfinite(ms) and ms > 0.0 for row in found.values() for ms in row.values())
        return found if sound else {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def save(caps: Caps, scenes: dict[str, dict[str, float]]) -> None:
    """Keep the times; a cache that cannot be written is none."""
    path = file_of(caps)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        data = {"device": caps.device, "version": caps.version, "scenes": scenes}
        write_text(path, json.dumps(data, indent=2) + "\n")
    except (OSError, OutputError):
        return
