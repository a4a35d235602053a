"""ObjectMaterials: what an object's material is other in than the file says, by slot, without a file of its own.

scene file: mesh.overrides[slot] = {"roughness": 0.2} ──► a variation of the material (a row of the same table)
    ──► the instances of that node and slot; the batch stays one
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.scene import MeshRef
from engine.core.errors import InputError, LucarnaError, UsageError
from engine.core.findings import Findings
from engine.resources.residency import Residency
from engine.scene.scene import Scene


class ObjectMaterials:
    """Of one open scene. Values are kept in `scene.sources`, from where the scene is saved."""

    def __init__(self, scene: Scene, residency: Residency) -> None:
        self._scene = scene
        self._residency = residency

    def load(self, findings: Findings) -> None:
        """Apply what the scene's file says; what no effect takes is told, and stays in the file."""
        for node, source in list(self._scene.sources.items()):
            if source.mesh is None or not any(source.mesh.overrides):
                continue
            said = [dict(values) for values in source.mesh.overrides]
            for slot, values in enumerate(said):
                good = {}
                for name, value in values.items():
                    try:
                        good[name] = self._param(node, slot, name).check(value)
                    except LucarnaError as error:
                        place = f"{source.name}: mesh.overrides[{slot}].{name}"
                        findings.error("object.override", error.message, place, error.hint)
                if good:
                    self._show(node, slot, good)
                values.update(good)
            self._scene.sources[node] = replace(source, mesh=replace(source.mesh, overrides=said))

    def values(self, node: int, slot: int) -> dict[str, Any]:
        """What the object says itself of the material in a slot."""
        source = self._scene.sources.get(node)
        said = source.mesh.overrides if source is not None and source.mesh is not None else []
        return dict(said[slot]) if 0 <= slot < len(said) else {}

    def slots(self, node: int) -> dict[int, int]:
        """slot -> the material that the object has there, as its file is (no variation)."""
        materials = self._residency.materials
        rows = np.flatnonzero(self._scene.instances.node == node)
        found = {self._slot(int(row)): int(self._scene.instances.material[row]) for row in rows}
        return {slot: materials.base_of(material) for slot, material in sorted(found.items())}

    def set(self, node: int, slot: int, changes: Mapping[str, Any]) -> None:
        """Let parameters be other on this object; None: as the material says again. Raises UsageError, InputError; then
        nothing is changed."""
        source = self._scene.sources.get(node)
        if source is None or source.mesh is None or slot not in self.slots(node):
            raise InputError(f"node {node} has no material in slot {slot}")
        now = self.values(node, slot)
        for name, value in changes.items():
            if value is None:
                now.pop(name, None)
            else:
                now[name] = self._param(node, slot, name).check(value)
        said = [*map(dict, source.mesh.overrides), *({} for _ in range(slot + 1 - len(source.mesh.overrides)))]
        said[slot] = now
        while said and not said[-1]:
            said.pop()
        self._show(node, slot, self._taken(node, slot, now))
        mesh: MeshRef = replace(source.mesh, overrides=said)
        self._scene.sources[node] = replace(source, mesh=mesh)

    def agree(self, nodes: Sequence[int]) -> None:
        """Let these nodes be drawn with what they say, after their rows came back from another state of the scene: the
        variations that they had then may have changed since, or serve another object."""
        table, sources = self._scene.instances, self._scene.sources
        rows = np.flatnonzero(table.alive & np.isin(table.node, nodes))
        base_of = np.array([record.base for record in self._residency.materials.records], np.int64)
        varied = {int(table.node[row]) for row in rows if base_of[table.material[row]] >= 0}
        saying = {n for n in nodes if n in sources and (mesh := sources[n].mesh) is not None and any(mesh.overrides)}
        for node in sorted(varied | saying.intersection(table.node[rows].tolist())):
            for slot in self.slots(node):
                values = self._taken(node, slot, self.values(node, slot))
                if not all(self._shows(m, values) for m in table.material[self._rows(node, slot)].tolist()):
                    self._show(node, slot, values)

    def named(self, name: str, param: str, value: str) -> int:
        """Set a parameter of all objects of that name, given as text; how many there were. Raises UsageError (did you
        mean)."""
        sources = self._scene.sources
        nodes = [node for node, source in sources.items() if source.name == name and source.mesh is not None]
        if not nodes:
            from engine.materials.suggest import hint

            known = {source.name for source in sources.values() if source.mesh is not None}
            raise UsageError(f"there is no object {name!r}", hint=hint(name, known))
        for node in nodes:
            slots = self.slots(node)
            having = [s for s, m in slots.items() if param in self._residency.effect_of(m).param_by_name]
            for slot in having or list(slots)[:1]:  # the first one's effect says what it has
                self.set(node, slot, {param: value})
        return len(nodes)

    # --- inside ---

    def _param(self, node: int, slot: int, name: str) -> Any:
        slots = self.slots(node)
        if slot not in slots:
            raise InputError(f"the mesh has no material slot {slot}", hint=f"it has {', '.join(map(str, slots))}")
        return self._residency.effect_of(slots[slot]).param(name)

    def _slot(self, instance: int) -> int:
        table = self._scene.instances
        part = self._residency.meshes[int(table.mesh[instance])].asset.submeshes[int(table.submesh[instance])]
        return max(part.material_slot, 0)

    def _show(self, node: int, slot: int, values: Mapping[str, Any]) -> None:
        table, materials = self._scene.instances, self._residency.materials
        rows = self._rows(node, slot)
        now = int(table.material[rows[0]])
        base = materials.base_of(now)
        if not values:
            self._put(rows, base)
        elif now != base and not self._shared(now, rows):
            materials.override(now, values)
        else:
            self._put(rows, self._variation(base, values))

    def _variation(self, base: int, values: Mapping[str, Any]) -> int:
        """A variation of `base` with these values: one that nothing shows any more, else a new one."""
        table, materials = self._scene.instances, self._residency.materials
        shown = set(table.material[table.alive].tolist())
        free = next((material for material in materials.variations(base) if material not in shown), None)
        if free is None:
            return materials.derive(base, values)
        materials.override(free, values)
        return free

    def _shows(self, material: int, values: Mapping[str, Any]) -> bool:
        """Whether a material is the variation with these values; without any, whether it is none."""
        record = self._residency.material(material)
        return (record.base >= 0) == bool(values) and record.overrides == values

    def _taken(self, node: int, slot: int, values: Mapping[str, Any]) -> dict[str, Any]:
        """Those of `values` that the effect takes."""
        params = self._residency.effect_of(self.slots(node)[slot]).param_by_name
        taken = {}
        for name, value in values.items():
            with contextlib.suppress(LucarnaError):  # of what the file says wrong `load` has told
                if name in params:
                    taken[name] = params[name].check(value)
        return taken

    def _rows(self, node: int, slot: int) -> NDArray[np.intp]:
        table = self._scene.instances
        mine = np.flatnonzero((table.node == node) & table.alive)
        return np.array([row for row in mine if self._slot(int(row)) == slot], np.intp)

    def _shared(self, material: int, rows: NDArray[np.intp]) -> bool:
        """Whether other instances than these have that material: a copy of the object has it too."""
        users = np.flatnonzero(self._scene.instances.material == material)
        return bool(np.setdiff1d(users, rows).size)

    def _put(self, rows: NDArray[np.intp], material: int) -> None:
        if (self._scene.instances.material[rows] != material).any():
            self._scene.instances.set_material(rows, material)
