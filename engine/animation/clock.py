"""From running time to a clip's time, in float64: a float32 clock is 0.06 s coarse after twelve days."""

from __future__ import annotations

import math

from engine.core.errors import InputError

MODES = ("loop", "once", "ping-pong")


def wrap(time_s: float, duration: float, mode: str = "loop") -> float:
    """Return the time in [0, duration] at which to sample, for any `time_s`.

    `loop` starts over (a whole number of durations is 0), `once` holds the ends, `ping-pong` turns back. Not a number
    is 0; so is any time of a clip without duration, and infinity except for `once`. Raises InputError for another mode.
    """
    if mode not in MODES:
        raise InputError(f"unknown play mode {mode!r}", hint=f"choose one of {', '.join(MODES)}")
    if math.isnan(time_s) or not 0.0 < duration < math.inf:
        return 0.0
    if mode == "once":
        return min(max(time_s, 0.0), duration)
    if math.isinf(time_s):
        return 0.0
    if mode == "loop":
        return _modulo(time_s, duration)
    there = _modulo(time_s, 2.0 * duration)
    return there if there <= duration else 2.0 * duration - there


def _modulo(time_s: float, period: float) -> float:
    rest = math.fmod(time_s, period)  # exact, also for 1e12 s
    if rest < 0.0:
        rest += period
    # -1e-30 + period rounds to the period itself
    return rest if rest < period else 0.0
