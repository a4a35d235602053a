"""Ogre file -> ImportedModel: mesh, skeletons, materials and clips in order, all findings collected."""

from __future__ import annotations

from pathlib import Path

from engine.assets.clip import ClipAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import MeshRef, NodeAsset
from engine.core.errors import FormatError, InputError
from engine.core.findings import Findings
from importers.model import ImportedModel
from importers.ogre.animations import make_clip
from importers.ogre.build import MeshBuilder, Wanted
from importers.ogre.data import OgreMesh, OgreSkeleton
from importers.ogre.morphs import Morphs
from importers.ogre.skeletons import Rig, make_rig
from importers.ogre.sources import read_source
from importers.settings import ImportSettings


def load(path: Path, settings: ImportSettings) -> ImportedModel:
    findings = Findings(str(path))
    mesh = read_source(path, settings, findings)
    model = ImportedModel(path.stem, findings)
    skeleton = read_source(path.parent / mesh.skeleton, settings, findings) if mesh.skeleton else None
    rig = make_rig(skeleton, "x", findings) if skeleton else None
    morphs = Morphs(mesh, findings, settings.max_decoded_bytes)
    built, origin = MeshBuilder(mesh, path.stem, rig, [Wanted()] * len(mesh.submeshes), findings).build(morphs.targets)
    model.nodes.append(NodeAsset(path.stem))
    if rig:
        for n in rig.nodes:
            n.parent += 1
            model.nodes.append(n)
    if built:
        model.meshes.append(built)
        model.slots.append([-1] * len(origin))
        model.nodes[0].mesh = MeshRef("", 0, built.name)
        if rig and built.skeleton:
            model.nodes[0].joints = list(range(1, 1 + len(rig.nodes)))
    if rig:
        for k, a in enumerate(skeleton.animations):
            model.clips.append(make_clip(a, rig, range(1, 1 + len(rig.nodes)), 1.0, findings, f"animations[{k}]"))
    return model


def dependencies(path: Path, settings: ImportSettings) -> list[tuple[str, Path]]:
    return []
