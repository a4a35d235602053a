"""What is in a file, as one JSON object of the same form for every source and engine file.

    {"file", "kind", "meshes": [{"name", "vertices", "triangles", "joints", "bounds": [[x,y,z],[x,y,z]], …}],
     "clips": [{"name", "duration", "tracks", "keys"}], "materials": [{"name", "effect", …, "textures": {slot: name}}],
     "textures": [{"name", "format", "size", …}], "nodes": [{"name", "parent", "mesh"}],
     "lights": [{"name", "node", "type", …}], "cameras": [{"name", "node", "type", …}],
     "findings": [{"severity", "where", "message", "remedy"}]}

Lengths in metres, times in seconds, angles in radians, +Y up. A mesh's bounds are in world space, over all nodes that
show it, as the scene stands (skinned and morphed, no clip); a mesh without a node, as in an .lmesh alone, has its own
space. Nodes, lights and cameras are lists; `node` and `parent` are indices into `nodes`. What only one kind of file
has comes apart, as details. Effects have an object of their own (see effect_inspection).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.animation.pose import pose_meshes, pose_nodes
from engine.assets.material import MaterialAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import LightAsset, NodeAsset
from engine.core.findings import Finding, Findings
from importers.checks.files import engine_kind
from importers.contents import Contents, Texture, load_contents
from importers.settings import ImportSettings

Description = dict[str, Any]
Box = tuple[NDArray[np.float64], NDArray[np.float64]]


def describe(
    path: Path, settings: ImportSettings, *, scene: Path | None = None, features: tuple[str, ...] = (),
    pixels: bool = False,
) -> tuple[Description, Description, Findings]:  # fmt: skip
    """The object above, the details, and the findings; `scene`, `features`, `pixels` are for effects (see
    effect_inspection).

    Raises InputError or FormatError where it cannot be read."""
    if engine_kind(path) == "effect" and path.is_file():
        from importers.effect_inspection import describe_effect, effect_findings

        body = describe_effect(path, scene=scene, features=features, pixels=pixels)
        # the same keys as of all other files, though an effect has nothing of these
        lists = ("meshes", "clips", "materials", "textures", "nodes", "lights", "cameras", "findings")
        findings = effect_findings(path)
        alike: Description = {"file": str(path), "kind": "effect"} | {name: [] for name in lists}
        return alike | body | {"findings": [finding.to_json() for finding in findings]}, {}, findings
    contents = load_contents(path, settings)
    return describe_contents(path, contents), contents.details, contents.findings


def describe_contents(path: Path, contents: Contents) -> Description:
    """The object above, from what was read."""
    boxes = mesh_boxes(contents)
    return {
        "file": str(path), "kind": contents.kind,
        "meshes": [_mesh(mesh, boxes[i]) for i, mesh in enumerate(contents.meshes)],
        "clips": [
            {
                "name": clip.name, "duration": _rounded(clip.duration), "tracks": len(clip.channels),
                "keys": sum(len(channel.times) for channel in clip.channels),
            }
            for clip in contents.clips
        ],
        "materials": [_material(material) for material in contents.materials],
        "textures": [_texture(texture) for texture in contents.textures],
        "nodes": [_node(node, contents) for node in contents.nodes],
        "lights": [
            {
                "name": node.name, "node": i, "type": node.light.type, "intensity": node.light.intensity,
                "color": list(node.light.color), "range": node.light.range,
                **_of_its_kind(node.light),
            }
            for i, node in enumerate(contents.nodes) if node.light is not None
        ],
        "cameras": [
            {"name": node.name, "node": i, "type": node.camera.type}
            | ({"yfov": node.camera.yfov} if node.camera.type == "perspective" else {"ymag": node.camera.ymag})
            | {"znear": node.camera.znear, "zfar": node.camera.zfar}
            for i, node in enumerate(contents.nodes) if node.camera is not None
        ],
        "findings": [describe_finding(finding, path) for finding in contents.findings],
    }  # fmt: skip


def _of_its_kind(light: LightAsset) -> Description:
    """What only some lights have."""
    found: Description = {}
    if light.type == "spot":
        found |= {"inner_angle": light.inner_angle, "outer_angle": light.outer_angle}
    if light.type in ("rectangle", "disk"):
        found |= {"width": light.width, "height": light.height, "two_sided": light.two_sided}
    if light.temperature:
        found["temperature"] = light.temperature
    if light.profile:
        found["profile"] = light.profile
    if light.casts_shadow:
        found["casts_shadow"] = True
    if light.radius and light.type in ("point", "spot"):
        found["radius"] = light.radius
    return found


def describe_finding(finding: Finding, path: Path) -> Description:
    """As JSON. `where` is the place in the file at `path`, or names another file."""
    where = finding.where
    text = str(where)
    if where.file == str(path):
        text = text.removeprefix(where.file).lstrip(":").strip()
    return {"severity": finding.severity.value, "where": text, "message": finding.message, "remedy": finding.hint}


def mesh_boxes(contents: Contents) -> list[Box]:
    """(min f8[3], max f8[3]) of each mesh in world space, unanimated; of one without a node, in its own space; NaN
    where it has no vertices."""
    low = np.full((len(contents.meshes), 3), np.inf)
    high = np.full((len(contents.meshes), 3), -np.inf)
    with np.errstate(all="ignore"):
        # hidden ones, too: they are part of the file
        for posed in pose_meshes(contents.nodes, contents.meshes, pose_nodes(contents.nodes), hidden=True):
            reference = contents.nodes[posed.node].mesh
            if reference is not None and len(posed.positions):
                low[reference.index] = np.fmin(low[reference.index], np.nanmin(posed.positions, axis=0))
                high[reference.index] = np.fmax(high[reference.index], np.nanmax(posed.positions, axis=0))
        for i, mesh in enumerate(contents.meshes):
            if low[i, 0] > high[i, 0] and mesh.vertex_count:
                positions = np.asarray(mesh.streams["position"], np.float64)
                low[i], high[i] = np.nanmin(positions, axis=0), np.nanmax(positions, axis=0)
    return [(low[i], high[i]) for i in range(len(contents.meshes))]


def elements(mesh: MeshAsset, topology: str) -> int:
    """How many triangles, lines or points a mesh draws."""
    size = {"triangles": 3, "lines": 2, "points": 1}[topology]
    return sum(part.index_count for part in mesh.submeshes if part.topology == topology) // size


def joint_count(mesh: MeshAsset) -> int:
    return len(mesh.skeleton.names) if mesh.skeleton is not None else 0


def _mesh(mesh: MeshAsset, box: Box) -> Description:
    described: Description = {
        "name": mesh.name, "vertices": mesh.vertex_count, "triangles": elements(mesh, "triangles"),
        "joints": joint_count(mesh), "bounds": [[_rounded(v) for v in corner] for corner in box],
    }  # fmt: skip
    for topology in ("lines", "points"):
        if elements(mesh, topology):
            described[topology] = elements(mesh, topology)
    described |= {"submeshes": len(mesh.submeshes), "streams": list(mesh.layout)}
    if mesh.morphs:
        described["morphs"] = [morph.name for morph in mesh.morphs]
    return described


def _rounded(value: float) -> float | None:
    """JSON knows no NaN and no infinity."""
    number = float(f"{value:.9g}")
    return number if np.isfinite(number) else None


def _material(material: MaterialAsset) -> Description:
    described: Description = {"name": material.name, "effect": material.effect, "queue": material.queue}
    if material.parent:
        described["parent"] = material.parent
        described["from"] = {key: file.name for key, file in sorted(material.origin.items())}
    if material.level:
        described["level"] = material.level
    if material.features:
        described["features"] = material.features
    described["params"] = {k: list(v) if isinstance(v, tuple) else v for k, v in material.params.items()}
    described["textures"] = {slot: texture.path for slot, texture in sorted(material.textures.items())}
    if material.extensions:
        described["extensions"] = sorted(material.extensions)
    return described


def _texture(texture: Texture) -> Description:
    described: Description = {
        "name": texture.name, "format": texture.format, "size": [texture.width, texture.height],
        "bytes": texture.bytes, "used_as": texture.used_as,
    }  # fmt: skip
    if texture.mips:
        described |= {"mips": texture.mips, "layers": texture.layers}
    return described | ({"error": texture.error} if texture.error else {})


def _node(node: NodeAsset, contents: Contents) -> Description:
    described: Description = {"name": node.name, "parent": node.parent}
    if node.mesh is not None:
        index = node.mesh.index
        described["mesh"] = contents.meshes[index].name if 0 <= index < len(contents.meshes) else node.mesh.name
    if node.joints:
        described["skin"] = len(node.joints)
    if not node.visible:
        described["visible"] = False
    return described
