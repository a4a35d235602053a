"""Ogre file -> ImportedModel: mesh, skeletons, materials and clips in order, all findings collected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from engine.assets.clip import ClipAsset
from engine.assets.material import MaterialAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import MeshRef, NodeAsset
from engine.core.errors import FormatError, InputError
from engine.core.findings import Findings
from importers.gltf.uris import similar_name_hint
from importers.model import ImportedMaterial, ImportedModel
from importers.ogre.animations import make_clip
from importers.ogre.build import MeshBuilder, Wanted
from importers.ogre.data import OgreMesh, OgreSkeleton
from importers.ogre.folders import look_around
from importers.ogre.morphs import Morphs
from importers.ogre.resolver import Materials
from importers.ogre.skeletons import Rig, make_rig
from importers.ogre.sources import read_source
from importers.settings import ImportSettings

_MAX_LINKS = 64


@dataclass(slots=True)
class _Found:
    """A source with all that it names, before anything is built."""

    mesh: OgreMesh | None
    rig_source: OgreSkeleton | None
    rig_file: Path | None
    linked: list[tuple[OgreSkeleton, Path, float]] = field(default_factory=list)


def load(path: Path, settings: ImportSettings) -> ImportedModel:
    """Read a .mesh, .mesh.xml, .skeleton or .skeleton.xml with the skeletons, scripts and images that it names.

    Raises InputError or FormatError where nothing can be had from it; everything less is a finding of the model."""
    findings = Findings(str(path))
    found = _read(path, settings, findings)
    model = ImportedModel(_stem(path), findings)
    rig = None
    if found.rig_source is not None and found.rig_file is not None:
        rig = _rig(found.rig_source, found.rig_file, found.mesh is None, findings)
    if found.mesh is not None:
        _Builder(path, settings, model, found.mesh, rig).build()
    elif rig is None:
        raise FormatError("the skeleton has no bones", where=path, hint="export it again")
    else:
        model.nodes.append(NodeAsset(model.name))
        _add_joints(model, rig)
        findings.info("ogre.skeleton", "a skeleton alone: joints and clips without a mesh")
    if rig is not None:
        _add_clips(model, found, rig)
    model.dependencies += [file for _, file in _skeleton_files(found, path)]
    model.summary |= _summary(found)
    return model


def dependencies(path: Path, settings: ImportSettings) -> list[tuple[str, Path]]:
    """(name, file) of the skeletons, scripts and images that the source names and that were found."""
    found = _read(path, settings, Findings(str(path)))
    files = _skeleton_files(found, path)
    if found.mesh is not None:
        materials = Materials(look_around(path.parent, _stem(path)), settings, Findings())
        for part in found.mesh.submeshes:
            materials.get(part.material, part.aliases)
        files += [(file.name, file) for file in materials.files()]
    return files


def _stem(path: Path) -> str:
    """The name without `.mesh`, `.mesh.xml` and the like."""
    name = path.name
    for suffix in (".mesh.xml", ".skeleton.xml", path.suffix):
        if suffix and name.lower().endswith(suffix.lower()) and len(name) > len(suffix):
            return name[: -len(suffix)]
    return name


# --- skeletons ---


def _read(path: Path, settings: ImportSettings, findings: Findings) -> _Found:
    source = read_source(path, settings, findings)
    if isinstance(source, OgreSkeleton):
        found = _Found(None, source, path)
    else:
        found = _Found(source, None, None)
        if source.skeleton:
            read = _read_skeleton(path, source.skeleton, settings, findings)
            if read is not None:
                found.rig_source, found.rig_file = read
    if found.rig_source is not None and found.rig_file is not None:
        _follow_links(found, settings, findings)
    return found


def _skeleton_file(beside: Path, name: str) -> Path | None:
    """The skeleton `name` beside a file: as named, as its XML or binary twin, or whatever case it is written in."""
    base = name.replace("\\", "/").rpartition("/")[2]
    names = [base, f"{base}.xml", base.removesuffix(".xml"), f"{base}.skeleton"]
    folder = beside.parent
    for candidate in names:
        if candidate and (folder / candidate).is_file():
            return folder / candidate
    try:
        listing = {entry.name.lower(): entry for entry in sorted(folder.iterdir())}
    except OSError:
        listing = {}
    near = [listing[c.lower()] for c in names if c.lower() in listing]
    around = look_around(folder, _stem(beside)) if not near else None
    near += [p for c in names for p in around.files.get(c.lower(), [])] if around is not None else []
    return next((p for p in near if p.is_file()), None)


def _read_skeleton(
    beside: Path, name: str, settings: ImportSettings, findings: Findings
) -> tuple[OgreSkeleton, Path] | None:
    file = _skeleton_file(beside, name)
    if file is None:
        findings.error(
            "ogre.skeleton", f"the skeleton {name[:120]!r} is not there; the mesh stays rigid", "skeleton",
            similar_name_hint(beside.parent / name.replace("\\", "/").rpartition("/")[2]),
        )  # fmt: skip
        return None
    try:
        source = read_source(file, settings, findings)
    except InputError as error:
        findings.error("ogre.skeleton", f"{file.name} cannot be used: {error.message}", str(error.where), error.hint)
        return None
    if not isinstance(source, OgreSkeleton):
        findings.error("ogre.skeleton", f"{file.name} is no skeleton", "skeleton")
        return None
    return source, file


def _follow_links(found: _Found, settings: ImportSettings, findings: Findings) -> None:
    """Skeletons whose animations the first one uses. Links of links are not followed: Ogre does not either."""
    assert found.rig_source is not None
    assert found.rig_file is not None
    links = found.rig_source.links
    if len(links) > _MAX_LINKS:
        findings.error("ogre.link", f"{len(links)} linked skeletons; the first {_MAX_LINKS} are read", "skeleton")
    for name, scale in links[:_MAX_LINKS]:
        read = _read_skeleton(found.rig_file, name, settings, findings)
        if read is not None:
            found.linked.append((read[0], read[1], scale))


def _skeleton_files(found: _Found, path: Path) -> list[tuple[str, Path]]:
    files = [file for file in (found.rig_file, *(file for _, file, _ in found.linked)) if file not in (None, path)]
    return [(file.name, file) for file in files if file is not None]


def _rig(source: OgreSkeleton, file: Path, alone: bool, findings: Findings) -> Rig | None:
    try:
        return make_rig(source, file.name, findings)
    except FormatError as error:
        if alone:
            raise
        findings.error("ogre.skeleton", f"{file.name}: {error.message}; the mesh stays rigid", error.where.path,
                       error.hint)  # fmt: skip
        return None


def _add_joints(model: ImportedModel, rig: Rig) -> list[int]:
    """Append the joints below the model's first node; returns their numbers in the scene."""
    first = len(model.nodes)
    for node in rig.nodes:
        node.parent = 0 if node.parent < 0 else node.parent + first
        model.nodes.append(node)
    return list(range(first, first + len(rig.nodes)))


