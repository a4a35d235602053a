"""Residency: engine files by path become mesh ids and material ids, each loaded once.

What cannot be read is replaced by something that shows (a magenta texture or material) and reported as a finding; the
rest still loads.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.lmesh import read_lmesh
from engine.assets.material import QUEUES, MaterialAsset, TextureRef
from engine.assets.material_parent import chain_files
from engine.assets.material_toml import read_material
from engine.assets.mesh import MeshAsset
from engine.assets.texture import TextureAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.core.paths import shaders_dir
from engine.core.toml_source import load_toml
from engine.core.watched import Watched
from engine.gpu.types import Device
from engine.materials.effect import Effect
from engine.materials.fit import fitted, in_numbers, merged, unfit
from engine.materials.library import EffectLibrary
from engine.resources.arena import MeshArena, MeshSlice
from engine.resources.material_store import MaterialRecord, MaterialStore
from engine.resources.procedural import ProceduralTextures
from engine.resources.texture_files import TextureFiles
from engine.resources.texture_pool import PooledTexture, TexturePool

#: texture slot default -> one RGBA8 texel
DEFAULT_TEXELS = {
    "white": (255, 255, 255, 255),
    "black": (0, 0, 0, 255),
    "flat_normal": (128, 128, 255, 255),
    "magenta": (255, 0, 255, 255),
}

#: what a wanted but missing texture shows; a missing emission must not glow. Other slots show their default.
MISSING_TEXELS = {"base_color_map": "magenta", "emissive_map": "black"}


@dataclass(frozen=True, slots=True)
class MeshInfo:
    """A resident mesh. `bounds`: f8[submeshes,4], centre and radius of each submesh in mesh space."""

    asset: MeshAsset
    arena: int
    place: MeshSlice
    bounds: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Reread:
    """A material file read again: `theirs` is the file's content, `asset` what is to be shown of it."""

    path: Path
    material: int
    asset: MaterialAsset
    effect: Effect
    theirs: MaterialAsset


