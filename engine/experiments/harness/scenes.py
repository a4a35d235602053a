"""Scenes that experiments measure on: from a file, made here from shapes, or the one that is open in an editor.

open_scene(ctx, name) ─┬─ "open scene"   ctx.live, lent by an editor        LiveScene: a renderer for each trial
                       ├─ "made: NAME"   harness.samples                    MadeScene: nothing but the engine
                       └─ a path         ctx.tools.open_scene (importers)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.material import MaterialAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import LightAsset
from engine.core.errors import LucarnaError
from engine.gpu.types import Device
from engine.render.camera import Camera
from engine.render.environments import Environments, usable
from engine.render.frame import Frame
from engine.render.renderer import Renderer
from engine.render.view import View
from engine.resources.residency import Residency
from engine.scene.scene import Scene

if TYPE_CHECKING:
    from engine.experiments.harness.context import Context, OpenScene

LIVE, MADE = "open scene", "made: "


def explain(frame: Frame) -> list[str]:
    """What was left out of a frame, and why."""
    found = [f"pass {item.name}: {item.reason}" for item in frame.graph.left_out]
    absent = [m for m, value in frame.facts.variant_defines().items() if not value and m != "DEBUG_VIEW"]
    return found + [f"branch {macro}: the scene has none" for macro in absent]


def faces_of(environments: Environments, scene: Scene) -> NDArray[np.float32]:
    """What surrounds a scene as it is drawn: the finest mip of its cube, f4[6,n,n,3]."""
    texture = environments.get(usable(scene.environment)).texture
    faces = [np.asarray(texture.read(level=0, layer=face), np.float32)[..., :3] for face in range(6)]
    return np.stack(faces)


class MadeScene:
    """A scene from memory in a renderer of its own; see engine.experiments.harness.context.OpenScene."""

    def __init__(self, name: str, device: Device) -> None:
        self.name = name
        self.device = device
        self.residency = Residency(device)
        self.renderer = Renderer(device, self.residency, profile=False)
        self.scene = Scene(name)
        self.view_from = Camera()
        self._closing: list[Callable[[], None]] = []

    def add(
        self, mesh: MeshAsset, material: MaterialAsset, position: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike = (0.0, 0.0, 0.0, 1.0), scale: ArrayLike = 1.0,
    ) -> int:  # fmt: skip
        """Put a mesh there; returns its node."""
        return self.add_many(mesh, material, np.reshape(position, (1, 3)), rotation, scale)[0]

    def add_many(
        self, mesh: MeshAsset, material: MaterialAsset, positions: ArrayLike,
        rotation: ArrayLike = (0.0, 0.0, 0.0, 1.0), scale: ArrayLike = 1.0, folder: Path | None = None,
    ) -> list[int]:  # fmt: skip
        """Put the same mesh at each of `positions` [n,3]; returns the nodes. `folder`: where textures are."""
        mesh_id = self.residency.add_meshes([mesh])[0]
        material_id = self.residency.add_material(material, folder or Path())
        bounds = self.residency.meshes[mesh_id].bounds[0]
        size = np.broadcast_to(scale, 3)
        nodes = [self.scene.nodes.add(mesh.name, -1, p, rotation, size) for p in np.asarray(positions, np.float64)]
        self.scene.instances.add_many(nodes, mesh_id, 0, material_id, bounds[:3], bounds[3])
        self.scene.update()
        return nodes

    def lamp(
        self, light: LightAsset, position: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike = (0.0, 0.0, 0.0, 1.0)
    ) -> None:
        """Hang a light there; it shines along -Z of `rotation`."""
        self.scene.lights.add(self.scene.nodes.add("lamp", -1, position, rotation), light)
        self.scene.update()

    def camera(self, aspect: float) -> Camera:
        return self.view_from

    def render(self, view: View, *, hdr: bool = False) -> Frame:
        return self.renderer.render(self.scene, view, hdr=hdr)

    def explain(self, frame: Frame) -> list[str]:
        return explain(frame)

    def environment_faces(self) -> NDArray[np.float32]:
        return faces_of(self.renderer.environments, self.scene)

    def keep(self, cleanup: Callable[[], None]) -> None:
        """Call it when the scene is closed."""
        self._closing.append(cleanup)

    def close(self) -> None:
        self.renderer.release()
        self.residency.effects.release()
        self.residency.release()
        for cleanup in self._closing:
            cleanup()


class LiveScene:
    """The scene that is open: its tables and what it has on the device. Every trial gets a renderer of its own for it
    (`fresh`), so that the editor's pictures, and the other trials' times, stay what they are."""

    def __init__(self, scene: Scene, residency: Residency, view: View, renderer: Renderer) -> None:
        """`view`: where it is seen from, and how. `renderer`: the editor's; whatever bakes its environments is used."""
        self.name = LIVE
        self.scene, self.residency, self.view = scene, residency, view
        self._like = renderer
        self._own: Renderer | None = None

    def fresh(self) -> LiveScene:
        """The same with nothing compiled; the caller closes it."""
        return LiveScene(self.scene, self.residency, self.view, self._like)

    @property
    def _renderer(self) -> Renderer:
        if self._own is None:
            self._own = Renderer(self.residency.device, self.residency, profile=False)
            self._own.environments.baker = self._like.environments.baker
        return self._own

    def camera(self, aspect: float) -> Camera:
        return self.view.camera

    def render(self, view: View, *, hdr: bool = False) -> Frame:
        return self._renderer.render(self.scene, view, hdr=hdr)

    def explain(self, frame: Frame) -> list[str]:
        return explain(frame)

    def environment_faces(self) -> NDArray[np.float32]:
        return faces_of(self._renderer.environments, self.scene)

    def close(self) -> None:
        """Free what the renderer of its own holds on the device; the scene stays."""
        if self._own is not None:
            self._own.release()
            self._own = None


def own_or(ctx: Context, others: Sequence[str]) -> list[str]:
    """Names of the scenes to measure on: the open one, else the caller's files, else `others`."""
    if ctx.live is not None:
        return [LIVE]
    return [named(ctx, name) for name in ([str(path) for path in ctx.scenes] or others)]


def named(ctx: Context, scene: str) -> str:
    """The name under which a scene goes in reports: that of its file, without the folders of this machine; two files
    of one name are told apart by a number. `open_scene` knows it."""
    if scene.startswith((LIVE, MADE)):
        return scene
    known: dict[str, str] = ctx.scratch.setdefault("scene files", {})
    name, number = Path(scene).name, 1
    while known.get(name, scene) != scene:
        number += 1
        name = f"{Path(scene).name} ({number})"
    known[name] = scene
    return name


def short(name: str) -> str:
    """A scene's name where a table or a file's name has it."""
    return name.removeprefix(MADE)


def open_scene(ctx: Context, name: str) -> OpenScene:
    """Open one; the caller closes it. Raises InputError, and LucarnaError without a device or the importers."""
    if name == LIVE and ctx.live is not None:
        return ctx.live.fresh()
    if ctx.device is None:
        raise LucarnaError("a scene needs a graphics device", hint="see `lucarna doctor`")
    if name.startswith(MADE):
        from engine.experiments.harness.samples import build

        return build(name.removeprefix(MADE), ctx.device)
    path: str = ctx.scratch.get("scene files", {}).get(name, name)
    return ctx.lent().open_scene(Path(path), ctx.device)