def _add_clips(model: ImportedModel, found: _Found, rig: Rig) -> None:
    """Clips of the skeleton and the linked ones; channels join a clip of vertex animation of the same name."""
    assert found.rig_source is not None
    nodes = list(range(len(model.nodes) - len(rig.nodes), len(model.nodes)))
    clips: dict[str, ClipAsset] = {clip.name: clip for clip in model.clips}
    moved: set[str] = set()
    sources: Sequence[tuple[OgreSkeleton, str, float]] = [
        (found.rig_source, "", 1.0), *((source, f"{file.name}: ", scale) for source, file, scale in found.linked)
    ]  # fmt: skip
    for source, place, scale in sources:
        for number, animation in enumerate(source.animations):
            where = f"{place}animations[{number}]"
            clip = make_clip(animation, rig, nodes, scale, model.findings, where)
            if clip.name in moved:
                model.findings.warn("ogre.animation", f"a second animation {clip.name!r} is left out", where)
                continue
            moved.add(clip.name)
            if not clip.channels:
                model.findings.info("ogre.animation", f"the animation {clip.name!r} moves nothing", where)
            elif clip.name in clips:
                clips[clip.name].channels.extend(clip.channels)
            else:
                clips[clip.name] = clip
                model.clips.append(clip)


# --- the mesh ---


