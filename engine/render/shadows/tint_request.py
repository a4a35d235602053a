"""What a batch asks of the effect library where blended surfaces tint the light of the sun or of lamps."""

from __future__ import annotations

from engine.materials.effect import Effect
from engine.materials.features import kept
from engine.materials.variant import VariantRequest
from engine.render.blocks import SCENE_PRELUDE
from engine.render.draw_states import DrawState, arena_streams
from engine.render.facts import SceneFacts
from engine.render.variant_requests import level_of
from engine.resources.arena import MeshArena

ROLE = "tint"


def tint_request(
    state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect, *, lamps: bool = False
) -> VariantRequest:
    """`lamps`: into tiles of local lights, where another number says how near it is (passes/local_tints.py). The faces
    that the surface shows are those that tint: a closed body does so once, with both faces twice."""
    streams = arena_streams(arena, effect, state.features, ROLE)
    solid = state.transmissive and not state.veil  # its alpha says nothing
    defines = (*((("LAMPS", 1),) if lamps else ()), *((("SOLID", 1),) if solid else ()))
    return VariantRequest(
        state.effect, ROLE, kept(effect.active(ROLE, state.features), state.features), arena.attributes(streams),
        topology=state.topology, cull=state.cull, front_ccw=state.front_ccw, targets=1, prelude=SCENE_PRELUDE,
        defines=defines, level=level_of(state, facts),
    )  # fmt: skip
