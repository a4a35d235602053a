"""glTF file -> ImportedModel: everything in order, all findings collected."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np

from engine.assets.material import MaterialAsset
from engine.assets.scene import MeshRef, NodeAsset
from engine.core.errors import FormatError, InputError, Place
from engine.core.findings import Findings
from importers.gltf.accessors import COMPRESSED_VIEWS, Accessors
from importers.gltf.animations import read_animation
from importers.gltf.container import Buffers, Container, read_container
from importers.gltf.document import Document
from importers.gltf.hierarchy import Hierarchy, choose_scene, read_hierarchy, scene_roots
from importers.gltf.instances import read_instances
from importers.gltf.light_profiles import PROFILES, profile_entries, read_profiles
from importers.gltf.materials import Images, normal_map_uv, read_material
from importers.gltf.meshes import MeshReader, Slot
from importers.gltf.nodes import PendingMatrix, apply_matrices, node_name, read_node
from importers.gltf.skins import Skin, read_skin
from importers.gltf.surroundings import read_surroundings
from importers.gltf.uris import resolve_uri, storable_text
from importers.gltf.variants import Variants
from importers.model import ImportedMaterial, ImportedModel, SourceImage
from importers.settings import ImportSettings

#: extensions that may stand in `extensionsRequired`; KHR_materials_* come in as well, kept if not shown
_KNOWN = {
    "KHR_texture_transform", "KHR_lights_punctual", PROFILES, "KHR_mesh_quantization", "KHR_draco_mesh_compression",
    "KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif", "MSFT_texture_dds", "EXT_mesh_gpu_instancing",
    "KHR_node_visibility", "KHR_materials_unlit", "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness", "KHR_materials_clearcoat", "KHR_materials_sheen",
    "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_ior", "KHR_materials_specular",
    "KHR_materials_iridescence", "KHR_materials_anisotropy", "KHR_materials_dispersion",
    "KHR_materials_diffuse_transmission", "KHR_materials_variants", *COMPRESSED_VIEWS,
}  # fmt: skip


def load(path: Path, settings: ImportSettings) -> ImportedModel:
    """Read a .gltf or .glb whole. Raises InputError or FormatError where nothing can be had from it; everything less
    is a finding of the model, and the rest is imported."""
    findings = Findings(str(path))
    # values that are no numbers are looked for wherever they matter; numpy need not warn of them as well
    with np.errstate(all="ignore"):
        return _load(path, settings, findings)


def _load(path: Path, settings: ImportSettings, findings: Findings) -> ImportedModel:
    container = read_container(path, settings, findings)
    doc = Document(container.root, findings)
    _check_extensions(doc, path)
    buffers = Buffers(container, doc.objects("buffers"), findings)
    accessors = Accessors(doc, buffers, settings.max_decoded_bytes)
    model = ImportedModel(storable_text(path.stem), findings)
    images = Images([_image(doc, container, accessors, i) for i in range(len(doc.objects("images")))], settings)
    model.materials = [read_material(doc, i, images) for i in range(len(doc.objects("materials")))]
    model.images = images
    choose_scene(doc, settings.scene)
    _Builder(doc, accessors, model, Variants(doc, settings.variant)).build()
    read_profiles(doc, container, accessors, model)
    model.dependencies = container.dependencies
    model.summary |= _summary(doc, container)
    return model


def dependencies(path: Path, settings: ImportSettings) -> list[tuple[str, Path]]:
    """(uri, file) of every file that the source names, without reading them; refused URIs are left out."""
    container = read_container(path, settings, Findings(str(path)))
    doc = Document(container.root, Findings())
    found = []
    for entries in (doc.objects("buffers"), doc.objects("images"), profile_entries(doc)):
        for entry in entries:
            uri = entry.get("uri")
            if isinstance(uri, str) and not uri.startswith("data:"):
                try:
                    found.append((storable_text(uri), resolve_uri(uri, container.folder, settings.allow_outside)))
                except InputError:
                    continue
    return found


def _check_extensions(doc: Document, path: Path) -> None:
    required = [n for n in doc.array(doc.root, "extensionsRequired", "") if isinstance(n, str)]
    unknown = sorted({n for n in required if n not in _KNOWN})
    if unknown:
        raise FormatError(
            f"requires {', '.join(unknown)[:300]}, which {'is' if len(unknown) == 1 else 'are'} not supported",
            where=Place(str(path), path="extensionsRequired"), hint="export it without them",
        )  # fmt: skip


def _image(doc: Document, container: Container, accessors: Accessors, index: int) -> SourceImage:
    image, where = doc.objects("images")[index], f"images[{index}]"
    uri = doc.text(image, "uri", where)
    name = doc.name(image, where, "")
    if not name and uri and not uri.startswith("data:"):
        name = Path(uri.replace("\\", "/")).stem

    def fetch() -> bytes | None:
        if "uri" in image:
            if not uri:
                doc.findings.error("gltf.image", "the image has no usable uri", where)
                return None
            try:
                return container.read_uri(uri)
            except InputError as error:
                place = str(error.where)
                doc.findings.error(
                    "gltf.image", f"{place}: {error.message}" if place else error.message, f"{where}.uri",
                    error.hint or "the texture draws as magenta",
                )  # fmt: skip
                return None
        view = doc.integer(image, "bufferView", where)
        data = None if view is None else accessors.view_bytes(view, f"{where}.bufferView")
        if data is None:
            doc.findings.error("gltf.image", "the image's bytes are not to be had; it draws as magenta", where)
            return None
        return bytes(data)

    file = "" if not uri or uri.startswith("data:") else Path(uri.replace("\\", "/")).name
    return SourceImage(name, fetch, where, file)


class _Builder:
    """Nodes, skins, meshes and clips, which all need one another's numbers."""

    def __init__(self, doc: Document, accessors: Accessors, model: ImportedModel, variants: Variants) -> None:
        self._doc = doc
        self._accessors = accessors
        self._model = model
        self._names = [node_name(doc, i) for i in range(len(doc.objects("nodes")))]
        self._reader = MeshReader(doc, accessors, [normal_map_uv(m) for m in model.materials], variants)
        self._skins: dict[int, Skin | None] = {}
        self._meshes: dict[tuple[int, int], int] = {}
        self._unlit: dict[int, int] = {}

    def build(self) -> None:
        doc, model = self._doc, self._model
        hierarchy = read_hierarchy(doc)
        roots = self._with_joints(hierarchy, scene_roots(doc, hierarchy))
        order = hierarchy.subtree(roots)
        if all(hierarchy.parents[node] < node for node in order):
            order.sort()  # the file's own order has parents first already: what we exported comes back row by row
        rows = {node: row for row, node in enumerate(order)}
        morphs: dict[int, int] = {}
        inside = set(roots)
        matrices: list[PendingMatrix] = []
        for node in order:
            asset = read_node(doc, node, matrices)
            asset.parent = -1 if node in inside else rows[hierarchy.parents[node]]
            self._attach_mesh(node, asset, hierarchy, rows)
            if asset.mesh is not None:
                morphs[node] = len(model.meshes[asset.mesh.index].morphs)
            if asset.camera is not None and model.active_camera < 0:
                model.active_camera = rows[node]
            model.nodes.append(asset)
        apply_matrices(doc, matrices)
        for row, node in enumerate(order):
            model.nodes += read_instances(doc, self._accessors, node, model.nodes[row], row)
        model.environment, model.look = read_surroundings(doc)
        used = {mesh for mesh, _ in self._meshes}
        for mesh in range(len(doc.objects("meshes"))):
            if mesh not in used:
                self._mesh(mesh, -1, hierarchy)
        self._reader.report_zero_area()
        if not model.meshes:
            doc.findings.error("gltf.no-meshes", "the file has no mesh that can be drawn", hint="the scene is empty")
        for number in range(len(doc.objects("animations"))):
            clip = read_animation(doc, self._accessors, number, rows, self._names, morphs)
            if clip.channels:
                model.clips.append(clip)

    def _with_joints(self, hierarchy: Hierarchy, roots: list[int]) -> list[int]:
        """The scene's roots, and those above joints that the scene forgot."""
        doc, inside = self._doc, set(hierarchy.subtree(roots))
        for node in list(inside):
            skin = doc.objects("nodes")[node].get("skin")
            if not isinstance(skin, int) or not 0 <= skin < len(doc.objects("skins")):
                continue
            for joint in doc.indices(doc.objects("skins")[skin], "joints", f"skins[{skin}]", "nodes"):
                if joint not in inside:
                    root = hierarchy.root_of(joint)
                    doc.findings.warn(
                        "gltf.skin", f"joints outside the scene; nodes[{root}] is taken in", f"skins[{skin}].joints"
                    )
                    roots.append(root)
                    inside |= set(hierarchy.subtree([root]))
        # a root of the scene that lies below a root taken in for its joints comes with it
        return [n for n in roots if hierarchy.root_of(n) == n or hierarchy.root_of(n) not in roots]

    def _attach_mesh(self, node: int, asset: NodeAsset, hierarchy: Hierarchy, rows: dict[int, int]) -> None:
        doc, where = self._doc, f"nodes[{node}]"
        source = doc.objects("nodes")[node]
        mesh = doc.index(source, "mesh", where, "meshes")
        skin_index = doc.index(source, "skin", where, "skins")
        if mesh is None:
            return
        number = self._mesh(mesh, -1 if skin_index is None else skin_index, hierarchy)
        if number < 0:
            return
        built = self._model.meshes[number]
        asset.mesh = MeshRef("", number, built.name)
        if skin_index is not None:
            skin = self._skins[skin_index]
            if skin is not None and built.skeleton is not None:
                asset.joints = [rows[j] for j in skin.joints]
            elif skin is not None:
                doc.findings.warn("gltf.skin", "the skin's mesh has no joints and weights; it stays rigid", where)
        weights = source.get("weights", doc.objects("meshes")[mesh].get("weights"))
        if built.morphs:
            given = doc.vector({"weights": weights}, "weights", where, [0.0] * len(built.morphs))
            asset.weights = list(given)

    def _mesh(self, mesh: int, skin_index: int, hierarchy: Hierarchy) -> int:
        """The number in the model of a mesh bound to a skin (-1: none); -1 where nothing of it can be drawn."""
        key = mesh, skin_index
        if key not in self._meshes:
            skin = None
            if skin_index >= 0:
                if skin_index not in self._skins:
                    self._skins[skin_index] = read_skin(
                        self._doc, self._accessors, skin_index, hierarchy.parents, hierarchy.sequence, self._names
                    )
                skin = self._skins[skin_index]
            built = self._reader.build(mesh, skin)
            if built is None:
                self._meshes[key] = -1
            else:
                self._meshes[key] = len(self._model.meshes)
                self._model.meshes.append(built[0])
                self._model.slots.append([self._material(slot) for slot in built[1]])
        return self._meshes[key]

    def _material(self, slot: Slot) -> int:
        """The material of a slot; lines and points without normals get an unlit twin of theirs."""
        if not slot.unlit:
            return slot.material
        if slot.material not in self._unlit:
            materials = self._model.materials
            if slot.material >= 0:
                twin = copy.deepcopy(materials[slot.material])
            else:
                twin = ImportedMaterial(MaterialAsset("default"))
            if "unlit" in twin.asset.features:
                self._unlit[slot.material] = slot.material
            else:
                twin.asset.name += " unlit"
                twin.asset.features.append("unlit")
                self._unlit[slot.material] = len(materials)
                materials.append(twin)
        return self._unlit[slot.material]


def _summary(doc: Document, container: Container) -> dict[str, Any]:
    asset = doc.child(doc.root, "asset", "")
    names = ("scenes", "nodes", "meshes", "materials", "textures", "images", "samplers", "skins", "animations",
             "cameras", "accessors", "bufferViews", "buffers")  # fmt: skip
    return {
        "format": "GLB" if container.binary is not None else "glTF",
        "version": str(asset.get("version", "")),
        "generator": str(asset.get("generator", "")),
        "counts": {name: len(doc.objects(name)) for name in names},
        "extensions_used": [str(n) for n in doc.array(doc.root, "extensionsUsed", "")],
        "extensions_required": [str(n) for n in doc.array(doc.root, "extensionsRequired", "")],
    }