class _Builder:
    """Materials, vertices, morphs and nodes of one mesh."""

    def __init__(
        self, path: Path, settings: ImportSettings, model: ImportedModel, mesh: OgreMesh, rig: Rig | None
    ) -> None:
        self._path = path
        self._settings = settings
        self._model = model
        self._mesh = mesh
        self._rig = rig

    def build(self) -> None:
        model, mesh, findings = self._model, self._mesh, self._model.findings
        for what, count in sorted(mesh.left_out.items()):
            findings.info("ogre.left-out", f"{what} are not imported ({count} in the file)" if count > 1
                          else f"{what} are not imported")  # fmt: skip
        around = look_around(self._path.parent, model.name)
        materials = Materials(around, self._settings, findings)
        used = [materials.get(part.material, part.aliases) for part in mesh.submeshes]
        wanted = [Wanted(_normal_uv(materials.mapped[m].material), materials.mapped[m].vertex_color) for m in used]
        morphs = Morphs(mesh, findings, self._settings.max_decoded_bytes)
        if self._rig is None and (len(mesh.assignments) or any(len(part.assignments) for part in mesh.submeshes)):
            findings.warn("ogre.skin", "the bone assignments are not used: there is no skeleton", "skeleton")
        built, origin = MeshBuilder(mesh, model.name, self._rig, wanted, findings).build(morphs.targets)
        model.nodes.append(NodeAsset(model.name))
        if built is not None:
            self._place(built, [used[number] for number in origin], materials)
            if built.morphs:
                model.nodes[0].weights = [0.0] * len(built.morphs)
                for name, channel in morphs.channels(0, model.name).items():
                    model.clips.append(ClipAsset(name, [channel]))
            self._report_size(built)
        if self._rig is not None:
            joints = _add_joints(model, self._rig)
            if built is not None and built.skeleton is not None:
                model.nodes[0].joints = joints
        model.dependencies += materials.files()

    def _place(self, built: MeshAsset, slots: list[int], materials: Materials) -> None:
        """The mesh on the first node. Slots are material numbers; lines and points without normals get unlit twins."""
        model = self._model
        model.meshes.append(built)
        model.materials = [mapped.material for mapped in materials.mapped]
        model.images = materials.images
        twins: dict[int, int] = {}
        flat = self._without_normals()
        for s, part in enumerate(built.submeshes):
            if part.topology != "triangles" and flat and "unlit" not in model.materials[slots[s]].asset.features:
                slots[s] = twins.setdefault(slots[s], len(model.materials))
                if slots[s] == len(model.materials):
                    model.materials.append(_unlit(model.materials[next(k for k, v in twins.items() if v == slots[s])]))
        numbers = sorted(set(slots))
        for part, number in zip(built.submeshes, slots, strict=True):
            part.material_slot = numbers.index(number)
        model.slots.append(numbers)
        model.nodes[0].mesh = MeshRef("", 0, built.name)

    def _without_normals(self) -> bool:
        geometries = [self._mesh.shared, *(part.geometry for part in self._mesh.submeshes)]
        return any(geometry is not None and geometry.normal is None for geometry in geometries)

    def _report_size(self, built: MeshAsset) -> None:
        low = np.min([part.bounds_min for part in built.submeshes], axis=0)
        high = np.max([part.bounds_max for part in built.submeshes], axis=0)
        size = " x ".join(f"{v:.4g}" for v in high - low)
        self._model.findings.info(
            "ogre.units", f"Ogre files have no unit; taken as metres, the mesh is {size} m",
            hint="scale the node if that is not its size",
        )  # fmt: skip


def _unlit(material: ImportedMaterial) -> ImportedMaterial:
    asset = material.asset
    twin = MaterialAsset(
        f"{asset.name} unlit", asset.effect, asset.queue, [*asset.features, "unlit"], dict(asset.params),
        dict(asset.textures), dict(asset.extensions),
    )  # fmt: skip
    return ImportedMaterial(twin, dict(material.images))


def _normal_uv(material: ImportedMaterial) -> int | None:
    reference = material.asset.textures.get("normal_map")
    return None if reference is None else reference.uv_set


def _summary(found: _Found) -> dict[str, object]:
    mesh, rig = found.mesh, found.rig_source
    counts: dict[str, int] = {}
    if mesh is not None:
        counts = {"submeshes": len(mesh.submeshes), "poses": len(mesh.poses),
                  "vertex_animations": len(mesh.animations)}  # fmt: skip
    if rig is not None:
        counts |= {"bones": len(rig.bones), "skeleton_animations": len(rig.animations), "links": len(found.linked)}
    kind = "Ogre mesh" if mesh is not None else "Ogre skeleton"
    version = mesh.version if mesh is not None else rig.version if rig is not None else ""
    return {"format": kind, "version": version, "counts": counts}
