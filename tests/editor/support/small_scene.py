"""A scene in engine format, made of two boxes: small enough for a software rasteriser, real enough to edit."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.assets.lmesh import write_lmesh
from engine.assets.material import MaterialAsset
from engine.assets.material_toml import write_material
from engine.assets.mesh import MeshAsset, Submesh
from engine.assets.scene import EnvironmentAsset, LightAsset, MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import write_scene


def box() -> MeshAsset:
    """A cube from -0.5 to 0.5 with flat normals."""
    positions, normals, indices = [], [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            normal = np.eye(3)[axis] * sign
            u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3] * sign
            first = len(positions)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                positions.append(0.5 * (normal + a * u + b * v))
                normals.append([*(normal * 32767), 0])
            indices += [first, first + 1, first + 2, first, first + 2, first + 3]
    part = Submesh(0, 36, 0, "triangles", (-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
    streams = {"position": np.array(positions, np.float32), "normal": np.array(normals, np.int16)}
    return MeshAsset("box", dict(streams), np.array(indices, np.uint32), [part])


def write_small_scene(folder: Path) -> Path:
    """Write `boxes.scene.json` with its mesh and materials; returns its path."""
    folder.mkdir(parents=True, exist_ok=True)
    write_lmesh(folder / "boxes.lmesh", [box()])
    for name, color in (("red", (0.8, 0.05, 0.05, 1.0)), ("grey", (0.4, 0.4, 0.4, 1.0))):
        params = {"base_color": color, "metallic": 0.0, "roughness": 0.5}
        write_material(folder / f"boxes.{name}.material.toml", MaterialAsset(name, params=params))

    def ref(name: str) -> MeshRef:
        return MeshRef("boxes.lmesh", 0, "box", [f"boxes.{name}.material.toml"])

    nodes = [
        NodeAsset("stage"),
        NodeAsset("plinth", 0, (0.0, -0.6, 0.0), scale=(2.0, 0.2, 2.0), mesh=ref("grey")),
        NodeAsset("cube", 0, rotation=(0.0, 0.3826834, 0.0, 0.9238795), mesh=ref("red")),
        NodeAsset("lamp", 0, (1.0, 2.0, 2.0), light=LightAsset("point", intensity=8.0)),
    ]
    environment = EnvironmentAsset("uniform", color=(0.7, 0.75, 0.8), background="color", sun_illuminance=0.0)
    write_scene(folder / "boxes.scene.json", SceneAsset("boxes", nodes, environment=environment))
    return folder / "boxes.scene.json"
