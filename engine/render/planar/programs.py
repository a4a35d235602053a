"""What draws a mirror's picture: the shading of the frame, less what is known of the frame's own pixels alone."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from engine.gpu.types import Pipeline
from engine.materials.effect import Effect
from engine.materials.variant import VariantRequest
from engine.render.draw_states import DrawState
from engine.render.facts import SceneFacts
from engine.render.frame import RenderFrame
from engine.render.gi.choice import Indirect
from engine.render.lighting import Lighting
from engine.render.occlusion import Occlusion
from engine.render.other_programs import OtherPrograms
from engine.render.planar.choice import Planar
from engine.render.planar.mirrors import CLIP_PRELUDE
from engine.render.refraction import untested
from engine.render.variant_requests import depth_request, surface_request
from engine.resources.arena import MeshArena

ROLE = "forward"


def facts_behind(facts: SceneFacts) -> SceneFacts:
    """What is left of a frame's facts in its mirrors."""
    return replace(
        facts, samples=1, alpha_to_coverage=False, ambient_occlusion=Occlusion(), indirect=Indirect(),
        lighting=lighting_behind(facts), planar=Planar(), refraction=untested(facts.refraction),
        force_all=False,
    )  # fmt: skip


def lighting_behind(facts: SceneFacts) -> Lighting:
    """By all lights, or as in Forward+; whatever path the frame takes, so that all show the same."""
    if not (facts.local_lights and facts.planar.lists):
        return Lighting(steps=facts.lighting.steps)
    return replace(facts.lighting, path="forward-plus", gbuffer=1, three_pass=False, forward_only=False)


def depth_behind(facts: SceneFacts, state: DrawState, arena: MeshArena, effect: Effect, index: int) -> VariantRequest:
    """What draws a solid batch's depth there; `facts`: those behind a mirror."""
    return clipped(depth_request(state, arena, facts, effect), index)


def clipped(request: VariantRequest, index: int) -> VariantRequest:
    defines = dict(request.defines) | {"CLIP_PLANE": 1}
    return replace(
        request, prelude=request.prelude + CLIP_PRELUDE, defines=tuple(sorted(defines.items())), clip=True, index=index
    )


def mirror_request(facts: SceneFacts, state: DrawState, arena: MeshArena, effect: Effect, index: int) -> VariantRequest:
    """`facts`: those behind a mirror."""
    return clipped(surface_request(state, arena, facts, effect), index)


class MirrorPrograms:
    def __init__(self) -> None:
        self._surfaces, self._depths = OtherPrograms("mirror"), OtherPrograms("depth of a mirror")
        self._facts: tuple[SceneFacts | None, SceneFacts | None] = (None, None)

    def facts(self, frame: RenderFrame) -> SceneFacts:
        """Those behind the mirrors of a frame."""
        if self._facts[0] != frame.facts:
            self._facts = (frame.facts, facts_behind(frame.facts))
        assert self._facts[1] is not None, "found just now"
        return self._facts[1]

    def surface(self, frame: RenderFrame, state: DrawState, index: int) -> Pipeline:
        facts = self.facts(frame)
        return self._surfaces.get(frame, facts, partial(mirror_request, facts), state, index)

    def depth(self, frame: RenderFrame, state: DrawState, index: int) -> Pipeline:
        facts = self.facts(frame)
        return self._depths.get(frame, facts.quality, partial(depth_behind, facts), state, index)
