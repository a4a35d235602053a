"""What an export to another format needs of a scene or a source, textures included, in one form for both.

    *.scene.json -> .lmesh, .lanim, .material.toml; textures: the .dds, decoded   \\
    any source   -> its importer's model; textures: the source's own image files   > ExportSource -> export_glb.py
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from engine.animation.pose import pose_meshes, pose_nodes
from engine.assets.clip import ClipAsset
from engine.assets.clip_nodes import spread
from engine.assets.lanim import read_lanim
from engine.assets.lmesh import read_lmesh
from engine.assets.material import MaterialAsset
from engine.assets.material_toml import read_material
from engine.assets.mesh import MeshAsset, Submesh
from engine.assets.prefab_clips import clips_of_instances
from engine.assets.scene import EnvironmentAsset, LookAsset, MeshRef, NodeAsset
from engine.assets.scene_json import read_scene
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.math.transform import decompose
from importers.geometry.quantize import snorm16_vectors
from importers.gltf.uris import read_regular_file
from importers.gltf.variants import EXTRAS as VARIANTS
from importers.settings import ImportSettings


@dataclass(frozen=True, slots=True)
class Picture:
    """An image to write: a PNG or JPEG file's bytes."""

    name: str
    data: bytes

    @property
    def mime(self) -> str:
        return "image/png" if self.data[:4] == b"\x89PNG" else "image/jpeg"


@dataclass(slots=True)
class ExportSource:
    """`materials_of[n]`: the material of each slot of the mesh on node n, -1 for the default one.

    `picture(material, slot)`: the image in a slot, `kept_picture(index)`: one that a kept extension names; None, with
    a finding, where it is not to be had."""

    name: str
    findings: Findings
    nodes: list[NodeAsset]
    meshes: list[MeshAsset]
    materials: list[MaterialAsset]
    materials_of: list[list[int]]
    clips: list[ClipAsset]
    picture: Callable[[int, str], Picture | None]
    kept_picture: Callable[[int], Picture | None] = lambda index: None
    environment: EnvironmentAsset = field(default_factory=EnvironmentAsset)
    look: LookAsset = field(default_factory=LookAsset)


def load_source(path: Path, settings: ImportSettings) -> ExportSource:
    """A *.scene.json or any source. Raises InputError, FormatError."""
    if path.name.lower().endswith(".scene.json"):
        return _from_scene(path, settings)
    from importers.registry import find_importer

    model = find_importer(path).load(path, settings)
    pictures: dict[int, Picture | None] = {}

    def image(index: int) -> Picture | None:
        if index not in pictures:
            source = model.images[index]
            data = source.data()
            pictures[index] = None
            if data is not None:
                try:
                    pictures[index] = Picture(source.name, as_picture(data, source.path, settings))
                except InputError as error:
                    model.findings.error("export.image", f"cannot be written: {error.message}", source.path, error.hint)
        return pictures[index]

    def picture(material: int, slot: str) -> Picture | None:
        use = model.materials[material].images.get(slot)
        if use is None and model.lone is not None:  # the source is the image
            data = read_regular_file(path, settings.max_file_bytes)
            return Picture(model.name, as_picture(data, path.name, settings))
        return None if use is None else image(use.image)

    def kept(index: int) -> Picture | None:
        return image(index) if 0 <= index < len(model.images) else None

    of = [[] if n.mesh is None else model.slots[n.mesh.index] for n in model.nodes]
    return ExportSource(
        model.name, model.findings, model.nodes, model.meshes, [m.asset for m in model.materials], of, model.clips,
        picture, kept, model.environment, model.look,
    )  # fmt: skip


def as_picture(data: bytes, place: str, settings: ImportSettings) -> bytes:
    """`data` itself where it is a PNG or JPEG file, else a PNG of its pixels. Raises InputError."""
    if data[:4] == b"\x89PNG" or data[:3] == b"\xff\xd8\xff":
        return data
    from importers.textures.image import decode
    from importers.textures.png import png_bytes

    return png_bytes(decode(data, place, settings))


