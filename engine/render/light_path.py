"""LightPath: by which path local lights reach the surfaces of a frame, with the buffers that it needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from engine.gpu.types import Device
from engine.render.facts import SceneFacts
from engine.render.gbuffer import bytes_per_pixel, layout_of, widest
from engine.render.light_lists import LightLists
from engine.render.lighting import Choice, loop_steps
from engine.render.paths.choice import choose, lighting_of
from engine.render.paths.cost import CostModel
from engine.render.paths.cost import load as load_costs
from engine.render.scene_rows import SceneRows
from engine.render.settings import LIT_LOOK
from engine.render.view import View


class LightPath:
    """`choice`: of the last frame."""

    def __init__(self, device: Device, rows: SceneRows) -> None:
        self._device = device
        self._rows = rows
        self.choice = Choice("forward", 1, "")
        self.cost_model: CostModel = load_costs(device.caps)
        self.lists = LightLists(device)
        #: what the narrowest G-buffer layout was found for, and which it is
        self.layout: tuple[object, int] = ((), 0)
        self._gbuffer_bytes = 0

    def choose(self, view: View, facts: SceneFacts, block: NDArray[np.void]) -> SceneFacts:
        """Choose the path and have its buffers ready; returns the facts with both."""
        settings, lights = view.settings, self._rows.lights.count
        used = facts.local_lights or facts.force_all
        stored = settings.shading_view.startswith("gbuffer_")
        software = self._device.caps.software
        self.choice = choice = choose(
            settings, local_lights=facts.local_lights, lights=lights, pixels=view.width * view.height,
            samples=facts.samples, model=self.cost_model, force_all=facts.force_all,
        )  # fmt: skip
        lighting = lighting_of(
            settings, choice, self._gbuffer_layout() if used or stored else 1, used=used,
            steps=loop_steps(lights, software=software),
            forward_only=any("gbuffer" not in self._techniques(name) for name in self._rows.draws.solid_effects),
        )  # fmt: skip
        self._gbuffer_bytes = view.width * view.height * bytes_per_pixel(lighting.gbuffer) * lighting.deferred
        if lighting.path == "forward":
            self.lists.forget()
        else:
            self.lists.upload_bounds(self._rows.lights.bounds)
            self.lists.prepare(lighting, view.width, view.height, lights)
            block["tiles"], block["clusters"] = self.lists.view_fields(lighting, view.camera.znear)
        smooth = bool(settings.alpha_to_coverage) and choice.samples > 1 and self._rows.draws.has_cutouts
        # filters of the finished picture
        filtered = settings.antialias if choice.samples == 1 and settings.shading_view in LIT_LOOK else "none"
        return replace(
            facts, lighting=lighting, samples=choice.samples, alpha_to_coverage=smooth, fxaa=filtered == "fxaa",
            smaa=filtered == "smaa",
        )  # fmt: skip

    def counters(self, *, wait: bool) -> dict[str, int]:
        """What the light lists of this frame did; nothing where it has none."""
        lists = self.lists
        if not lists.columns:
            return {}
        stats = lists.read(wait=wait)
        counters = {
            "light_lists": stats.tiles, "lights_tested": stats.tested, "lights_kept": stats.kept,
            "light_list_overflows": stats.overflow, "light_list_bytes": lists.bytes,
            "gbuffer_bytes": self._gbuffer_bytes,
        }  # fmt: skip
        if stats.needed < 0:
            return counters
        return {**counters, "lights_needed": stats.needed, "lights_needed_by_pixels": stats.in_pixels}

    def _techniques(self, effect: str) -> Mapping[str, object]:
        return self._rows.residency.effects.get(effect).techniques

    def _gbuffer_layout(self) -> int:
        """The narrowest layout that holds all materials that the scene draws."""
        draws, materials = self._rows.draws, self._rows.residency.materials
        key = (draws.built_rev, materials.values_rev)
        if self.layout[0] != key:
            rows: dict[str, list[int]] = {}
            for material in draws.materials:
                record = materials.records[material]
                rows.setdefault(record.effect.name, []).append(record.row)
            layouts = [layout_of(materials.rows_of(effect)[used]) for effect, used in rows.items()]
            self.layout = (key, widest(layouts))
        return self.layout[1]
