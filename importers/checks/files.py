"""Checks of any file that we know: sources are imported in memory, engine files read, and their references followed."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from engine.assets.scene import SceneAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from importers.registry import IMAGES, find_importer, source_extensions
from importers.settings import ImportSettings

if TYPE_CHECKING:
    from importers.contents import Contents

T = TypeVar("T")

#: ending -> kind of our own files; the longer endings first
ENGINE_FILES = {
    ".scene.json": "scene",
    ".material.toml": "material",
    ".effect.toml": "effect",
    ".lmesh": "mesh",
    ".lanim": "clip",
    ".dds": "texture",
}


def engine_kind(path: Path) -> str:
    """Which of our files `path` is by its name, or ''."""
    name = path.name.lower()
    return next((kind for ending, kind in ENGINE_FILES.items() if name.endswith(ending)), "")


def checkable_files(path: Path) -> list[Path]:
    """`path` itself, or all sources and engine files below it, sorted; images where it has nothing else. Raises
    InputError where there are none."""
    if not os.path.isdir(path):  # noqa: PTH112  (false for names that no file can have, too)
        if not os.path.exists(path):  # noqa: PTH110  (as above)
            from importers.gltf.uris import similar_name_hint

            raise InputError("there is no such file or folder", where=path, hint=similar_name_hint(path))
        return [path]
    files = sorted(p for p in path.rglob("*") if not p.name.startswith(".") and p.is_file())
    known = source_extensions(in_folders=True)
    found = [p for p in files if p.name.lower().endswith(known) or engine_kind(p)]
    found = found or [p for p in files if p.name.lower().endswith(IMAGES)]
    if not found:
        raise InputError("the folder holds nothing that can be checked", where=path)
    return found


def perform(request: dict[str, Any], progress: Callable[[str, float], None]) -> dict[str, Any]:
    """`check_file` on a worker's side: {"source", "settings", "budgets"} -> {"findings", "left_out"}."""
    values = {k: tuple(v) if isinstance(v, list) else v for k, v in request["settings"].items()}
    findings = check_file(Path(request["source"]), ImportSettings().replace(**values), request["budgets"])
    return {"findings": [finding.to_json() for finding in findings], "left_out": findings.left_out}


def check_file(path: Path, settings: ImportSettings, budgets: Mapping[str, float] | None = None) -> Findings:
    """All findings of one file; `budgets`: limits by name (see importers.checks.budgets).

    Raises InputError or FormatError where it cannot be read at all."""
    kind = engine_kind(path)
    findings = Findings(str(path))
    contents = None
    if kind == "scene":
        _check_scene(path, findings)
    elif kind == "material":
        _check_material(path, findings)
    elif kind == "effect":
        from importers.effect_inspection import effect_findings

        return effect_findings(path)
    elif not kind:
        findings, contents = _check_source(path, settings)
    from importers.checks.budgets import check_budgets
    from importers.checks.mesh import check_mesh_numbers
    from importers.checks.topology import check_topology
    from importers.contents import load_contents

    if contents is None:  # reading checks meshes, clips and textures; for the others its findings are said above
        contents = load_contents(path, settings)
    for number, mesh in enumerate(contents.meshes):
        if kind == "mesh":  # those of scenes and sources are checked with the scene
            check_mesh_numbers(mesh, f"meshes[{number}]", findings)
        check_topology(mesh, f"meshes[{number}]", findings)
    if budgets:
        check_budgets(contents, path, budgets, settings, findings)
    return findings


def _check_source(path: Path, settings: ImportSettings) -> tuple[Findings, Contents]:
    from importers.checks.scene import SceneParts, check_scene_numbers
    from importers.contents import Contents, take_model
    from importers.textures.image import decode

    importer = find_importer(path)
    model = importer.load(path, settings)
    used = sorted({use.image for material in model.materials for use in material.images.values()})
    for image in used:
        source = model.images[image]
        data = source.data()
        if data is None:
            continue
        try:
            decode(data, source.path, settings)
        except InputError as error:
            model.findings.error("texture.image", f"cannot be decoded: {error.message}", source.path, error.hint)
    if model.lone is not None:
        from importers.images.lone import unreadable

        for file, why in unreadable([path, *model.dependencies], settings):
            place = "" if file == path else file.name
            model.findings.error("texture.image", f"cannot be decoded: {why.message}", place, why.hint)
    scene = SceneAsset(
        model.name, model.nodes, environment=model.environment, look=model.look, active_camera=model.active_camera
    )
    meshes = [model.meshes[n.mesh.index] if n.mesh and n.mesh.index < len(model.meshes) else None for n in model.nodes]
    materials = {f"materials[{i}]": m.asset for i, m in enumerate(model.materials)}
    clips = {f"animations[{i}]": clip for i, clip in enumerate(model.clips)}
    check_scene_numbers(SceneParts(scene, meshes, materials, clips), model.findings)
    for place, material in () if model.lone is not None else materials.items():
        for slot in sorted(material.textures.keys() - model.materials[int(place[10:-1])].images.keys()):
            model.findings.warn(
                "material.missing-map", f"material {material.name!r} wants a {slot} and has none; it draws as magenta",
                place, "put the image where the source names it, or take it from the material",
            )  # fmt: skip
    _check_radiance(path, "", model.findings)
    contents = Contents("source", model.findings)
    take_model(model, importer, contents)
    return model.findings, contents


