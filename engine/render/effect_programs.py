"""EffectPrograms: the pipelines that draw batches in one role beside the picture's own: motion, tints, layers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from engine.gpu.types import Pipeline
from engine.materials.effect import Effect
from engine.materials.variant import VariantRequest
from engine.render.draw_states import DrawState
from engine.render.facts import SceneFacts
from engine.render.frame import RenderFrame
from engine.resources.arena import MeshArena

#: what a batch asks of the effect library
Request = Callable[[DrawState, MeshArena, SceneFacts, Effect], VariantRequest]


class EffectPrograms:
    """Asks the effect library once for each draw state; again after a hot reload. `role`: of the technique, for people;
    `request` must depend on nothing of the facts but their quality and samples."""

    def __init__(self, role: str, request: Request) -> None:
        self._role = role
        self._request = request
        self._found: dict[tuple[object, ...], Pipeline] = {}
        self._revision = -1

    def get(self, frame: RenderFrame, state: DrawState, index: int) -> Pipeline:
        """The pipeline of one pass of the technique. Magenta stands in for what does not compile; the frame's programs
        keep why."""
        effects, facts = frame.residency.effects, frame.facts
        if self._revision != effects.revision:
            self._found.clear()
            self._revision = effects.revision
        key = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, state.veil,
            state.transmissive, state.level, facts.quality, facts.samples, index,
        )  # fmt: skip
        pipeline = self._found.get(key)
        if pipeline is None:
            effect, arena = effects.get(state.effect), frame.residency.arenas[state.arena]
            request = replace(self._request(state, arena, facts, effect), index=index)
            pipeline, error = effects.of_request(frame.device, request, effect)
            if error is not None:
                frame.programs.errors[f"{state.effect} {self._role}: {', '.join(sorted(state.features))}"] = error
            self._found[key] = pipeline
        return pipeline
