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
from engine.render.variant_requests import surface_request
from engine.resources.arena import MeshArena

ROLE = "forward"


def facts_behind(facts: SceneFacts) -> SceneFacts:
    """What is left of a frame's facts in its mirrors."""
    return replace(
        facts, samples=1, alpha_to_coverage=False, ambient_occlusion=Occlusion(), indirect=Indirect(),
        lighting=Lighting(steps=facts.lighting.steps), planar=Planar(), refraction=untested(facts.refraction),
        force_all=False,
    )  # fmt: skip


def mirror_request(facts: SceneFacts, state: DrawState, arena: MeshArena, effect: Effect, index: int) -> VariantRequest:
    """`facts`: those behind a mirror."""
    request = surface_request(state, arena, facts, effect)
    defines = dict(request.defines) | {"CLIP_PLANE": 1}
    return replace(
        request, prelude=request.prelude + CLIP_PRELUDE, defines=tuple(sorted(defines.items())), clip=True, index=index
    )


class MirrorPrograms:
    def __init__(self) -> None:
        self._programs = OtherPrograms("mirror")
        self._facts: tuple[SceneFacts | None, SceneFacts | None] = (None, None)

    def get(self, frame: RenderFrame, state: DrawState, index: int) -> Pipeline:
        if self._facts[0] != frame.facts:
            self._facts = (frame.facts, facts_behind(frame.facts))
        facts = self._facts[1]
        assert facts is not None, "found just now"
        return self._programs.get(frame, facts, partial(mirror_request, facts), state, index)
