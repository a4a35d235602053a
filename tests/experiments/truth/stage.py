"""Small scenes for the tracer, made of arrays: no device, no files."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.assets.mesh import MeshAsset
from engine.assets.scene import LightAsset
from engine.experiments.truth.lamps import Lamps
from engine.experiments.truth.rays import Rays
from engine.experiments.truth.surfaces import _VALUES, Materials
from engine.experiments.truth.surroundings import Surroundings
from engine.experiments.truth.traced_scene import TracedScene
from engine.experiments.truth.triangles import Triangles, mesh_triangles
from engine.scene.scene import Scene

EYE = np.eye(3, 4)[None]


def triangles(mesh: MeshAsset, material: int = 0, move: Any = (0.0, 0.0, 0.0), scale: float = 1.0) -> Triangles:
    m = np.concatenate([np.eye(3) * scale, np.reshape(move, (3, 1))], axis=1)[None]
    used = np.arange(mesh.vertex_count)
    return mesh_triangles(mesh, used, np.asarray(mesh.indices, np.int64).reshape(-1, 3), m, material)


def join(*parts: Triangles) -> Triangles:
    return Triangles(*(np.concatenate([getattr(p, name) for p in parts]) for name in Triangles.__slots__))


def material(count: int = 1, **values: Any) -> Materials:
    """`count` materials alike: base, emissive (3), metallic, roughness, specular …"""
    made = Materials(
        {name: np.zeros(count) for name in _VALUES}, np.ones((count, 4)), np.zeros((count, 3)), np.ones((count, 3)),
        np.zeros(count, np.int8), np.zeros(count, bool), np.zeros(count, bool),
    )  # fmt: skip
    for name, value in {"roughness": 1.0, "emissive_strength": 1.0, "ior": 1.5, "alpha_cutoff": 0.5, **values}.items():
        if name in made.values:
            made.values[name][:] = value
        elif name == "base":
            made.base[:, :3] = value
        else:
            setattr(made, name, np.broadcast_to(value, (count, 3)).copy())
    return made


def lamps(*lights: tuple[LightAsset, Any, Any]) -> Lamps:
    """(light, position, rotation) each."""
    scene = Scene()
    for light, position, rotation in lights:
        scene.lights.add(scene.nodes.add("lamp", -1, position, rotation), light)
    scene.update()
    return Lamps(scene.lights.world())


def scene(shapes: Triangles, materials: Materials, light: Lamps | None = None, around: Any = 0.0) -> TracedScene:
    faces = np.broadcast_to(np.asarray(around, np.float64), (6, 1, 1, 3))
    return TracedScene(
        shapes, Rays(shapes.corners), materials, light or lamps(), Surroundings(faces), background=np.zeros(3)
    )
