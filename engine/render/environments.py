"""Environments: from what a scene says of its surroundings to a map on the GPU.

Baking (an HDRI, a procedural sky) is the importers' work: whoever opens a scene hands in a `baker`. The studio is
shipped baked; a uniform one and none need no file.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any

from engine.assets.scene import EnvironmentAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.core.paths import shaders_dir
from engine.gpu.types import Device
from engine.render.background_bakes import BackgroundBakes
from engine.resources.environment import EnvironmentMap

#: No light of a surrounding is brighter: products of several such numbers still are float32.
MAX_BRIGHTNESS = 1e9

#: gives the baked .dds of an environment; raises InputError
Baker = Callable[[EnvironmentAsset], Path]


class Environments:
    """Maps by key, the last few kept. What cannot be had becomes the studio, with a finding."""

    KEEP = 4

    def __init__(self, device: Device) -> None:
        self._device = device
        self._maps: dict[tuple[object, ...], EnvironmentMap] = {}
        self.baker: Baker | None = None
        self.findings = Findings()
        #: where it is set, surroundings are baked in a thread, which calls it when one is there; meanwhile those that
        #: were shown last stay
        self.told: Callable[[], None] | None = None
        self._bakes: BackgroundBakes | None = None
        self._shown: tuple[object, ...] | None = None

    def get(self, environment: EnvironmentAsset) -> EnvironmentMap:
        key = environment_key(environment)
        found = self._maps.get(key)
        if found is None:
            found = self._load(key, environment)
            if found is None:
                return self._meanwhile()
            self._maps[key] = found
            while len(self._maps) > self.KEEP:
                self._maps.pop(next(k for k in self._maps if k != self._shown)).release()
        self._shown = key
        return found

    @property
    def baking(self) -> int:
        """How many surroundings are being made in threads."""
        return self._bakes.waiting if self._bakes is not None else 0

    @property
    def baked(self) -> int:
        """Grows when one of those is there: the next picture is another."""
        return self._bakes.done if self._bakes is not None else 0

    def _meanwhile(self) -> EnvironmentMap:
        """What was shown last, else the studio."""
        if self._shown is None or self._shown not in self._maps:
            self._shown = ("studio",)
            self._maps.setdefault(self._shown, EnvironmentMap.from_file(self._device, _studio()))
        return self._maps[self._shown]

    def _baked_file(self, key: tuple[object, ...], environment: EnvironmentAsset) -> Path | None:
        """None while it is made in a thread."""
        assert self.baker is not None
        if self.told is None:
            return self.baker(environment)
        if self._bakes is None:
            self._bakes = BackgroundBakes(self.told)
        return self._bakes.get(key, partial(self.baker, environment))

    def _load(self, key: tuple[object, ...], environment: EnvironmentAsset) -> EnvironmentMap | None:
        kind = environment.kind
        if kind in ("uniform", "none"):
            return EnvironmentMap.uniform(self._device, environment.color if kind == "uniform" else (0.0, 0.0, 0.0))
        studio = _studio()
        try:
            if kind == "studio":
                return EnvironmentMap.from_file(self._device, studio)
            if self.baker is None:
                raise InputError(
                    f"environment {kind!r} has to be baked first", hint="open the scene through the importers"
                )
            file = self._baked_file(key, environment)
            return EnvironmentMap.from_file(self._device, file) if file is not None else None
        except InputError as error:
            self.findings.error("environment.unreadable", str(error), hint="the studio is shown instead")
            return EnvironmentMap.from_file(self._device, studio)

    def release(self) -> None:
        for env_map in self._maps.values():
            env_map.release()
        self._maps.clear()
        self._shown = None


def _studio() -> Path:
    return shaders_dir() / "data" / "studio.env.dds"


def environment_key(environment: EnvironmentAsset) -> tuple[object, ...]:
    """What of an environment asks for another map; its intensity and rotation do not."""
    if environment.kind == "uniform":
        return ("uniform", environment.color)
    if environment.kind == "image":
        return ("image", environment.path)
    if environment.kind == "sky":
        return ("sky", environment.sun_elevation, environment.sun_azimuth, environment.turbidity)
    return (environment.kind,)


def usable(environment: EnvironmentAsset) -> EnvironmentAsset:
    """`environment` itself, or a copy with every number usable: not finite becomes the default, brightness is kept in
    [0, MAX_BRIGHTNESS]. Files are checked when they are read; this is for what scripts and animations set."""
    bad: dict[str, Any] = {}
    for name, default in _DEFAULTS:
        value = getattr(environment, name)
        parts = value if isinstance(value, tuple) else (value,)
        top = math.inf if name in _ANGLES else MAX_BRIGHTNESS
        if not all((0.0 <= v <= top or name in _ANGLES) and math.isfinite(v) for v in parts):
            defaults = default if isinstance(default, tuple) else (default,)
            fixed = tuple(
                d if not math.isfinite(v) else v if name in _ANGLES else min(max(v, 0.0), top)
                for v, d in zip(parts, defaults, strict=True)
            )
            bad[name] = fixed if isinstance(value, tuple) else fixed[0]
    return replace(environment, **bad) if bad else environment


_ANGLES = frozenset({"rotation", "sun_elevation", "sun_azimuth"})
_DEFAULTS = [
    (field.name, field.default) for field in fields(EnvironmentAsset) if isinstance(field.default, (float, tuple))
]
