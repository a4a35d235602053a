"""FBX file -> ImportedModel: a worker reads it, the host puts our assets together; all findings collected."""

from __future__ import annotations

import contextlib
import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.animation.pose import BIND_WORLD
from engine.assets.material import MaterialAsset
from engine.assets.scene import MeshRef, NodeAsset
from engine.core.atomic import write_text
from engine.core.errors import FormatError, InputError, LucarnaError, Place
from engine.core.findings import Findings
from engine.core.paths import user_cache_dir
from importers.fbx import morphs
from importers.fbx.clips import read_clips
from importers.fbx.document import FbxDocument, Json
from importers.fbx.geometry_cache import PointCache, data_files, read_cache, thinned
from importers.fbx.images import Images
from importers.fbx.materials import read_material
from importers.fbx.meshes import build_mesh
from importers.fbx.nodes import active_camera, read_nodes
from importers.fbx.skins import OWN_NODE, Skin, read_skin
from importers.fbx.texture_files import TextureFinder
from importers.gltf.materials import normal_map_uv
from importers.gltf.uris import similar_name_hint
from importers.model import ImportedMaterial, ImportedModel
from importers.settings import ImportSettings
from importers.workers.process import WorkerLimits
from importers.workers.runner import WorkerResult, run_in_worker

_NO_CACHE = PointCache(np.zeros(0), np.zeros((0, 0, 3)))
#: the digest and result of the file read last, while nothing has used it
_recent: list[tuple[str, WorkerResult]] = []
_TASK = "importers.fbx.extract:extract"


def load(path: Path, settings: ImportSettings) -> ImportedModel:
    """Read an .fbx whole. Raises InputError or FormatError where nothing can be had from it; everything less is a
    finding of the model, and the rest is imported."""
    findings = Findings(str(path))
    result = _read(path, settings, content_digest(path, settings))
    try:
        doc = FbxDocument(result, findings)
        return ModelBuilder(doc, path, settings).build()
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise FormatError(
            f"the scene that was read makes no sense ({type(error).__name__}: {error})", where=path,
            hint="export it again; please report this file",
        ) from error  # fmt: skip
    except LucarnaError as error:
        if not error.where.file:
            error.where = Place(str(path), path=error.where.path)
        raise


def dependencies(path: Path, settings: ImportSettings) -> list[tuple[str, Path]]:
    """(name in the file, file) of every texture that the source names; for one that is not found, where it could be.

    The names are remembered by the file's content, so asking again starts no worker.
    """
    finder = TextureFinder(path, settings.allow_outside)
    found = []
    for names in _texture_names(path, settings):
        search = finder.find(names)
        name = next((n for n in names if n), "")
        found.append((name, search.path or path.parent / Path(name.replace("\\", "/")).name))
        if search.path is not None and search.path.suffix.lower() == ".xml":
            with contextlib.suppress(InputError, OSError):
                found += [(file.name, file) for file in data_files(search.path)]
    return found


def content_digest(path: Path, settings: ImportSettings) -> str:
    """The content's digest. Raises InputError where there is no regular file of an allowed size."""
    if not path.is_file():
        if path.exists():
            raise InputError("is not a regular file", where=path, hint="pipes, devices and folders are not read")
        raise InputError("there is no such file", where=path, hint=similar_name_hint(path))
    size = path.stat().st_size
    if size > settings.max_file_bytes:
        raise InputError(f"has {size:,} bytes; the limit is {settings.max_file_bytes:,}", where=path)
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16)).hexdigest()
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror or error}", where=path) from error


def _texture_names(path: Path, settings: ImportSettings) -> list[list[str]]:
    digest = content_digest(path, settings)
    memo = _memo(digest)
    try:
        known: list[list[str]] = json.loads(memo.read_text(encoding="utf-8"))
        if all(isinstance(name, str) for names in known for name in names):
            return known
    except (OSError, ValueError, TypeError):
        pass
    # whoever asks for the dependencies mostly loads the file next
    result = _read(path, settings, digest)
    _recent[:] = [(digest, result)]
    return _names(result)


