"""The numbers of meshes and materials in a journal's line, and what they mean: files. No imgui.

Numbers are given in the order in which things were loaded, and a preview loads too, which no journal tells of. So a
line says of which files the numbers in it are, and who replays it puts those in their places that they have then.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from editor.commands.command import Edit
from editor.commands.structure import StructureCommand

#: stands for the material of what names none
DEFAULT = ""


def meant(edit: Edit, residency: Any) -> dict[str, Any]:
    """What the numbers in `edit` mean: {"meshes": [[number, file, place in it], …], "materials": [[number, file], …]};
    {} where there are none. Of a variation it is the material that it varies: what it says is in the scene."""
    meshes, materials = _numbers(edit)
    if not (meshes or materials) or not hasattr(residency, "mesh_files"):
        return {}
    places = {n: (str(path), i) for path, ids in residency.mesh_files.items() for i, n in enumerate(ids)}
    return {
        "meshes": [[n, *places[n]] for n in sorted(meshes) if n in places],
        "materials": [[n, file] for n in sorted(materials) if (file := _file_of(residency, n)) is not None],
    }


def in_place(data: Mapping[str, Any], said: Mapping[str, Any], residency: Any) -> dict[str, Any]:
    """The line's edit with the numbers that those files have here, which are loaded where they are not. Raises
    LucarnaError, and KeyError, TypeError or ValueError for what `meant` never said."""
    if not said:
        return dict(data)
    mesh = {int(n): int(residency.load_mesh_file(Path(f))[int(place)]) for n, f, place in said["meshes"]}
    named = [(int(n), Path(f)) for n, f in said["materials"] if f != DEFAULT]
    numbers = residency.load_materials([file for _n, file in named])
    material = {n: int(number) for (n, _file), number in zip(named, numbers, strict=True)}
    material |= {int(n): int(residency.default_material) for n, f in said["materials"] if f == DEFAULT}
    if "selection" not in data:
        return {**data, "rows": [material.get(int(r), r) for r in data["rows"]]}
    changed = dict(data)
    for side in ("before", "after"):
        rows = data[side]["tables"]["instances"]
        here = (("mesh", mesh), ("material", material))
        columns = {name: [of.get(n, n) for n in rows["columns"][name]] for name, of in here}
        instances = {**rows, "columns": {**rows["columns"], **columns}}
        changed[side] = {**data[side], "tables": {**data[side]["tables"], "instances": instances}}
    changed["overrides"] = [
        [[t, c, material.get(r, r) if t == "materials" else r, v] for t, c, r, v in part] for part in data["overrides"]
    ]
    return changed


def _numbers(edit: Edit) -> tuple[set[int], set[int]]:
    """(meshes, materials) that an edit speaks of."""
    if not isinstance(edit, StructureCommand):
        table, _column, rows = edit.target
        return set(), {int(r) for r in rows} if table == "materials" else set()
    meshes: set[int] = set()
    materials = {row for side in edit.overrides for table, _c, row in side if table == "materials"}
    for side in (edit.patch.before, edit.patch.after):
        columns = side.tables["instances"].columns
        meshes |= set(columns["mesh"][columns["alive"]].tolist())
        materials |= set(columns["material"][columns["alive"]].tolist())
    return meshes - {-1}, materials - {-1}


def _file_of(residency: Any, material: int) -> str | None:
    """The file of a material, DEFAULT for that of what names none; None where it came from nowhere."""
    material = residency.materials.base_of(material)
    if residency.is_default(material):
        return DEFAULT
    return str(residency.material(material).path) or None
