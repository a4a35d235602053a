"""What is in a file: a description of any source or engine file as plain JSON values. Lengths in metres, times in s."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip import ClipAsset
from engine.assets.material import MaterialAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import NodeAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.math.transform import compose
from importers.checking import engine_kind
from importers.model import ImportedModel
from importers.registry import find_importer
from importers.settings import ImportSettings

Description = dict[str, Any]


def describe(
    path: Path, settings: ImportSettings, *, scene: Path | None = None, features: tuple[str, ...] = ()
) -> tuple[Description, Findings]:
    """Describe `path`; `scene`, `features` are for effects (see effect_inspection).

    Raises InputError or FormatError where it cannot be read."""
    if not path.is_file():
        from importers.gltf.uris import similar_name_hint

        raise InputError("there is no such file", where=path, hint=similar_name_hint(path))
    kind = engine_kind(path)
    findings = Findings(str(path))
    head: Description = {"file": str(path), "bytes": path.stat().st_size, "kind": kind or "source"}
    if kind == "scene":
        body = _scene(path, findings)
    elif kind == "mesh":
        from engine.assets.lmesh import read_lmesh, read_provenance

        body = {"provenance": read_provenance(path), "meshes": [_mesh(mesh) for mesh in read_lmesh(path)]}
    elif kind == "clip":
        from engine.assets.lanim import read_lanim

        body = _clip(read_lanim(path), channels=True)
    elif kind == "material":
        from engine.assets.material_toml import read_material

        body = _material(read_material(path))
    elif kind == "texture":
        body = _texture(path)
    elif kind == "effect":
        from importers.effect_inspection import describe_effect

        body = describe_effect(path, scene=scene, features=features)
    else:
        importer = find_importer(path)
        model = importer.load(path, settings)
        body, findings = _model(model), model.findings
    return head | body, findings


def _model(model: ImportedModel) -> Description:
    low, high = world_bounds(model.nodes, model.meshes)
    return model.summary | {
        "bounds_m": _bounds(low, high),
        "totals": {
            "vertices": sum(mesh.vertex_count for mesh in model.meshes),
            "triangles": sum(_elements(mesh, "triangles") for mesh in model.meshes),
        },
        "meshes": [_mesh(mesh) for mesh in model.meshes],
        "materials": [
            _material(material.asset)
            | {"textures": {slot: f"images[{use.image}]" for slot, use in sorted(material.images.items())}}
            for material in model.materials
        ],
        "images": [_image(model, index) for index in range(len(model.images))],
        "clips": [_clip(clip) for clip in model.clips],
        **_hung(model.nodes),
        "dependencies": [p.name for p in model.dependencies],
    }


def world_bounds(nodes: Sequence[NodeAsset], meshes: Sequence[MeshAsset]) -> tuple[NDArray[Any], NDArray[Any]]:
    """(min f8[3], max f8[3]) of all meshes where their nodes put them, unanimated; +inf and -inf without any."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    world: list[NDArray[np.float64]] = []
    with np.errstate(over="ignore", invalid="ignore"):
        for node in nodes:
            local = compose(node.translation, node.rotation, node.scale)
            if node.matrix is not None:
                local = np.array(node.matrix, np.float64).reshape(4, 4).T
            world.append(local if node.parent < 0 else world[node.parent] @ local)
            if node.mesh is None:
                continue
            for part in meshes[node.mesh.index].submeshes:
                x, y, z = zip(part.bounds_min, part.bounds_max, strict=True)
                corners = np.array(np.meshgrid(x, y, z)).reshape(3, 8)
                placed = world[-1][:3, :3] @ corners + world[-1][:3, 3:]
                low, high = np.minimum(low, placed.min(axis=1)), np.maximum(high, placed.max(axis=1))
    return low, high


def _bounds(low: NDArray[Any], high: NDArray[Any]) -> Description | None:
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        return None
    return {"min": _rounded(low), "max": _rounded(high), "size": _rounded(high - low)}


def _rounded(values: Any) -> list[float]:
    return [float(f"{v:.6g}") for v in values]


def _elements(mesh: MeshAsset, topology: str) -> int:
    size = {"triangles": 3, "lines": 2, "points": 1}[topology]
    return sum(part.index_count for part in mesh.submeshes if part.topology == topology) // size