class Residency:
    """`pixels`: how many will be drawn with it, about (see TexturePool).

    `findings` collects what went wrong while loading. `structure_rev` counts changes that alter draws."""

    def __init__(self, device: Device, effects: EffectLibrary | None = None, *, pixels: int = 0) -> None:
        self.device = device
        self.effects = effects or EffectLibrary([shaders_dir()])
        self.pool = TexturePool(device, pixels=pixels)
        self.materials = MaterialStore(device, self.pool)
        self.arenas: list[MeshArena] = []
        self.meshes: list[MeshInfo] = []
        self.findings = Findings()
        self._arena_by_layout: dict[tuple[str, ...], int] = {}
        self._mesh_files: dict[Path, list[int]] = {}
        self._material_files: dict[Path, int] = {}
        #: the material files that were asked for
        self.watched_materials = Watched()
        #: why a material file is not shown as it stands
        self.material_errors: dict[Path, InputError] = {}
        #: by material id: its file as it was last read; None where it could not be
        self._as_read: dict[int, MaterialAsset | None] = {}
        #: material file -> the files that it inherits from
        self._parents: dict[Path, frozenset[Path]] = {}
        #: the texture files that materials read
        self.textures = TextureFiles(self.pool, self.findings)
        #: texture slots that effects fill themselves
        self.procedural = ProceduralTextures(device, self.pool, self.effects, self.findings)
        self._defaults: dict[str, PooledTexture] = {}
        self._default_material = -1

    @property
    def structure_rev(self) -> int:
        return len(self.meshes) + self.materials.structure_rev

    # --- meshes ---

    def load_mesh_file(self, path: Path) -> list[int]:
        """Ids of all meshes in an .lmesh. Raises FormatError."""
        path = path.resolve()
        if path not in self._mesh_files:
            self._mesh_files[path] = self.add_meshes(read_lmesh(path))
        return self._mesh_files[path]

    def add_meshes(self, meshes: list[MeshAsset]) -> list[int]:
        """Upload meshes from memory; returns their ids in the same order."""
        by_layout: dict[tuple[str, ...], list[int]] = {}
        for i, mesh in enumerate(meshes):
            by_layout.setdefault(mesh.layout, []).append(i)
        infos: list[MeshInfo | None] = [None] * len(meshes)
        for layout, members in by_layout.items():
            arena = self._arena(layout)
            places = self.arenas[arena].add_many([meshes[i] for i in members])
            for i, place in zip(members, places, strict=True):
                infos[i] = MeshInfo(meshes[i], arena, place, _submesh_spheres(meshes[i]))
        first = len(self.meshes)
        self.meshes.extend(info for info in infos if info is not None)
        return list(range(first, first + len(meshes)))

    # --- materials ---

    def load_material(self, path: Path) -> int:
        """The id of a material file; the magenta material (with a finding) when it cannot be read."""
        path = path.resolve()
        if path not in self._material_files:
            self._watch(path)
            try:
                asset = read_material(path)
                self._effect(path, asset.effect)
                self._material_files[path] = self.add_material(asset, path.parent, str(path))
                self._as_read[self._material_files[path]] = deepcopy(asset)
            except InputError as error:
                self.material_errors[path] = error
                self.findings.error("material.unreadable", str(error), hint="drawn in magenta")
                self._material_files[path] = self.add_material(magenta_material(path.name), path.parent, str(path))
                self._as_read[self._material_files[path]] = None
        return self._material_files[path]

    def load_materials(self, paths: Iterable[Path]) -> list[int]:
        """As load_material for many, with their textures' arrays allocated once."""
        wanted = [p.resolve() for p in paths]
        textures: list[Path] = []
        for path in dict.fromkeys(wanted):
            if path in self._material_files:
                continue
            self._watch(path)
            try:
                asset = read_material(path)
            except InputError:
                continue  # load_material reports it
            for ref in asset.textures.values():
                if ref.path:
                    textures.append((path.parent / ref.path).resolve())
        self.textures.load(textures)
        return [self.load_material(path) for path in wanted]

    def add_material(self, asset: MaterialAsset, base: Path, path: str = "") -> int:
        """Add a material from memory; texture paths are relative to `base`. Raises InputError for an unknown effect."""
        effect = self.effects.get(asset.effect)
        asset = in_numbers(effect, asset)
        return self.materials.add(asset, effect, self._textures(asset, effect, base), path, base)

    def _watch(self, path: Path) -> None:
        """Look at a material file and at its parents from now on."""
        self._parents[path] = frozenset(file.resolve() for file in chain_files(path)[1:])
        self.watched_materials.add([path, *self._parents[path]])

    def parents_of(self, path: Path) -> frozenset[Path]:
        """The files that a material file inherits from, also such as are not there."""
        return self._parents.get(path, frozenset())

    @property
    def material_files(self) -> Mapping[Path, int]:
        """The material files that were asked for, and their ids."""
        return self._material_files

    @property
    def mesh_files(self) -> Mapping[Path, list[int]]:
        """The mesh files that were loaded, and the ids of their meshes."""
        return self._mesh_files

    def unread(self, material: int) -> bool:
        """Whether a material shows magenta because its file or its effect could not be read."""
        return material in self._as_read and self._as_read[material] is None

    def read_again(self, path: Path) -> Reread:
        """Read a changed material file. Parameters that were set here since it was read, and are the same in the file,
        keep what they were set to. Raises InputError (with file:line:col); nothing is changed yet."""
        material = self._material_files[path]
        self._watch(path)
        theirs = read_material(path)
        effect = self._effect(path, theirs.effect)
        _, complaints = fitted(effect, theirs)
        if complaints:
            raise unfit(path, complaints)
        base = self._as_read.get(material)
        asset = merged(base, self.materials.records[material].said, theirs) if base else deepcopy(theirs)
        return Reread(path, material, asset, effect, theirs)

    def saved_elsewhere(self, written: Iterable[Path]) -> None:
        """Files were written by who shows another state of the same scene: what they say is known now, and what is
        shown here stays as it is, also when they are read again."""
        files = {path.resolve() for path in written}
        for path, material in self._material_files.items():
            if self._as_read.get(material) is not None and (path in files or self._parents[path] & files):
                with contextlib.suppress(InputError):  # reading it again tells
                    self._as_read[material] = read_material(path)

    def reread_textures(self) -> list[Path]:
        """Show the pixels of texture files that changed on disk, or came; returns those taken over."""
        taken = self.textures.reread()
        moved = {file for file, elsewhere in taken.items() if elsewhere}
        for material, record in enumerate(self.materials.records if moved else ()):
            files = {(record.folder / ref.path).resolve() for ref in record.asset.textures.values() if ref.path}
            if files & moved:
                textures = self._textures(record.asset, record.effect, record.folder)
                self.materials.replace(material, record.asset, record.effect, textures, record.whole)
        return list(taken)

    def take(self, new: Reread) -> None:
        """Show what `read_again` gave."""
        fits, complaints = fitted(new.effect, new.asset)
        textures = self._textures(fits, new.effect, new.path.parent)
        self.materials.replace(new.material, fits, new.effect, textures, new.asset if complaints else None)
        self._as_read[new.material] = new.theirs

    def adopt_effect(self, name: str) -> list[InputError]:
        """After a hot reload of an effect: move its materials over. Returns what it no longer takes of them."""
        effect = self.effects.get(name)
        told = self.materials.adopt(effect, lambda asset, folder: self._textures(asset, effect, folder))
        return [
            unfit(Path(record.path), complaints)
            if record.path
            else InputError(complaints[0][1], where=record.asset.name)
            for record, complaints in told
        ]

    @property
    def default_material(self) -> int:
        """glTF 2.0, 3.9: the material of what names none: white, metallic 1, roughness 1."""
        if self._default_material < 0:
            self._default_material = self.add_material(MaterialAsset("default"), Path())
        return self._default_material

    def is_default(self, material: int) -> bool:
        """Whether it is the material of what names none."""
        return 0 <= self._default_material == material

    def material(self, material: int) -> MaterialRecord:
        return self.materials.records[material]

    def effect_of(self, material: int) -> Effect:
        return self.materials.records[material].effect

    def set_material_param(self, material: int, name: str, value: Any) -> None:
        """Raises UsageError for an unknown name or a bad value."""
        self.materials.set_param(material, name, value)

    def restate_material(self, material: int, asset: MaterialAsset) -> None:
        """Let a material say something else: other textures, features, queue, values. What its effect does not take is
        kept in `said`. Raises InputError for a queue that is none; then nothing is changed."""
        if asset.queue not in QUEUES:
            raise InputError(f"there is no queue {asset.queue!r}", hint=f"choose one of {', '.join(QUEUES)}")
        record = self.materials.records[material]
        fits, complaints = fitted(record.effect, asset)
        textures = self._textures(fits, record.effect, record.folder)
        self.materials.replace(material, fits, record.effect, textures, asset if complaints else None)

    @property
    def texture_bytes(self) -> int:
        return self.pool.byte_size

    def release(self) -> None:
        for arena in self.arenas:
            arena.release()
        self.materials.release()
        self.procedural.release()
        self.pool.release()

    # --- inside ---

    def _arena(self, layout: tuple[str, ...]) -> int:
        if layout not in self._arena_by_layout:
            self._arena_by_layout[layout] = len(self.arenas)
            self.arenas.append(MeshArena(self.device, layout))
        return self._arena_by_layout[layout]

    def _effect(self, path: Path, name: str) -> Effect:
        """The effect that a material file names. Raises InputError, at that line when there is none of the name."""
        try:
            return self.effects.get(name)
        except InputError as error:
            if error.where.file:
                raise
            source = load_toml(path)
            raise source.error(("effect",), error.message, hint=error.hint, value=True) from error

    def _textures(self, asset: MaterialAsset, effect: Effect, base: Path) -> dict[str, PooledTexture]:
        return {
            slot.name: self.procedural.pooled(effect, slot.name)
            if slot.name in effect.computed and not asset.textures.get(slot.name, TextureRef("")).path
            else self._slot_texture(asset, slot.name, slot.default, base)
            for slot in effect.textures
        }

    def _slot_texture(self, asset: MaterialAsset, slot: str, default: str, base: Path) -> PooledTexture:
        ref = asset.textures.get(slot)
        if ref is None:
            return self._default(default)
        if not ref.path:
            return self._default(MISSING_TEXELS.get(slot, default))
        texture = self.textures.get((base / ref.path).resolve())
        return texture if texture is not None else self._default(MISSING_TEXELS.get(slot, default))

    def _default(self, name: str) -> PooledTexture:
        if name not in self._defaults:
            texel = bytes(DEFAULT_TEXELS[name])
            self._defaults[name] = self.pool.add(TextureAsset("rgba8", 1, 1, [[texel]], name=name))
        return self._defaults[name]


def magenta_material(name: str) -> MaterialAsset:
    """What is drawn where a material cannot be."""
    return MaterialAsset(name, features=["unlit"], params={"base_color": (1.0, 0.0, 1.0, 1.0)})


def _submesh_spheres(mesh: MeshAsset) -> NDArray[np.float64]:
    low = np.array([s.bounds_min for s in mesh.submeshes], np.float64).reshape(-1, 3)
    high = np.array([s.bounds_max for s in mesh.submeshes], np.float64).reshape(-1, 3)
    return np.concatenate([(low + high) / 2, np.linalg.norm(high - low, axis=1, keepdims=True) / 2], axis=1)
