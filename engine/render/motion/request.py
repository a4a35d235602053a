"""What a batch asks of the effect library to draw how far it moved."""

from __future__ import annotations

from engine.gpu.glsl_layout import Field, layout
from engine.materials.effect import Effect
from engine.materials.features import kept
from engine.materials.variant import VariantRequest
from engine.render.blocks import SCENE_PRELUDE
from engine.render.draw_states import DrawState, arena_streams
from engine.render.facts import SceneFacts
from engine.render.variant_requests import level_of
from engine.resources.arena import MeshArena

ROLE = "motion"

BLOCK = layout(
    [
        Field("clip_before", "mat4"),  # the world relative to the origin of before -> its clip space
        Field("before_from_now", "mat4"),  # clip space to clip space
        Field("jitter", "vec2"),  # pixels
        Field("still", "float"),  # 1: nothing was where it is not now
        Field("drawn", "float"),  # 1: what moved is drawn
        Field("nodes", "uint"),  # rows of now before those of before
        Field("joints", "uint"),
        Field("morphs", "uint"),
    ],
    rule="std140",
)
PRELUDE = BLOCK.block_glsl("PassBlock_motion", 1, "motion") + "\n"


def motion_request(state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect) -> VariantRequest:
    """The variant of an effect's technique for motion."""
    streams = arena_streams(arena, effect, state.features, "depth")
    return VariantRequest(
        state.effect, ROLE, kept(effect.active(ROLE, state.features), state.features), arena.attributes(streams),
        topology=state.topology, cull=state.cull, front_ccw=state.front_ccw, targets=1, prelude=SCENE_PRELUDE + PRELUDE,
        defines=(("MOTION", 1),), level=level_of(state, facts),
    )  # fmt: skip
