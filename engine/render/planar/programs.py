"""MirrorPrograms: the pipelines that draw what a mirror shows, by draw state."""

from __future__ import annotations

from dataclasses import dataclass, replace

from engine.gpu.types import Pipeline
from engine.materials.effect import Effect
from engine.materials.variant import VariantRequest
from engine.render.draw_states import DrawState
from engine.render.facts import SceneFacts
from engine.render.frame import RenderFrame
from engine.render.gi.choice import Indirect
from engine.render.lighting import Lighting
from engine.render.occlusion import Occlusion
from engine.render.planar.choice import Planar
from engine.render.planar.mirrors import CLIP_PRELUDE
from engine.render.variant_requests import surface_request
from engine.resources.arena import MeshArena

ROLE = "forward"


def facts_behind(facts: SceneFacts) -> SceneFacts:
    """What is left of a frame's facts in its mirrors: nothing that is known of the frame's own pixels alone."""
    return replace(
        facts, samples=1, alpha_to_coverage=False, ambient_occlusion=Occlusion(), indirect=Indirect(),
        lighting=Lighting(steps=facts.lighting.steps), planar=Planar(), force_all=False,
    )  # fmt: skip


def mirror_request(state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect, index: int) -> VariantRequest:
    request = surface_request(state, arena, facts, effect)
    defines = dict(request.defines) | {"CLIP_PLANE": 1}
    return replace(
        request, prelude=request.prelude + CLIP_PRELUDE, defines=tuple(sorted(defines.items())), clip=True, index=index
    )


@dataclass(slots=True)
class MirrorPrograms:
    """Asks the effect library once for each; again after a hot reload or with other facts."""

    _found: dict[tuple[object, ...], Pipeline]
    _key: tuple[object, ...] = ()
    _facts: SceneFacts | None = None

    def get(self, frame: RenderFrame, state: DrawState, index: int) -> Pipeline:
        """Magenta stands in for what does not compile; the frame's programs keep why."""
        effects = frame.residency.effects
        key = (effects.revision, frame.facts)
        if self._key != key:
            self._found.clear()
            self._key, self._facts = key, facts_behind(frame.facts)
        assert self._facts is not None
        of = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, state.blended,
            state.veil, state.level, index,
        )  # fmt: skip
        pipeline = self._found.get(of)
        if pipeline is None:
            effect, arena = effects.get(state.effect), frame.residency.arenas[state.arena]
            request = mirror_request(state, arena, self._facts, effect, index)
            pipeline, error = effects.of_request(frame.device, request, effect)
            if error is not None:
                frame.programs.errors[f"{state.effect} mirror: {', '.join(sorted(state.features))}"] = error
            self._found[of] = pipeline
        return pipeline