def _check_radiance(path: Path, place: str, findings: Findings) -> None:
    """Texels of an environment's file that are no light."""
    from importers.textures.hdr import bad_texels, probe

    if path.suffix.lower() not in (".hdr", ".exr") or not _is_file(path):
        return
    try:
        data = path.read_bytes()
        bad = bad_texels(data, str(path)) if probe(data) else 0
    except (InputError, OSError):
        return  # said by who reads it
    if bad:
        findings.warn(
            "number.texel", f"{bad:,} texels of {path.name!r} are not a number, infinite or negative", place,
            "save the picture again without them; until then they are black, or as bright as can be",
        )  # fmt: skip


def _check_scene(path: Path, findings: Findings) -> None:
    from engine.assets.scene_json import read_scene
    from engine.scene.light_profiles import check_profiles

    scene = read_scene(path, findings)
    wanted: dict[str, str] = {}
    for number, node in enumerate(scene.nodes):
        if node.mesh is not None:
            wanted.setdefault(node.mesh.file, f"nodes[{number}].mesh.file")
            for slot, material in enumerate(node.mesh.materials):
                wanted.setdefault(material, f"nodes[{number}].mesh.materials[{slot}]")
    for number, clip in enumerate(scene.clips):
        wanted.setdefault(clip, f"clips[{number}]")
    if scene.environment.kind == "image":
        wanted.setdefault(scene.environment.path, "environment.path")
        _check_radiance(path.parent / scene.environment.path, "environment.path", findings)
    _report_missing(path.parent, wanted, findings)
    check_profiles((node.light.profile for node in scene.nodes if node.light), path.parent, findings)
    _check_numbers(path.parent, scene, findings)


def _check_numbers(folder: Path, scene: SceneAsset, findings: Findings) -> None:
    """The numeric part, on everything the scene names that can be read."""
    from engine.assets.lanim import read_lanim
    from engine.assets.lmesh import read_lmesh
    from engine.assets.material_toml import read_material
    from importers.checks.scene import SceneParts, check_scene_numbers

    def read_all(names: list[str], reader: Callable[[Path], T]) -> dict[str, T]:
        found: dict[str, T] = {}
        for name in dict.fromkeys(names):
            if name and _is_file(folder / name):
                try:
                    found[name] = reader(folder / name)
                except InputError as error:
                    findings.error("reference.unreadable", error.message, str(error.where), error.hint)
        return found

    refs = [node.mesh for node in scene.nodes]
    files = read_all([ref.file for ref in refs if ref], read_lmesh)
    meshes = [
        files[ref.file][ref.index] if ref and 0 <= ref.index < len(files.get(ref.file, [])) else None for ref in refs
    ]
    materials = read_all([name for ref in refs if ref for name in ref.materials], read_material)
    clips = read_all(scene.clips, read_lanim)
    check_scene_numbers(SceneParts(scene, meshes, materials, clips), findings)


def _check_material(path: Path, findings: Findings) -> None:
    from engine.assets.material_toml import read_material
    from importers.checks.scene import check_material_numbers

    wanted: dict[str, str] = {}
    material = read_material(path)
    check_material_numbers(material, "", findings)
    for slot, texture in material.textures.items():
        if texture.path:
            wanted.setdefault(texture.path, f"textures.{slot}.path")
        else:
            findings.warn("material.texture", "wanted but missing; it draws as magenta", f"textures.{slot}")
    _report_missing(path.parent, wanted, findings)


def _is_file(path: Path) -> bool:
    """Also of names that no file can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _report_missing(folder: Path, wanted: dict[str, str], findings: Findings) -> None:
    for name, where in wanted.items():
        if name and not _is_file(folder / name):
            findings.error("reference.missing", f"the file {name!r} is not there", where, "convert the source again")
