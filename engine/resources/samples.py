"""Sample scenes straight from memory into a scene and a residency: for benches, experiments and tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.assets.samples.sample import SampleScene
from engine.resources.residency import Residency
from engine.scene.scene import Scene


def sample_scene(sample: SampleScene, residency: Residency) -> Scene:
    """Return the sample as a scene whose meshes and materials are in `residency`, updated.

    Its clips play with ClipPlayer(clip, scene.row_of_node) of engine.animation.sample.
    """
    scene = Scene.from_asset(sample.scene)
    meshes = residency.add_meshes(sample.meshes)
    materials = {key: residency.add_material(material, Path()) for key, material in sample.materials.items()}
    nodes: list[int] = []
    kinds: list[tuple[int, int, int]] = []
    bounds = []
    for row, node in zip(scene.row_of_node.tolist(), sample.scene.nodes, strict=True):
        if node.mesh is None:
            continue
        mesh = meshes[node.mesh.index]
        for part, submesh in enumerate(residency.meshes[mesh].asset.submeshes):
            nodes.append(row)
            kinds.append((mesh, part, materials[node.mesh.materials[submesh.material_slot]]))
            bounds.append(residency.meshes[mesh].bounds[part])
    if nodes:
        table, spheres = np.array(kinds, np.int32), np.array(bounds)
        scene.instances.add_many(
            nodes, table[:, 0], table[:, 1], table[:, 2], spheres[:, :3], spheres[:, 3].astype(np.float32)
        )
    scene.update()
    return scene
