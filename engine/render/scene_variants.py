"""SceneVariants: which shader variants a scene's materials want: of surfaces, depth, shadows, computed textures."""

from __future__ import annotations

from collections.abc import Mapping

from engine.materials.variant import VariantRequest
from engine.render.draw_list import DrawList
from engine.render.facts import SceneFacts
from engine.render.programs import Programs
from engine.resources.material_store import MaterialRecord
from engine.resources.residency import Residency


class SceneVariants:
    """Of what one renderer draws."""

    def __init__(self, residency: Residency, programs: Programs, draws: DrawList) -> None:
        self._residency = residency
        self._programs = programs
        self._draws = draws

    def uses(self, records: Mapping[int, MaterialRecord]) -> dict[VariantRequest, list[int]]:
        """What the last frame would have asked for if these materials were as in `records`, seen or not, and the
        materials that want each."""
        found = self._programs.uses(self._draws.states_of(records), records, self._residency.arenas)
        for material in self._draws.materials & records.keys():
            for request in self._residency.procedural.requests([records[material]]):
                found.setdefault(request, []).append(material)
        return found

    def wanted(self, facts: SceneFacts) -> list[VariantRequest]:
        """What a frame with these facts will ask for."""
        records = dict(enumerate(self._residency.materials.records))
        drawn = [records[material] for material in self._draws.materials]
        asked = self._programs.wanted(self._draws.states_of(records), facts, self._residency.arenas)
        return [*self._residency.procedural.requests(drawn), *asked]

    def begun(self, facts: SceneFacts) -> bool:
        """Whether no program of a frame with these facts would be waited for; what would be is begun."""
        key = (facts, self._draws.built_rev, self._residency.effects.revision)
        return self._programs.begun(key, lambda: self.wanted(facts))
