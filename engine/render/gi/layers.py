"""What a batch asks of the effect library for the layers of the deep G-buffer."""

from __future__ import annotations

from engine.materials.effect import Effect
from engine.materials.features import kept
from engine.materials.variant import VariantRequest
from engine.render.blocks import SCENE_PRELUDE
from engine.render.draw_states import DrawState, arena_streams
from engine.render.facts import SceneFacts
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


def layer_request(state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect, layer: int) -> VariantRequest:
    streams = arena_streams(arena, effect, state.features, ROLE)
    defines = {**dict.fromkeys(UNLIT, 0), "LOOP_STEPS": 1, "HAS_UV0": int("uv0" in streams), "LAYER": layer}
    return VariantRequest(
        state.effect, ROLE, kept(effect.active(ROLE, state.features), state.features), arena.attributes(streams),
        topology=state.topology, cull=state.cull, front_ccw=state.front_ccw, targets=2,
        prelude=SCENE_PRELUDE + PRELUDE, defines=tuple(sorted(defines.items())), level=level_of(state, facts),
    )  # fmt: skip
