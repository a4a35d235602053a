"""TintPrograms: the pipelines that draw what blended surfaces leave of the sun's light, by draw state."""

from __future__ import annotations

from engine.gpu.types import Pipeline
from engine.materials.effect import Effect
from engine.materials.features import kept
from engine.materials.variant import VariantRequest
from engine.render.blocks import SCENE_PRELUDE
from engine.render.draw_states import DrawState, arena_streams
from engine.render.facts import SceneFacts
from engine.render.frame import RenderFrame
from engine.render.variant_requests import level_of
from engine.resources.arena import MeshArena

ROLE = "tint"


def tint_request(
    state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect, index: int = 0
) -> VariantRequest:
    """The faces that the surface shows are those that tint: a closed body does so once, with both faces twice."""
    streams = arena_streams(arena, effect, state.features, ROLE)
    solid = state.transmissive and not state.veil  # its alpha says nothing
    return VariantRequest(
        state.effect, ROLE, kept(effect.active(ROLE, state.features), state.features), arena.attributes(streams),
        topology=state.topology, cull=state.cull, front_ccw=state.front_ccw, targets=1, prelude=SCENE_PRELUDE,
        defines=(("SOLID", 1),) if solid else (), level=level_of(state, facts), index=index,
    )  # fmt: skip


class TintPrograms:
    """Asks the effect library once for each; again after a hot reload."""

    def __init__(self) -> None:
        self._found: dict[tuple[object, ...], Pipeline] = {}
        self._revision = -1

    def get(self, frame: RenderFrame, state: DrawState, index: int) -> Pipeline:
        """Magenta stands in for what does not compile; the frame's programs keep why."""
        effects = frame.residency.effects
        if self._revision != effects.revision:
            self._found.clear()
            self._revision = effects.revision
        key = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, state.veil,
            state.level, frame.facts.quality, index,
        )  # fmt: skip
        pipeline = self._found.get(key)
        if pipeline is None:
            effect, arena = effects.get(state.effect), frame.residency.arenas[state.arena]
            pipeline, error = effects.of_request(
                frame.device, tint_request(state, arena, frame.facts, effect, index), effect
            )
            if error is not None:
                frame.programs.errors[f"{state.effect} tint: {', '.join(sorted(state.features))}"] = error
            self._found[key] = pipeline
        return pipeline
