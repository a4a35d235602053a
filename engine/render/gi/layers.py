"""LayerPrograms: the pipelines that draw the layers of the deep G-buffer, by draw state and layer."""

from __future__ import annotations

from engine.gpu.types import Pipeline
from engine.materials.effect import Effect
from engine.materials.features import kept
from engine.materials.variant import VariantRequest
from engine.render.blocks import SCENE_PRELUDE
from engine.render.draw_states import DrawState, arena_streams
from engine.render.facts import SceneFacts
from engine.render.frame import RenderFrame
from engine.render.gi.block import PRELUDE
from engine.render.variant_requests import level_of
from engine.resources.arena import MeshArena

ROLE = "layer"
#: a layer is not lit: of the surface shader's branches none is in
UNLIT = (
    "BLENDED", "ENVIRONMENT", "SUNS", "SUN_SHADOWS", "CASCADE_TINT", "AMBIENT_OCCLUSION", "INDIRECT", "GATHERED",
    "REFLECTIONS", "LOCAL_LIGHTS", "LOCAL_SHADOWS", "SHADOW_FILTER", "DEBUG_VIEW", "AREA_LIGHTS", "LIGHT_PROFILES",
    "GBUFFER", "GBUFFER_LAYOUT", "MULTISAMPLED",
)  # fmt: skip


def layer_request(
    state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect, layer: int, index: int = 0
) -> VariantRequest:
    streams = arena_streams(arena, effect, state.features, ROLE)
    defines = {**dict.fromkeys(UNLIT, 0), "LOOP_STEPS": 1, "HAS_UV0": int("uv0" in streams), "LAYER": layer}
    return VariantRequest(
        state.effect, ROLE, kept(effect.active(ROLE, state.features), state.features), arena.attributes(streams),
        topology=state.topology, cull=state.cull, front_ccw=state.front_ccw, targets=2,
        prelude=SCENE_PRELUDE + PRELUDE, defines=tuple(sorted(defines.items())), level=level_of(state, facts),
        index=index,
    )  # fmt: skip


class LayerPrograms:
    """Asks the effect library once for each; again after a hot reload."""

    def __init__(self) -> None:
        self._found: dict[tuple[object, ...], Pipeline] = {}
        self._revision = -1

    def get(self, frame: RenderFrame, layer: int, state: DrawState, index: int) -> Pipeline:
        """Magenta stands in for what does not compile; the frame's programs keep why."""
        effects = frame.residency.effects
        if self._revision != effects.revision:
            self._found.clear()
            self._revision = effects.revision
        key = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, state.level,
            frame.facts.quality, layer, index,
        )  # fmt: skip
        pipeline = self._found.get(key)
        if pipeline is None:
            effect, arena = effects.get(state.effect), frame.residency.arenas[state.arena]
            request = layer_request(state, arena, frame.facts, effect, layer, index)
            pipeline, error = effects.of_request(frame.device, request, effect)
            if error is not None:
                frame.programs.errors[f"{state.effect} layer: {', '.join(sorted(state.features))}"] = error
            self._found[key] = pipeline
        return pipeline
