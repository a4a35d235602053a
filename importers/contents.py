"""Contents: whatever file it is, source or our own, as the same parts, for `inspect` and for budgets."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from engine.assets.clip import ClipAsset
from engine.assets.material import MaterialAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import NodeAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from importers.checks.files import engine_kind
from importers.model import ImportedModel
from importers.registry import Importer, find_importer
from importers.settings import ImportSettings

T = TypeVar("T")


@dataclass(slots=True)
class Texture:
    """`used_as`: slots or roles; `bytes`: of the file or of the image in the source; `error`: why it cannot be read."""

    name: str
    format: str = ""
    width: int = 0
    height: int = 0
    mips: int = 0
    layers: int = 1
    bytes: int = 0
    used_as: list[str] = field(default_factory=list)
    error: str = ""


@dataclass(slots=True)
class Contents:
    """`nodes` with the meshes' indices into `meshes`; `kind`: source, scene, mesh, clip, material or texture;
    `details`: what only this kind of file has."""

    kind: str
    findings: Findings
    meshes: list[MeshAsset] = field(default_factory=list)
    nodes: list[NodeAsset] = field(default_factory=list)
    clips: list[ClipAsset] = field(default_factory=list)
    materials: list[MaterialAsset] = field(default_factory=list)
    textures: list[Texture] = field(default_factory=list)
    details: dict[str, Any] = field(default_factory=dict)


def load_contents(path: Path, settings: ImportSettings) -> Contents:
    """Read `path`. Raises InputError or FormatError where it cannot be read; what it names and cannot be read is a
    finding."""
    if not os.path.isfile(path):  # noqa: PTH113  (false for names that no file can have, too)
        from importers.gltf.uris import similar_name_hint

        if os.path.exists(path):  # noqa: PTH110  (as above)
            raise InputError("is not a regular file", where=path, hint="name a file")
        raise InputError("there is no such file", where=path, hint=similar_name_hint(path))
    kind = engine_kind(path)
    contents = Contents(kind or "source", Findings(str(path)))
    if kind == "scene":
        _scene(path, contents)
    elif kind == "mesh":
        from engine.assets.lmesh import read_lmesh, read_provenance

        contents.meshes = read_lmesh(path)
        contents.details["provenance"] = read_provenance(path)
    elif kind == "clip":
        from engine.assets.lanim import read_lanim

        contents.clips = [read_lanim(path)]
        contents.details["channels"] = [
            {"target": c.target, "path": c.path, "interpolation": c.interpolation, "keys": len(c.times)}
            for c in contents.clips[0].channels
        ]
    elif kind == "material":
        from engine.assets.material_toml import read_material

        contents.materials = [read_material(path)]
        _textures_of(path.parent, contents)
    elif kind == "texture":
        contents.textures = [_dds(path, path.name)]
    else:
        _source(path, settings, contents)
    return contents


def _source(path: Path, settings: ImportSettings, contents: Contents) -> None:
    importer = find_importer(path)
    take_model(importer.load(path, settings), importer, contents)


def take_model(model: ImportedModel, importer: Importer, contents: Contents) -> None:
    """Fill `contents` with an imported model, whose textures get the names of their images."""
    contents.findings, contents.meshes, contents.nodes = model.findings, model.meshes, model.nodes
    contents.clips = model.clips
    names = [image.name or f"images[{i}]" for i, image in enumerate(model.images)]
    for material in model.materials:
        for slot, use in material.images.items():
            material.asset.textures[slot].path = names[use.image]
        contents.materials.append(material.asset)
    for index, image in enumerate(model.images):
        texture = Texture(names[index])
        uses = {use.role for m in model.materials for use in m.images.values() if use.image == index}
        texture.used_as = sorted(uses)
        _probe(texture, image.data(), image.path, contents.findings)
        contents.textures.append(texture)
    if model.lone is not None:  # the source is the texture itself
        size = model.summary.get("size")
        width, height = size if isinstance(size, list) else (0, 0)
        contents.textures.append(
            Texture(model.name, format=str(model.summary.get("format", "")), width=width, height=height)
        )
        for material in model.materials:
            material.asset.textures["base_color_map"].path = model.name
    contents.details = {
        "format": importer.name, **model.summary, "dependencies": [p.name for p in model.dependencies],
        "active_camera": model.active_camera,
    }  # fmt: skip


def _probe(texture: Texture, data: bytes | None, where: str, findings: Findings) -> None:
    from importers.textures.image import probe

    if data is None:
        texture.error = "not to be had"
        return
    texture.bytes = len(data)
    try:
        info = probe(data, where)
        texture.format, texture.width, texture.height = info.format, info.width, info.height
    except InputError as error:
        texture.error = error.message
        findings.error("texture.image", f"cannot be decoded: {error.message}", where, error.hint)


def _scene(path: Path, contents: Contents) -> None:
    from engine.assets.lanim import read_lanim
    from engine.assets.lmesh import read_lmesh
    from engine.assets.material_toml import read_material
    from engine.assets.scene_json import read_scene

    scene = read_scene(path, contents.findings)
    contents.nodes = scene.nodes
    folder, first = path.parent, {}
    for node in scene.nodes:
        if node.mesh is None:
            continue
        if node.mesh.file not in first:
            first[node.mesh.file] = len(contents.meshes)
            contents.meshes += _read(read_lmesh, folder, node.mesh.file, contents.findings) or []
        count = len(contents.meshes) - first[node.mesh.file]
        node.mesh.index = node.mesh.index + first[node.mesh.file] if node.mesh.index < count else -1
    named = [name for node in scene.nodes if node.mesh for name in node.mesh.materials if name]
    for name in dict.fromkeys(named):
        material = _read(read_material, folder, name, contents.findings)
        if material is not None:
            contents.materials.append(material)
    _textures_of(folder, contents)
    clips = (_read(read_lanim, folder, name, contents.findings) for name in scene.clips)
    contents.clips = [clip for clip in clips if clip is not None]
    contents.details = {
        "name": scene.name, "provenance": scene.provenance, "mesh_files": sorted(first),
        "material_files": sorted(set(named)), "clip_files": scene.clips, "active_camera": scene.active_camera,
        "environment": scene.environment.kind, "exposure_ev": scene.look.exposure, "tone_map": scene.look.tone_map,
    }  # fmt: skip


def _read(reader: Callable[[Path], T], folder: Path, name: str, findings: Findings) -> T | None:
    try:
        return reader(folder / name)
    except InputError as error:
        findings.error("reference.unreadable", error.message, str(error.where), error.hint)
        return None


def _textures_of(folder: Path, contents: Contents) -> None:
    """The files that the materials name, each once."""
    uses: dict[str, list[str]] = {}
    for material in contents.materials:
        for slot, reference in material.textures.items():
            if reference.path:
                uses.setdefault(reference.path, []).append(slot)
    for name, slots in uses.items():
        texture = Texture(name)
        try:
            texture = _dds(folder / name, name)
        except InputError as error:
            texture.error = error.message
            contents.findings.error("reference.unreadable", error.message, str(error.where), error.hint)
        texture.used_as = sorted(set(slots))
        contents.textures.append(texture)


def _dds(path: Path, name: str) -> Texture:
    from engine.assets.dds import read_dds

    asset = read_dds(path)
    return Texture(name, asset.format, asset.width, asset.height, asset.mip_count, asset.layers, asset.byte_size)
