"""Presets: sets of render settings from quick to good, and which of them a budget of milliseconds allows.

A preset is nothing but values of parameters; what it does not name stays as it is (exposure, bloom, the lens: a look is
no quality). Their places on the front of error over time are measured by `lucarna report presets`; `auto` goes by what
each takes on this device for the scene at hand (engine.app.calibration), never by guess.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from engine.report.page.text import milliseconds as shown

if TYPE_CHECKING:
    from engine.core.param import Value
    from engine.render.settings import RenderSettings

AUTO = "auto"
#: frames whose times differ by less than this factor are as quick as each other, as far as a few of them tell
ALIKE = 1.1

#: from the quickest to the best
PRESETS: dict[str, dict[str, Value]] = {
    "low": {
        "samples": 1, "antialias": "fxaa", "taa_frames": 8, "depth_first": True, "shadow_filter": "pcf",
        "shadow_cascades": 2,
        "shadow_size": 1024, "local_shadow_size": 1024, "ambient_occlusion": "off", "anisotropy": 1.0,
        "focus_taps": 24, "quality": "low",
    },
    "medium": {
        "samples": 1, "antialias": "taa", "taa_frames": 8, "depth_first": True, "shadow_filter": "pcf",
        "shadow_cascades": 3,
        "shadow_size": 1024, "local_shadow_size": 2048, "ambient_occlusion": "gtao", "ao_directions": 1,
        "ao_steps": 4, "ao_half": True, "anisotropy": 2.0, "focus_taps": 48, "quality": "medium",
    },
    "high": {
        "samples": 1, "antialias": "taa", "taa_frames": 8, "depth_first": True, "shadow_filter": "pcf",
        "shadow_cascades": 4,
        "shadow_size": 2048, "local_shadow_size": 4096, "ambient_occlusion": "gtao", "ao_directions": 1,
        "ao_steps": 8, "ao_half": False, "anisotropy": 8.0, "focus_taps": 64, "quality": "high",
    },
    "ultra": {
        "samples": 1, "antialias": "taa", "taa_frames": 16, "depth_first": True, "shadow_filter": "pcf",
        "shadow_cascades": 4,
        "shadow_size": 4096, "local_shadow_size": 8192, "ambient_occlusion": "gtao", "ao_directions": 2,
        "ao_steps": 8, "ao_half": False, "anisotropy": 16.0, "focus_taps": 128, "quality": "high",
    },
}  # fmt: skip
NAMES = tuple(PRESETS)


def with_preset(settings: RenderSettings, preset: str) -> RenderSettings:
    """The settings with the values of a preset in the places of theirs."""
    return type(settings)(**{**settings.values(), **PRESETS[preset]})


def preset_of(settings: RenderSettings) -> str:
    """The preset whose values all are as set; '' where there is none."""
    values = settings.values()
    return next((name for name, own in PRESETS.items() if all(values[k] == v for k, v in own.items())), "")


@dataclass(frozen=True, slots=True)
class Chosen:
    """`why` and `table`: for people. `within`: the budget is kept, as measured."""

    preset: str
    why: str
    within: bool
    table: tuple[str, ...] = ()


def within_budget(milliseconds: Mapping[str, float], budget: float, what: str) -> Chosen:
    """The best preset whose measured frame fits in `budget` ms; the quickest where none does. `what`: was measured."""
    fitting = [name for name in NAMES if name in milliseconds and milliseconds[name] <= budget]
    times = ", ".join(f"{name} {shown(milliseconds[name])}" for name in NAMES if name in milliseconds)
    if fitting:
        best = fitting[-1]
        return Chosen(best, f"{best}: the best within {budget:g} ms; frames of {what} take {times} ms", True)
    least = min(milliseconds.values()) * ALIKE
    quickest = next(name for name in NAMES if milliseconds.get(name, math.inf) <= least)
    why = f"{quickest}: none stays within {budget:g} ms, it takes the least; frames of {what} take {times} ms"
    return Chosen(quickest, why, False)
