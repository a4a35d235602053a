"""Programs: pipelines by what a batch or a pass needs."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from engine.core.errors import ShaderError
from engine.gpu.types import Device, Pipeline
from engine.materials.effect import Effect
from engine.materials.library import EffectLibrary
from engine.materials.variant import VariantRequest
from engine.render.draw_states import DrawState, tints_light
from engine.render.facts import SceneFacts
from engine.render.gi import layers
from engine.render.motion import request as motion
from engine.render.pass_programs import PassPrograms
from engine.render.shadows import tint_request as tints
from engine.render.variant_requests import (
    depth_request,
    level_of,
    requests_of,
    shadow_request,
    surface_request,
    surface_role,
)
from engine.resources.arena import MeshArena
from engine.resources.material_store import MaterialRecord


class Programs(PassPrograms):
    """Caches by key: one dict look-up a batch in the steady state. `errors`: what failed to compile and is drawn in
    magenta, by variant."""

    def __init__(self, device: Device, effects: EffectLibrary) -> None:
        super().__init__(device, effects)
        self._surface: dict[tuple[object, ...], Pipeline] = {}
        self._depth: dict[tuple[object, ...], Pipeline] = {}
        self._shadow: dict[tuple[object, ...], Pipeline] = {}
        self._counts: dict[tuple[object, ...], int] = {}
        self._revision = effects.revision
        self._facts: SceneFacts | None = None
        self._macros_of: tuple[SceneFacts | None, tuple[object, ...]] = (None, ())
        self.errors: dict[str, ShaderError] = {}

    def forget(self) -> None:
        """Ask the library again for every pipeline (after a hot reload)."""
        self._surface.clear()
        self._depth.clear()
        self._shadow.clear()
        self._counts.clear()
        self.errors.clear()
        self._revision = self._effects.revision
        self.ahead.forget()

    def release(self) -> None:
        """Let the pipelines of the passes go; the library owns those of surfaces."""
        self.forget()
        super().release()

    @contextlib.contextmanager
    def aside(self) -> Iterator[None]:
        """While another renderer draws with these programs what nobody sees: the last frame's facts come back."""
        facts = self._facts
        try:
            yield
        finally:
            self._facts = facts
            self.ahead.forget_frame()

    # --- surfaces ---

    def passes(self, state: DrawState, facts: SceneFacts, role: str = "") -> int:
        """How often a batch is drawn: the passes of its technique for `role` ('': forward or G-buffer)."""
        if self._revision != self._effects.revision:
            self.forget()
        key = (state.effect, state.level, facts.quality, role or (facts.lighting.deferred, state.blended))
        count = self._counts.get(key)
        if count is None:
            effect = self._effects.get(state.effect)
            count = self._counts[key] = self._count(effect, role or surface_role(state, facts, effect), state, facts)
        return count

    def _count(self, effect: Effect, role: str, state: DrawState, facts: SceneFacts) -> int:
        technique, _ = effect.technique(role).at(level_of(state, facts), self._device.caps)
        return len(technique.passes) if technique is not None else 1

    def surface(self, state: DrawState, arena: MeshArena, facts: SceneFacts, samples: int, index: int = 0) -> Pipeline:
        """The pipeline of a batch; `index`: which of its passes."""
        if self._revision != self._effects.revision:
            self.forget()
        key = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, state.blended,
            state.veil, self._macros(facts), facts.lighting, facts.samples > 1,
            facts.alpha_to_coverage and facts.samples, state.level, facts.quality, index,
        )  # fmt: skip
        pipeline = self._surface.get(key)
        if pipeline is None:
            effect = self._effects.get(state.effect)
            request = replace(surface_request(state, arena, facts, effect), index=index)
            pipeline, error = self._effects.of_request(self._device, request, effect)
            if error is not None:
                self.errors[f"{state.effect}: {', '.join(sorted(state.features))}"] = error
            self._surface[key] = pipeline
        self._facts = facts
        return pipeline

    def _macros(self, facts: SceneFacts) -> tuple[object, ...]:
        """What of the facts goes into the text of surface shaders, made once a frame."""
        if facts is not self._macros_of[0]:
            more = (facts.local_lights, facts.debug_view, facts.force_all)
            self._macros_of = (facts, (*facts.variant_defines().values(), *more))
        return self._macros_of[1]

    def shadow(self, state: DrawState, arena: MeshArena, facts: SceneFacts, index: int = 0) -> Pipeline:
        """The pipeline that draws the depth of a caster; one that does not compile draws it uncut."""
        if self._revision != self._effects.revision:
            self.forget()
        key = (state.effect, state.features, state.arena, state.topology, state.level, facts.quality, index)
        self._facts = facts  # also where nothing but shadows is in the picture
        pipeline = self._shadow.get(key)
        if pipeline is None:
            effect = self._effects.get(state.effect)
            request = replace(shadow_request(state, arena, effect, facts), index=index)
            pipeline, error = self._effects.of_request(self._device, request, effect)
            if error is not None:
                self.errors[f"{state.effect} shadow: {', '.join(sorted(state.features))}"] = error
            self._shadow[key] = pipeline
        return pipeline

    def depth(self, state: DrawState, arena: MeshArena, facts: SceneFacts, index: int = 0) -> Pipeline:
        """The pipeline that draws a solid batch's depth alone."""
        if self._revision != self._effects.revision:
            self.forget()
        key = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, facts.samples,
            facts.alpha_to_coverage, state.level, facts.quality, index,
        )  # fmt: skip
        pipeline = self._depth.get(key)
        if pipeline is None:
            effect = self._effects.get(state.effect)
            request = replace(depth_request(state, arena, facts, effect), index=index)
            pipeline, error = self._effects.of_request(self._device, request, effect)
            if error is not None:
                self.errors[f"{state.effect} depth: {', '.join(sorted(state.features))}"] = error
            self._depth[key] = pipeline
        return pipeline

    def has_role(self, state: DrawState, role: str) -> bool:
        """Whether the effect of a batch has a technique of that name."""
        return role in self._effects.get(state.effect).techniques

    def uses(
        self,
        states: Iterable[tuple[int, DrawState]],
        records: Mapping[int, MaterialRecord],
        arenas: Sequence[MeshArena],
    ) -> dict[VariantRequest, list[int]]:
        """What `surface` and `shadow` would ask of the library for these (material, state), by the last facts, and the
        materials that want each; also for what only throws its shadow into the picture."""
        found: dict[VariantRequest, list[int]] = {}
        for material, state in states if self._facts is not None else ():
            if self._facts is not None:
                facts, arena, effect = self._facts, arenas[state.arena], records[material].effect
                requests = requests_of(state, arena, facts, effect, depth=bool(self._depth), shadow=bool(self._shadow))
                counts = [self._count(effect, request.role, state, facts) for request in requests]
                every = [
                    replace(request, index=index)
                    for request, count in zip(requests, counts, strict=True)
                    for index in range(count)
                ]
                for request in every:
                    materials = found.setdefault(request, [])
                    if material not in materials:
                        materials.append(material)
        return found

    def wanted(
        self, states: Iterable[tuple[int, DrawState]], facts: SceneFacts, arenas: Sequence[MeshArena]
    ) -> list[VariantRequest]:
        """What a frame with these facts will ask of the library for these (material, state), each once."""
        found: dict[VariantRequest, None] = {}
        shadowed = facts.sun_shadows or facts.local_shadows > 0
        for _, state in states:
            effect = self._effects.get(state.effect)
            arena = arenas[state.arena]
            asked = requests_of(state, arena, facts, effect, depth=facts.depth_first, shadow=shadowed)
            asked += _beside(state, arena, facts, effect)
            for request in asked:
                for index in range(self._count(effect, request.role, state, facts)):
                    found[replace(request, index=index)] = None
        return list(found)

    def begun(self, key: Hashable, wanted: Callable[[], Iterable[VariantRequest]]) -> bool:
        """Whether all that is wanted can be had without a wait; if not, it is begun. See Ahead."""
        if self._revision != self._effects.revision:
            self.forget()
        return self.ahead.begun(key, wanted, self._device, self._effects)


def _beside(state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect) -> list[VariantRequest]:
    """What a batch of that state is drawn with besides its picture: how far it moved, layers, tints."""
    found = []
    if facts.moving and not state.blended and motion.ROLE in effect.techniques:
        found.append(motion.motion_request(state, arena, facts, effect))
    if facts.indirect.wanted and not state.blended and layers.ROLE in effect.techniques:
        found += [layers.layer_request(state, arena, facts, effect, n) for n in range(facts.indirect.layers)]
    if facts.translucent_shadows and tints_light(state, effect):
        found.append(tints.tint_request(state, arena, facts, effect))
    if facts.translucent_lamps and tints_light(state, effect):
        found.append(tints.tint_request(state, arena, facts, effect, lamps=True))
    return found