def _read(path: Path, settings: ImportSettings, digest: str) -> WorkerResult:
    """What the worker makes of the file, or made of it just before; the textures' names are written down."""
    kept = [result for known, result in _recent if known == digest]
    _recent.clear()
    if kept:
        return kept[0]
    limits = WorkerLimits(settings.max_worker_seconds, settings.max_worker_bytes)
    result = run_in_worker(_TASK, {"path": str(path.resolve())}, path, limits, "the FBX reader")
    with contextlib.suppress(LucarnaError):  # the memo saves time only
        write_text(_memo(digest), json.dumps(_names(result)))
    return result


def _names(result: WorkerResult) -> list[list[str]]:
    textures = [texture["files"] for texture in result.data["textures"] if texture["type"] == "file"]
    return [[str(name) for name in files] for files in (*textures, *result.data["cache_files"])]


def _memo(digest: str) -> Path:
    return user_cache_dir() / "fbx_names" / f"{digest}.json"


class ModelBuilder:
    """Nodes, skins, meshes and clips, which all need one another's numbers."""

    def __init__(self, doc: FbxDocument, path: Path, settings: ImportSettings) -> None:
        self._doc = doc
        self._images = Images(doc, path, settings)
        self._model = ImportedModel(path.stem, doc.findings)
        self._settings = settings
        self._default = -1
        self._built: dict[tuple[object, ...], tuple[int, Skin | None, NDArray[np.float64]]] = {}

    def build(self) -> ImportedModel:
        doc, model = self._doc, self._model
        self._note_warnings()
        model.materials = [
            read_material(doc, self._images, index, uv_sets) for index, uv_sets in enumerate(self._uv_sets())
        ]
        model.images = self._images.images
        model.dependencies = self._images.files
        model.nodes, rows = read_nodes(doc)
        model.active_camera = active_camera(doc, rows)
        shapes: dict[int, morphs.Shapes] = {}
        for index, node in enumerate(doc.nodes):
            if index in rows and node["mesh"] >= 0:
                found = self._attach(index, model.nodes[rows[index]], rows)
                if found.channels or len(found.cache_times):
                    shapes[rows[index]] = found
        model.clips = read_clips(doc, model.nodes, rows, shapes)
        self._carry_skins(rows)
        if not model.meshes:
            doc.findings.warn("fbx.no-meshes", "the file has no mesh that can be drawn", hint="the scene is empty")
        model.summary |= self._summary()
        return model

    def _attach(self, index: int, asset: NodeAsset, rows: dict[int, int]) -> morphs.Shapes:
        """Hang the node's mesh on it; returns what shapes the mesh."""
        doc, node = self._doc, self._doc.nodes[index]
        mesh = doc.meshes[node["mesh"]]
        mesh["name"] = mesh["name"] or asset.name
        own, shared = [int(m) for m in node["materials"]], [int(m) for m in mesh["materials"]]
        materials = own if len(own) >= len(shared) else shared
        key = (node["mesh"], *materials)
        if key not in self._built:
            where = f"meshes[{mesh['name'] or node['mesh']}]"
            skin = read_skin(doc, mesh, index, where) if mesh["skins"] else None
            normal_uv = [normal_map_uv(m) for m in self._model.materials]
            cache = self._cache(mesh, where) if mesh["caches"] else _NO_CACHE
            built = build_mesh(doc, int(node["mesh"]), materials, skin, normal_uv, cache.points)
            number = -1
            if built is not None:
                number = len(self._model.meshes)
                self._model.meshes.append(built[0])
                self._model.slots.append([m if m >= 0 else self._default_material() for m in built[1]])
            self._built[key] = (number, skin, cache.times)
        number, skin, cache_times = self._built[key]
        if number < 0:
            return morphs.Shapes([], _NO_CACHE.times)
        asset.mesh = MeshRef("", number, self._model.meshes[number].name)
        if skin is not None:
            joints = [index if joint == OWN_NODE else joint for joint in skin.joints]
            asset.joints = [rows[joint] for joint in joints]
        channels = morphs.read_channels(mesh)
        asset.weights = morphs.rest_weights(channels) + [0.0] * len(cache_times)
        return morphs.Shapes(channels, cache_times)

    def _default_material(self) -> int:
        """A plain grey for faces without a material; the engine's own default is a metal."""
        materials = self._model.materials
        if self._default < 0:
            params = {"base_color": (0.8, 0.8, 0.8, 1.0), "metallic": 0.0, "roughness": 0.5}
            materials.append(ImportedMaterial(MaterialAsset("default", params=params)))
            self._default = len(materials) - 1
        return self._default

    def _cache(self, mesh: Json, where: str) -> PointCache:
        """The mesh's point cache in metres; an empty one (with a finding) where it is not to be had."""
        doc = self._doc
        points = len(doc.array(mesh["positions"]))
        for entry in mesh["caches"]:
            names = [str(name) for name in entry["files"]]
            search = self._images.find(names)
            if search.path is None:
                doc.findings.error(
                    "fbx.cache", f"the point cache {next((n for n in names if n), '')!r} is not found", where,
                    "put the file beside the source; without it the mesh keeps its first shape",
                )  # fmt: skip
                continue
            try:
                cache = read_cache(
                    search.path, str(entry["channel"]), points, float(doc.data["frame_rate"]),
                    self._settings.max_decoded_bytes // 4,
                )  # fmt: skip
            except (InputError, OSError) as error:
                # a cache of normals beside the one of positions is no fault
                if len(mesh["caches"]) == 1:
                    doc.findings.error("fbx.cache", f"the point cache cannot be read: {error}", where)
                continue
            kept = thinned(cache)
            if len(kept.times) < len(cache.times):
                doc.findings.warn(
                    "fbx.cache", f"of {len(cache.times):,} cached frames {len(kept.times)} are kept", where
                )
            self._images.files.append(search.path)
            return PointCache(kept.times, kept.points * float(doc.data["unit_meters"]))
        return _NO_CACHE

    def _carry_skins(self, rows: dict[int, int]) -> None:
        """Maya moves a skinned mesh with its node as well. Elsewhere, and where parents move it, joints decide."""
        if self._doc.data["application"] != "Maya":
            return
        keyed = {
            channel.node
            for clip in self._model.clips
            for channel in clip.channels
            if channel.path != "weights" and (channel.values != channel.values[0]).any()
        }
        for index, row in rows.items():
            asset = self._model.nodes[row]
            if row in keyed and asset.joints:
                skin = self._doc.meshes[self._doc.nodes[index]["mesh"]]["skins"][0]
                bind = np.eye(4)
                bind[:3] = skin["world_from_geometry"]
                asset.extras[BIND_WORLD] = bind.T.reshape(-1).tolist()
                self._doc.findings.info(
                    "fbx.skin", "the mesh's own node is animated; it carries the skinned mesh along, as in Maya",
                    f"nodes[{asset.name}]",
                )  # fmt: skip

    def _uv_sets(self) -> list[list[str]]:
        """Per material, the names of the uv sets of the first mesh that uses it."""
        doc = self._doc
        found: list[list[str]] = [[] for _ in doc.materials]
        for node in doc.nodes:
            if node["mesh"] < 0:
                continue
            mesh = doc.meshes[node["mesh"]]
            names = [str(uv["name"]) for uv in mesh["uv_sets"]]
            for material in [*node["materials"], *mesh["materials"]]:
                if 0 <= material < len(found) and not found[material]:
                    found[material] = names
        return found

    def _note_warnings(self) -> None:
        doc = self._doc
        for text, count in doc.data["warnings"]:
            times = f" ({count} times)" if count > 1 else ""
            doc.findings.warn("fbx.reader", f"{text}{times}")
        for what, count in doc.data["left_out"]:
            doc.findings.info("fbx.left-out", f"{count} {what}: not imported")

    def _summary(self) -> dict[str, Any]:
        """For FBX; other readers of the same document put theirs in its place."""
        doc, data = self._doc, self._doc.data
        version = int(data["version"])
        kind = "ASCII" if data["ascii"] else "binary, big-endian" if data["big_endian"] else "binary"
        names = ("nodes", "meshes", "materials", "textures", "stacks", "lights", "cameras")
        return {
            "format": f"FBX {kind}",
            "version": f"{version // 1000}.{version % 1000 // 100}",
            "generator": str(data["creator"]),
            "application": str(data["application"]),
            "unit_meters": data["unit_meters"],
            "up_axis": data["up_axis"],
            "frame_rate": data["frame_rate"],
            "counts": {name: len(data[name]) for name in names} | {"nodes": max(len(doc.nodes) - 1, 0)},
        }
