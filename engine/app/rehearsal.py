"""Rehearsal: the programs of other render paths and debug views are made while nothing else is to do.

    the window rests ──► step(view, patience): a small picture of the next path or view, in slices, that nobody sees
                         ──► its programs are in the caches, known to the driver ──► the switch has nothing to wait for
    the scene, its effects or its settings change ──► from the start;  SECONDS are spent ──► enough

A small renderer of its own draws the pictures, with the programs of the one that is shown. Its targets go with it.
"""

from __future__ import annotations

import time
from collections.abc import Hashable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from engine.core.errors import LucarnaError
from engine.render.environments import Environments
from engine.render.lighting import PATHS
from engine.render.programs import Programs
from engine.render.renderer import Renderer
from engine.render.scene_variants import SceneVariants
from engine.render.settings import DEBUG_VIEWS, NONFINITE
from engine.render.view import View

if TYPE_CHECKING:
    from engine.app.runtime import Runtime

#: of work on one state of a scene; what is left then is made when it is asked for
SECONDS = 60.0
#: the pictures are so many times smaller than the one that is shown, in width and height
SMALLER = 8


class Rehearsal:
    """Of an open runtime. `done` of `total` other paths and views are ready."""

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._stage: Renderer | None = None
        self._key: Hashable = None
        self._pending: list[dict[str, Any]] = []
        self._spent = 0.0
        self.total = 0

    @property
    def done(self) -> int:
        return self.total - len(self._pending)

    def step(self, view: View, patience: float) -> bool:
        """Spend about `patience` seconds; whether more is to do. Between the device's begin_frame and end_frame."""
        scene, renderer, effects = self._runtime.scene, self._runtime.renderer, self._runtime.residency.effects
        key = (id(scene), renderer.draws.built_rev, effects.revision, _rest(view), view.width, view.height)
        if key != self._key:
            self._key = key
            self._pending = _others(view)
            self.total, self._spent = len(self._pending), 0.0
        if not self._pending:
            return False
        begun = time.perf_counter()
        if self._draw(view, patience):
            self._pending.pop(0)
        self._spent += time.perf_counter() - begun
        if self._spent > SECONDS:
            self._pending.clear()
        if not self._pending:
            self.release()
        return bool(self._pending)

    def release(self) -> None:
        """Let the small renderer go; the programs stay."""
        stage, self._stage = self._stage, None
        if stage is not None:
            stage.programs = Programs(self._runtime.device, self._runtime.residency.effects)
            stage.environments = Environments(self._runtime.device)
            stage.release()

    def _draw(self, view: View, patience: float) -> bool:
        """A slice of the next picture; whether it is done with, be it that it cannot be made."""
        stage = self._stage or self._make()
        values = {**view.settings.values(), **self._pending[0]}
        small = replace(
            view, width=max(view.width // SMALLER, 32), height=max(view.height // SMALLER, 32),
            settings=type(view.settings)(**values),
        )  # fmt: skip
        programs = stage.programs
        with programs.aside():
            try:
                return stage.follow(self._runtime.scene, small, patience) is not None
            except LucarnaError:
                return True  # it is told where it is asked for

    def _make(self) -> Renderer:
        runtime = self._runtime
        stage = self._stage = Renderer(runtime.device, runtime.residency, profile=False)
        stage.programs.release()
        stage.programs = runtime.renderer.programs
        stage.environments.release()
        stage.environments = runtime.renderer.environments
        stage.variants = SceneVariants(runtime.residency, stage.programs, stage.draws)
        stage.leads = False
        return stage


def _others(view: View) -> list[dict[str, Any]]:
    """The settings of the other paths, then of the other debug views."""
    settings = view.settings
    paths = [{"path": path} for path in PATHS if path != settings.path]
    return paths + [{"view": name} for name in DEBUG_VIEWS if name != settings.view and name != NONFINITE]


def _rest(view: View) -> Hashable:
    """What else of the settings may choose programs: all but what changes from moment to moment."""
    values = view.settings.values()
    left_out = ("exposure", "environment_rotation", "environment_intensity", "sun_intensity", "view", "path")
    return tuple((name, value) for name, value in values.items() if name not in left_out)
