"""What a batch asks of the effect library in each role: the variant by its draw state and the facts of the frame."""

from __future__ import annotations

from dataclasses import replace

from engine.gpu.types import BlendState
from engine.materials.effect import Effect
from engine.materials.features import kept
from engine.materials.variant import VariantRequest
from engine.render.blocks import SCENE_PRELUDE
from engine.render.draw_states import DrawState, arena_streams, caster_state, casts_shadow
from engine.render.facts import SceneFacts
from engine.render.gbuffer import LAYOUTS
from engine.render.planar.mirrors import PRELUDE as PLANAR_PRELUDE
from engine.resources.arena import MeshArena

PREMULTIPLIED = BlendState("one", "one_minus_src_alpha", "add", "one", "one_minus_src_alpha", "add")
ADDITIVE = BlendState("one", "one", "add", "one", "one", "add")
#: debug views that look at texture coordinates, also of what has no texture
UV_VIEWS = frozenset({"texel_density", "uv_checker"})


def level_of(state: DrawState, facts: SceneFacts) -> str:
    """By hand, else by the quality setting."""
    return state.level or facts.quality


def surface_role(state: DrawState, facts: SceneFacts, effect: Effect) -> str:
    deferred = facts.lighting.deferred and not state.blended and "gbuffer" in effect.techniques
    return "gbuffer" if deferred else "forward"


def requests_of(
    state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect, *, depth: bool, shadow: bool
) -> list[VariantRequest]:
    """What a batch of that state is drawn with: its surface, and where the frame has such passes depth and shadow."""
    requests = [surface_request(state, arena, facts, effect)]
    if depth and not state.blended and "depth" in effect.techniques:
        requests.append(depth_request(state, arena, facts, effect))
    if shadow and casts_shadow(state, effect):
        requests.append(shadow_request(caster_state(state, effect), arena, effect, facts))
    return requests


def shadow_request(state: DrawState, arena: MeshArena, effect: Effect, facts: SceneFacts) -> VariantRequest:
    streams = arena_streams(arena, effect, state.features, "shadow")
    return VariantRequest(
        state.effect, "shadow", state.features, arena.attributes(streams), topology=state.topology, targets=0,
        prelude=SCENE_PRELUDE, level=level_of(state, facts),
    )  # fmt: skip


def depth_request(state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect) -> VariantRequest:
    streams = arena_streams(arena, effect, state.features, "depth")
    return VariantRequest(
        state.effect, "depth", kept(effect.active("depth", state.features), state.features), arena.attributes(streams),
        topology=state.topology, cull=state.cull, front_ccw=state.front_ccw, targets=0, prelude=SCENE_PRELUDE,
        defines=_coverage(state, facts), level=level_of(state, facts),
    )  # fmt: skip


def _coverage(state: DrawState, facts: SceneFacts) -> tuple[tuple[str, int], ...]:
    """The macro of alpha to coverage, for what is cut out."""
    wanted = facts.alpha_to_coverage and "alpha_test" in state.features
    return (("ALPHA_TO_COVERAGE", facts.samples),) if wanted else ()


def _local_lights(state: DrawState, facts: SceneFacts, effect: Effect, role: str) -> int:
    """The macro LOCAL_LIGHTS (shaders/lib/local_lights.glsl)."""
    lighting = facts.lighting
    if role == "gbuffer" or not (facts.local_lights or facts.force_all):
        return 0
    if lighting.path == "forward":
        return 1
    if state.blended:
        return 2
    # what is not in the depth that the lists were made from reads none of them
    return 2 if lighting.path == "forward-plus" and "depth" in effect.techniques else 1


def surface_request(state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect) -> VariantRequest:
    role = surface_role(state, facts, effect)
    streams = arena_streams(arena, effect, state.features, role)
    if facts.debug_view in UV_VIEWS and "uv0" in arena.layout and "uv0" not in streams:
        streams = (*streams, "uv0")
    lighting = facts.lighting
    defines = {
        "HAS_UV0": int("uv0" in streams), "BLENDED": int(state.blended), **facts.variant_defines(),
        "LOOP_STEPS": lighting.steps, "GBUFFER": int(role == "gbuffer"), "GBUFFER_LAYOUT": lighting.gbuffer,
        "LOCAL_LIGHTS": _local_lights(state, facts, effect, role),
    }  # fmt: skip
    defines |= dict(_coverage(state, facts))
    if state.transmissive and not state.veil:
        defines["SOLID"] = 1  # what is seen through it is its colour, not its alpha
    # nothing but local lights asks for it
    defines["MULTISAMPLED"] = int(facts.samples > 1 and defines["LOCAL_LIGHTS"] > 0)
    request = VariantRequest(
        state.effect, role, state.features, arena.attributes(streams), topology=state.topology, cull=state.cull,
        front_ccw=state.front_ccw, depth_write=False if state.veil else None,
        prelude=SCENE_PRELUDE + PLANAR_PRELUDE * defines["PLANAR_MIRRORS"],
        targets=1 + len(LAYOUTS[lighting.gbuffer]) * (role == "gbuffer"),
        defines=tuple(sorted(defines.items())), level=level_of(state, facts), blended=state.blended,
    )  # fmt: skip
    if facts.debug_view == "wireframe":
        request = replace(request, fill="wireframe")
    if facts.debug_view == "overdraw":
        return replace(request, blend=ADDITIVE)
    return request