def _mesh(mesh: MeshAsset) -> Description:
    described: Description = {"name": mesh.name, "vertices": mesh.vertex_count}
    for topology in ("triangles", "lines", "points"):
        if _elements(mesh, topology):
            described[topology] = _elements(mesh, topology)
    described |= {"submeshes": len(mesh.submeshes), "streams": list(mesh.layout)}
    if mesh.skeleton is not None:
        described["joints"] = len(mesh.skeleton.names)
    if mesh.morphs:
        described["morphs"] = [morph.name for morph in mesh.morphs]
    if mesh.submeshes:
        low = np.min([part.bounds_min for part in mesh.submeshes], axis=0)
        high = np.max([part.bounds_max for part in mesh.submeshes], axis=0)
        described["bounds_m"] = _bounds(low, high)
    return described


def _material(material: MaterialAsset) -> Description:
    described: Description = {"name": material.name, "effect": material.effect, "queue": material.queue}
    if material.features:
        described["features"] = material.features
    described["params"] = {k: list(v) if isinstance(v, tuple) else v for k, v in material.params.items()}
    described["textures"] = {slot: texture.path for slot, texture in material.textures.items()}
    if material.extensions:
        described["extensions"] = sorted(material.extensions)
    return described


def _image(model: ImportedModel, index: int) -> Description:
    from importers.textures.image import probe

    image = model.images[index]
    roles = {use.role for material in model.materials for use in material.images.values() if use.image == index}
    described: Description = {"name": image.name, "roles": sorted(roles)}
    data = image.data()
    if data is None:
        return described | {"error": "not to be had"}
    described["bytes"] = len(data)
    try:
        info = probe(data, image.path)
        described |= {"format": info.format, "size": [info.width, info.height]}
    except InputError as error:
        described["error"] = error.message
        model.findings.error("texture.image", f"cannot be decoded: {error.message}", image.path, error.hint)
    return described


def _clip(clip: ClipAsset, channels: bool = False) -> Description:
    described: Description = {
        "name": clip.name,
        "duration_s": float(f"{clip.duration:.6g}"),
        "channels": len(clip.channels),
        "keys": sum(len(channel.times) for channel in clip.channels),
    }
    if channels:
        described["channels"] = [
            {"target": c.target, "path": c.path, "interpolation": c.interpolation, "keys": len(c.times)}
            for c in clip.channels
        ]
    return described


def _hung(nodes: Sequence[NodeAsset]) -> Description:
    cameras, lights = [], []
    for node in nodes:
        if node.camera is not None:
            lens = {"yfov_rad": node.camera.yfov} if node.camera.type == "perspective" else {"ymag_m": node.camera.ymag}
            cameras.append({"node": node.name, "type": node.camera.type} | lens)
        if node.light is not None:
            lights.append({"node": node.name, "type": node.light.type, "intensity": node.light.intensity})
    skinned = sum(bool(node.joints) for node in nodes)
    return {"cameras": cameras, "lights": lights, "nodes": len(nodes), "skinned_nodes": skinned}


def _scene(path: Path, findings: Findings) -> Description:
    from engine.assets.scene_json import read_scene

    scene = read_scene(path, findings)
    files = sorted({node.mesh.file for node in scene.nodes if node.mesh is not None})
    materials = sorted({m for node in scene.nodes if node.mesh is not None for m in node.mesh.materials if m})
    return {
        "name": scene.name, "provenance": scene.provenance, "mesh_files": files, "material_files": materials,
        "clips": scene.clips, **_hung(scene.nodes), "active_camera": scene.active_camera,
        "environment": scene.environment.kind, "exposure_ev": scene.look.exposure, "tone_map": scene.look.tone_map,
    }  # fmt: skip


def _texture(path: Path) -> Description:
    from engine.assets.dds import read_dds

    texture = read_dds(path)
    return {
        "format": texture.format, "size": [texture.width, texture.height, texture.depth], "layers": texture.layers,
        "mips": texture.mip_count, "cube": texture.cube, "data_bytes": texture.byte_size,
        "extras": sorted(texture.extras),
    }  # fmt: skip
