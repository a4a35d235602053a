"""MaterialStage: a material on a shape, drawn with an open runtime's materials, textures, effects and surroundings.

    runtime.residency ──shared──► MaterialStage: a scene of its own + a Renderer of its own ──► Frame

What is edited or reloaded in the runtime is what the stage shows: there is one row per material, and one program per
variant. Only the passes' own programs are the stage's; `poll` brings those up to date after a hot reload.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from engine.app.runtime import Runtime
from engine.assets.preview_shapes import shape
from engine.assets.scene import EnvironmentAsset, LookAsset
from engine.render.environments import Environments
from engine.render.frame import Frame
from engine.render.renderer import Renderer
from engine.render.view import View
from engine.scene.scene import Scene

#: above so many vertices a ball is taken round the box
MOST_POINTS = 500_000


@dataclass(frozen=True, slots=True)
class Part:
    """A resident mesh and where it stands: `world` f8[4,4]."""

    mesh: int
    world: NDArray[np.float64]


class MaterialStage:
    """Make it inside a device frame; `release` it before the runtime closes."""

    def __init__(self, runtime: Runtime) -> None:
        self.runtime = runtime
        self.renderer = Renderer(runtime.device, runtime.residency, profile=False)
        self.renderer.leads = False
        self.renderer.environments.release()
        self.renderer.environments = runtime.renderer.environments  # baked once for both
        self.scene = Scene("material")
        self._shapes: dict[str, int] = {}
        self._shown: tuple[object, ...] = ()

    def shape(self, name: str) -> list[Part]:
        """One of engine.assets.preview_shapes.SHAPES, uploaded once. Raises KeyError."""
        if name not in self._shapes:
            self._shapes[name] = self.runtime.residency.add_meshes([shape(name)])[0]
        return [Part(self._shapes[name], np.eye(4))]

    def show(self, parts: Sequence[Part], material: int) -> None:
        """Put `material` on all of `parts`; nothing is done where they show already."""
        key = (material, tuple((part.mesh, part.world.tobytes()) for part in parts))
        if key == self._shown:
            return
        self._shown = key
        surroundings, look = self.scene.environment, self.scene.look
        scene = self.scene = Scene("material")
        scene.environment, scene.look = surroundings, look
        rows = []
        for part in parts:
            node = scene.nodes.add("part", matrix=part.world)
            rows += [(node, part.mesh, s) for s in range(len(self.runtime.residency.meshes[part.mesh].asset.submeshes))]
        if rows:
            table = np.array(rows, np.int32)
            bounds = np.array([self.runtime.residency.meshes[mesh].bounds[s] for _, mesh, s in rows])
            scene.instances.add_many(
                table[:, 0], table[:, 1], table[:, 2], material, bounds[:, :3], bounds[:, 3].astype(np.float32)
            )
        scene.update()

    def surround(self, environment: EnvironmentAsset, look: LookAsset) -> None:
        """Stand in copies of these."""
        self.scene.environment, self.scene.look = replace(environment), replace(look)

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(min, max: f8[3]) of what is shown; a unit cube where that is nothing."""
        corners = []
        table = self.scene.instances
        for row in range(len(table.node)):
            part = self.runtime.residency.meshes[int(table.mesh[row])].asset.submeshes[int(table.submesh[row])]
            box = np.array(list(itertools.product(*zip(part.bounds_min, part.bounds_max, strict=True))), np.float64)
            world = self.scene.nodes.world_matrix(int(table.node[row]))
            corners.append(box @ world[:3, :3].T + world[:3, 3])
        points = np.concatenate(corners) if corners else np.array([[-0.5] * 3, [0.5] * 3])
        return points.min(axis=0), points.max(axis=0)

    def sphere(self) -> tuple[NDArray[np.float64], float]:
        """(centre f8[3], radius) of a ball round all that is shown, about the middle of its box: the same from all
        sides."""
        low, high = self.bounds()
        center = (low + high) / 2
        table = self.scene.instances
        shown = {(int(n), int(m)) for n, m in zip(table.node, table.mesh, strict=True)}
        radius = 0.0
        for node, mesh in shown:
            position = np.asarray(self.runtime.residency.meshes[mesh].asset.streams["position"], np.float64)
            if len(position) > MOST_POINTS:
                return center, float(np.linalg.norm(high - low)) / 2
            world = self.scene.nodes.world_matrix(node)
            away = position @ world[:3, :3].T + (world[:3, 3] - center)
            radius = max(radius, float(np.sqrt(np.einsum("ij,ij->i", away, away).max(initial=0.0))))
        return center, radius or 0.5

    def poll(self) -> list[str]:
        """After a hot reload: take over the passes whose files changed; their names."""
        return self.renderer.programs.poll()

    def render(self, view: View) -> Frame:
        """As Runtime.render."""
        return self.renderer.render(self.scene, view)

    def release(self) -> None:
        self.renderer.environments = Environments(self.runtime.device)  # the runtime's own stay
        self.renderer.release()
