"""SampleScene: a scene with all its parts in memory; made by name, written to a folder."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast

from engine.assets.clip import ClipAsset
from engine.assets.lanim import write_lanim
from engine.assets.lmesh import write_lmesh
from engine.assets.material import MaterialAsset
from engine.assets.material_toml import write_material
from engine.assets.mesh import MeshAsset
from engine.assets.records import did_you_mean
from engine.assets.samples import CHARACTERS, SAMPLES
from engine.assets.scene import MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import write_scene
from engine.core.atomic import write_text
from engine.core.errors import UsageError

#: what a sample is made with if not told otherwise
DEFAULT_LIGHTS, MOST_LIGHTS = 1024, 200_000


@dataclass(slots=True)
class SampleScene:
    """`scene` names meshes by their index in `meshes` and materials by the keys of `materials`."""

    scene: SceneAsset
    meshes: list[MeshAsset] = field(default_factory=list)
    materials: dict[str, MaterialAsset] = field(default_factory=dict)
    clips: list[ClipAsset] = field(default_factory=list)
    #: other files beside it, by name
    texts: dict[str, str] = field(default_factory=dict)

    @property
    def mesh_file(self) -> str:
        return f"{self.scene.name}.lmesh"

    def material(self, name: str, **params: object) -> str:
        """Add a material of the standard surface, no metal unless `params` say so; returns its key."""
        key = f"{self.scene.name}.{name}.material.toml"
        self.materials[key] = MaterialAsset(name, params={"metallic": 0.0, **params})
        return key

    def mesh(self, mesh: MeshAsset) -> int:
        self.meshes.append(mesh)
        return len(self.meshes) - 1

    def place(
        self, name: str, mesh: int, material: str, translation: tuple[float, float, float] = (0.0, 0.0, 0.0),
        rotation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0),
        scale: tuple[float, float, float] = (1.0, 1.0, 1.0),
    ) -> int:  # fmt: skip
        """Add a node with that mesh; returns its index."""
        ref = MeshRef(self.mesh_file, mesh, self.meshes[mesh].name, [material])
        self.scene.nodes.append(NodeAsset(name, -1, translation, rotation, scale, mesh=ref))
        return len(self.scene.nodes) - 1


def make_sample(name: str, *, lights: int = DEFAULT_LIGHTS, seed: int = 1) -> SampleScene:
    """Build one of SAMPLES with that many lights, or one of CHARACTERS.

    Raises UsageError for an unknown name or a count out of range."""
    known = SAMPLES | CHARACTERS
    if name not in known:
        raise UsageError(
            f"there is no sample {name!r}", hint=did_you_mean(name, known) or f"samples: {', '.join(known)}"
        )
    if not 0 <= lights <= MOST_LIGHTS:
        raise UsageError(f"a sample of {lights} lights", hint=f"0 to {MOST_LIGHTS} lights can be had")
    build = cast("Callable[[int, int], SampleScene]", importlib.import_module(known[name][0]).build)
    return build(lights, seed)


def write_sample(sample: SampleScene, folder: Path) -> Path:
    """Write all its files into `folder`, which must be there; returns the scene file. Raises OutputError."""
    name = sample.scene.name
    write_lmesh(folder / sample.mesh_file, sample.meshes)
    for key, material in sample.materials.items():
        write_material(folder / key, material)
    for clip, file in zip(sample.clips, sample.scene.clips, strict=True):
        write_lanim(folder / file, clip)
    for file, text in sample.texts.items():
        write_text(folder / file, text)
    path = folder / f"{name}.scene.json"
    write_scene(path, sample.scene)
    return path