def _from_scene(path: Path, settings: ImportSettings) -> ExportSource:
    findings = Findings(str(path))
    scene = read_scene(path, findings)
    folder = path.parent
    meshes: list[MeshAsset] = []
    first: dict[str, int] = {}
    files: dict[str, int] = {}
    materials: list[MaterialAsset] = []
    of: list[list[int]] = []
    for node in scene.nodes:
        slots: list[int] = []
        if node.mesh is not None:
            if node.mesh.file not in first:
                first[node.mesh.file] = len(meshes)
                meshes += read_lmesh(folder / node.mesh.file)
            node.mesh.index += first[node.mesh.file]
            for file in node.mesh.materials:
                if file and file not in files:
                    files[file] = len(materials)
                    materials.append(read_material(folder / file))
                slots.append(files[file] if file else -1)
        of.append(slots)
    for mesh in meshes:
        kept = mesh.extras.get(VARIANTS)
        if isinstance(kept, dict) and isinstance(kept.get("files"), list):
            for file in sorted({file for slot in kept["files"] for file in slot if file} - files.keys()):
                files[file] = len(materials)
                materials.append(read_material(folder / file))
            kept["slots"] = [[files.get(file, -1) for file in slot] for slot in kept.pop("files")]
    names = list(files)
    pictures: dict[Path, Picture | None] = {}

    def picture(material: int, slot: str) -> Picture | None:
        reference = materials[material].textures[slot]
        if not reference.path:
            return None
        file = (folder / names[material]).parent / reference.path
        if file not in pictures:
            from importers.textures.pixels import texture_picture

            try:
                pictures[file] = Picture(file.name.removesuffix(".dds"), texture_picture(file, slot == "normal_map"))
            except InputError as error:
                findings.error("export.image", f"{file.name} cannot be written: {error.message}", slot, error.hint)
                pictures[file] = None
        return pictures[file]

    clips = [spread(read_lanim(folder / clip), scene.nodes) for clip in scene.clips]
    try:
        clips += clips_of_instances(scene, folder, findings)
    except InputError as error:
        findings.error("prefab.unreadable", str(error), hint="its instances are written as they stand in the scene")
    return ExportSource(
        scene.name, findings, scene.nodes, meshes, materials, of, clips, picture,
        environment=scene.environment, look=scene.look,
    )  # fmt: skip


def posed(source: ExportSource, clip: ClipAsset | None, time: float, *, hidden: bool = False) -> ExportSource:
    """The scene at `time` seconds of `clip`, baked: skins and morphs applied, every mesh in world space, no clips."""
    pose = pose_nodes(source.nodes, clip, time)
    nodes: list[NodeAsset] = []
    meshes: list[MeshAsset] = []
    of: list[list[int]] = []
    for baked in pose_meshes(source.nodes, source.meshes, pose, hidden=hidden):
        node = source.nodes[baked.node]
        keep = {k: v for k, v in baked.mesh.streams.items() if k in ("uv0", "uv1", "color")}
        streams = {
            "position": baked.positions.astype("<f4"), "normal": snorm16_vectors(baked.normals), **keep
        }  # fmt: skip
        runs, submeshes, at = [], [], 0
        for part, triangles in zip(baked.mesh.submeshes, baked.triangles, strict=True):
            indices = triangles.reshape(-1)
            if part.topology != "triangles":
                indices = baked.mesh.indices[part.first_index : part.first_index + part.index_count]
            runs.append(np.asarray(indices, "<u4"))
            submeshes.append(Submesh(at, len(indices), part.material_slot, part.topology))
            at += len(indices)
        nodes.append(NodeAsset(node.name, mesh=MeshRef("", len(meshes), baked.mesh.name)))
        meshes.append(MeshAsset(baked.mesh.name, streams, np.concatenate(runs), submeshes))
        of.append(source.materials_of[baked.node])
    for row, node in enumerate(source.nodes):
        if node.camera is not None or node.light is not None:
            t, r, s = (v.tolist() for v in decompose(pose.world[row]))
            nodes.append(replace(node, parent=-1, translation=tuple(t), rotation=tuple(r), scale=tuple(s), matrix=None,
                                 mesh=None, joints=[], weights=[]))  # fmt: skip
            of.append([])
    return replace(source, nodes=nodes, meshes=meshes, materials_of=of, clips=[])
