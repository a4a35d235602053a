"""Residency: engine files by path become mesh ids and material ids, each loaded once.

What cannot be read is replaced by something that shows (a magenta texture or material) and reported as a finding; the
rest still loads.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.dds import read_dds
from engine.assets.lmesh import read_lmesh
from engine.assets.material import MaterialAsset
from engine.assets.material_toml import read_material
from engine.assets.mesh import MeshAsset
from engine.assets.texture import TextureAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.core.paths import shaders_dir
from engine.gpu.types import Device
from engine.materials.effect import Effect
from engine.materials.library import EffectLibrary
from engine.resources.arena import MeshArena, MeshSlice
from engine.resources.material_store import MaterialRecord, MaterialStore
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


class Residency:
    """`interactive`: many frames will be drawn, so time spent at loading to draw faster is well spent.

    `findings` collects what went wrong while loading. `structure_rev` counts changes that alter draws."""

    def __init__(self, device: Device, effects: EffectLibrary | None = None, *, interactive: bool = False) -> None:
        self.device = device
        self.effects = effects or EffectLibrary([shaders_dir()])
        self.pool = TexturePool(device, interactive=interactive)
        self.materials = MaterialStore(device, self.pool)
        self.arenas: list[MeshArena] = []
        self.meshes: list[MeshInfo] = []
        self.findings = Findings()
        self._arena_by_layout: dict[tuple[str, ...], int] = {}
        self._mesh_files: dict[Path, list[int]] = {}
        self._material_files: dict[Path, int] = {}
        self._texture_files: dict[Path, PooledTexture] = {}
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
            try:
                asset = read_material(path)
                self._material_files[path] = self.add_material(asset, path.parent, str(path))
            except InputError as error:
                self.findings.error("material.unreadable", str(error), hint="drawn in magenta")
                self._material_files[path] = self.add_material(magenta_material(path.name), path.parent, str(path))
        return self._material_files[path]

    def load_materials(self, paths: Iterable[Path]) -> list[int]:
        """As load_material for many, with their textures' arrays allocated once."""
        wanted = [p.resolve() for p in paths]
        textures: dict[Path, TextureAsset] = {}
        for path in dict.fromkeys(wanted):
            if path in self._material_files:
                continue
            try:
                asset = read_material(path)
            except InputError:
                continue  # load_material reports it
            for ref in asset.textures.values():
                file = (path.parent / ref.path).resolve()
                if ref.path and file not in textures and file not in self._texture_files:
                    texture = self._read_texture(file)
                    if texture is not None:
                        textures[file] = texture
        self.pool.reserve(list(textures.values()))
        for file, texture in textures.items():
            self._texture_files[file] = self.pool.add(texture)
        return [self.load_material(path) for path in wanted]

    def add_material(self, asset: MaterialAsset, base: Path, path: str = "") -> int:
        """Add a material from memory; texture paths are relative to `base`. Raises InputError for an unknown effect."""
        effect = self.effects.get(asset.effect)
        textures = {slot.name: self._slot_texture(asset, slot.name, slot.default, base) for slot in effect.textures}
        return self.materials.add(asset, effect, textures, path)

    @property
    def default_material(self) -> int:
        """glTF 2.0, 3.9: the material of what names none: white, metallic 1, roughness 1."""
        if self._default_material < 0:
            self._default_material = self.add_material(MaterialAsset("default"), Path())
        return self._default_material

    def material(self, material: int) -> MaterialRecord:
        return self.materials.records[material]

    def effect_of(self, material: int) -> Effect:
        return self.materials.records[material].effect

    def set_material_param(self, material: int, name: str, value: Any) -> None:
        """Raises UsageError for an unknown name or a bad value."""
        self.materials.set_param(material, name, value)

    @property
    def texture_bytes(self) -> int:
        return self.pool.byte_size

    def release(self) -> None:
        for arena in self.arenas:
            arena.release()
        self.materials.release()
        self.pool.release()

    # --- inside ---

    def _arena(self, layout: tuple[str, ...]) -> int:
        if layout not in self._arena_by_layout:
            self._arena_by_layout[layout] = len(self.arenas)
            self.arenas.append(MeshArena(self.device, layout))
        return self._arena_by_layout[layout]

    def _slot_texture(self, asset: MaterialAsset, slot: str, default: str, base: Path) -> PooledTexture:
        ref = asset.textures.get(slot)
        if ref is None:
            return self._default(default)
        if not ref.path:
            return self._default(MISSING_TEXELS.get(slot, default))
        file = (base / ref.path).resolve()
        if file not in self._texture_files:
            texture = self._read_texture(file)
            if texture is None:
                return self._default(MISSING_TEXELS.get(slot, default))
            self._texture_files[file] = self.pool.add(texture)
        return self._texture_files[file]

    def _read_texture(self, file: Path) -> TextureAsset | None:
        try:
            return read_dds(file)
        except InputError as error:
            self.findings.error("texture.unreadable", str(error), hint="drawn in magenta; convert the source again")
            return None

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
