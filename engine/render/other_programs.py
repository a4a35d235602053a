"""OtherPrograms: pipelines of batches that a pass draws in a way of its own, by draw state."""

from __future__ import annotations

from collections.abc import Callable, Hashable

from engine.gpu.types import Pipeline
from engine.materials.effect import Effect
from engine.materials.variant import VariantRequest
from engine.render.draw_states import DrawState
from engine.render.frame import RenderFrame
from engine.resources.arena import MeshArena

#: what a batch of a state asks of the library: the variant of (state, arena, effect, pass of the technique)
Request = Callable[[DrawState, MeshArena, Effect, int], VariantRequest]


class OtherPrograms:
    """Asks the effect library once for each; again after a hot reload, or under another key."""

    def __init__(self, label: str) -> None:
        """`label` tells what failed to compile from other pipelines of the same state."""
        self._label = label
        self._found: dict[tuple[object, ...], Pipeline] = {}
        self._key: tuple[object, ...] = ()

    def get(self, frame: RenderFrame, key: Hashable, request: Request, state: DrawState, index: int) -> Pipeline:
        """`key`: all that `request` depends on besides the state. Magenta stands in for what does not compile; the
        frame's programs keep why."""
        effects = frame.residency.effects
        if self._key != (effects.revision, key):
            self._found.clear()
            self._key = (effects.revision, key)
        of = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, state.queue,
            state.level, index,
        )  # fmt: skip
        pipeline = self._found.get(of)
        if pipeline is None:
            effect, arena = effects.get(state.effect), frame.residency.arenas[state.arena]
            pipeline, error = effects.of_request(frame.device, request(state, arena, effect, index), effect)
            if error is not None:
                frame.programs.errors[f"{state.effect} {self._label}: {', '.join(sorted(state.features))}"] = error
            self._found[of] = pipeline
        return pipeline
