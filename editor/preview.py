"""The material preview: which material, on what, how seen and lit, and its picture. No imgui.

selection or a pinned material ─┐
PreviewSetup (remembered) ──────┼─► MaterialStage (engine.app) ─► the last good Frame; drawn only when it would differ
the scene's surroundings ───────┘
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import asdict, astuple, dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from editor.baking import surroundings_revision
from editor.camera_controls import OrbitCamera, orbit, pan
from editor.opening import OpenJob
from engine.assets.preview_shapes import SHAPES
from engine.core.errors import LucarnaError

if TYPE_CHECKING:
    from editor.session import Session

#: light of the open scene, or the studio that comes with Lucarna
LIGHTS = ("scene", "studio")
BACKDROPS = ("blurred", "sharp", "plain")
#: (what is asked for, its label) beside SHAPES: the mesh of the selected node; a mesh of the scene; a file
SELECTED, MESH, FILE = "selected", "mesh", "file"
#: what is behind: a scene-linear colour, or the surroundings as a surface of this roughness mirrors them
PLAIN, BLUR = (0.045, 0.047, 0.052), 0.5
#: milliseconds of a picture above which it is made at half resolution while something moves
SLOW_MS = 45.0
_FOV = math.radians(30.0)
#: how much of the picture's height stays free round the shape's ball
MARGIN = 1.06


@dataclass(slots=True)
class PreviewSetup:
    """What the preferences keep. `shape`: of SHAPES, or SELECTED, MESH, FILE with `mesh` its name or path. Angles in
    radians, `rotation` of the light in degrees; `zoom` 1 fits the shape into the picture."""

    shape: str = "sphere"
    mesh: str = ""
    yaw: float = 0.45
    pitch: float = -0.3
    zoom: float = 1.0
    rotation: float = 0.0
    light: str = "scene"
    backdrop: str = "blurred"

    @classmethod
    def read(cls, stored: dict[str, Any]) -> PreviewSetup:
        """From preferences: what is missing or makes no sense is the default."""
        made = cls()
        for field in fields(cls):
            value, default = stored.get(field.name), getattr(made, field.name)
            if isinstance(default, float) and isinstance(value, int) and not isinstance(value, bool):
                value = float(value)
            if type(value) is type(default) and (not isinstance(value, float) or math.isfinite(value)):
                setattr(made, field.name, value)
        made.shape = made.shape if made.shape in (*SHAPES, SELECTED, MESH, FILE) else "sphere"
        made.light = made.light if made.light in LIGHTS else "scene"
        made.backdrop = made.backdrop if made.backdrop in BACKDROPS else "blurred"
        made.pitch = min(max(made.pitch, -1.55), 1.55)
        made.zoom = min(max(made.zoom, 0.05), 20.0)
        return made


class Preview:
    """`frame`: the last good picture; `renders` counts those made. `pinned`: a material id that stays while the
    selection goes on, or -1. `scale`: the resolution of the picture at hand."""

    def __init__(self) -> None:
        self.setup = PreviewSetup()
        self.pinned = -1
        self.frame: Any = None
        self.renders = 0
        self.error = ""
        self.material = -1
        #: what stands in for a mesh that is not there
        self.note = ""
        self.offset = (0.0, 0.0, 0.0)
        self.scale = 1.0
        self._remembered: PreviewSetup | None = None
        self._stage: Any = None
        self._owner: object = None
        self._key: Hashable = None
        self._taken = 0
        self._job: OpenJob | None = None
        self._files: dict[str, Any] = {}

    # --- what is shown ---

    def load(self, session: Session) -> None:
        """Take the set-up over from the preferences, once."""
        if self._remembered is None:
            self.setup = PreviewSetup.read(session.preferences.preview)
            self._remembered = replace(self.setup)

    def remember(self, session: Session) -> None:
        """Keep the set-up in the preferences, when it changed."""
        if self._remembered is not None and self.setup != self._remembered:
            self._remembered = replace(self.setup)
            session.preferences.preview = asdict(self.setup)
            session.remember()

    def subject(self, session: Session) -> int:
        """The material that is to be shown: the pinned one, that of the selection, the one shown last, any; or -1."""
        document = session.document
        if document is None or not hasattr(document.runtime, "renderer"):  # a host without pictures
            return -1
        count = len(document.runtime.residency.materials.records)
        if 0 <= self.pinned < count:
            return self.pinned
        if document.primary >= 0:
            instances = document.runtime.scene.instances
            found = instances.material[np.asarray(instances.node) == document.primary]
            if len(found):
                return int(found[0])
        if 0 <= self.material < count:
            return self.material
        used = document.runtime.scene.instances.material
        return int(used[0]) if len(used) else -1

    def mesh_names(self, session: Session) -> list[str]:
        """The named meshes of the open scene, each once."""
        document = session.document
        if document is None:
            return []
        scene, meshes = document.runtime.scene, document.runtime.residency.meshes
        used = sorted(set(np.asarray(scene.instances.mesh)[scene.instances.alive].tolist()))
        return list(dict.fromkeys(meshes[mesh].asset.name for mesh in used if meshes[mesh].asset.name))

    def take(self, session: Session, path: Path) -> None:
        """Show a material file, also one that the scene does not use; or put the material on a model from now on."""
        if path.name.endswith(".material.toml"):
            if session.document is not None:
                with session.device_frame():
                    self.pinned = session.document.runtime.residency.load_material(path)
        elif path.name.endswith((".lmesh", ".scene.json", *session.host.source_extensions())):
            self.setup.shape, self.setup.mesh = FILE, str(path)
        else:
            session.ui.notice = f"{path.name} is no material, model or scene"

    # --- looking ---

    def camera(self) -> OrbitCamera:
        """The camera of the set-up, framing what is shown."""
        center, radius = self._stage.sphere() if self._stage is not None else (np.zeros(3), 0.5)
        x, y, z = (float(c) for c in center + np.asarray(self.offset))
        distance = MARGIN * radius / math.sin(_FOV / 2) * self.setup.zoom
        return OrbitCamera((x, y, z), self.setup.yaw, self.setup.pitch, distance=distance, yfov=_FOV)

    def orbit(self, dx: float, dy: float) -> None:
        turned = orbit(OrbitCamera(yaw=self.setup.yaw, pitch=self.setup.pitch), dx, dy)
        self.setup.yaw, self.setup.pitch = turned.yaw, turned.pitch

    def pan(self, dx: float, dy: float, height: float) -> None:
        before = self.camera()
        moved = np.asarray(pan(before, dx, dy, height).target) - np.asarray(before.target) + np.asarray(self.offset)
        self.offset = (float(moved[0]), float(moved[1]), float(moved[2]))

    def come_nearer(self, factor: float) -> None:
        self.setup.zoom = min(max(self.setup.zoom * factor, 0.05), 20.0)

    def turn_light(self, dx: float) -> None:
        """By a drag of `dx` pixels: half a degree each, as in the viewport."""
        self.setup.rotation = math.remainder(self.setup.rotation + 0.5 * dx, 360.0)

    def look_again(self) -> None:
        """Back to how it was framed and lit at first."""
        first = PreviewSetup()
        self.setup.yaw, self.setup.pitch, self.setup.zoom = first.yaw, first.pitch, first.zoom
        self.setup.rotation, self.offset = 0.0, (0.0, 0.0, 0.0)

    # --- the picture ---

    def update(self, session: Session, width: int, height: int) -> Any:
        """The picture at `width` x `height` pixels, made again if it would be another; None where there can be none.

        What fails is logged once, and the last good picture stays."""
        document = session.document
        if document is None or width < 8 or height < 8:
            return None
        self.material = self.subject(session)
        if self.material < 0:
            return None
        self._take_job(session)
        slow = self.frame is not None and self.frame.stats.total_ms > SLOW_MS
        self.scale = 0.5 if session.interacting and slow else 1.0
        width, height = max(round(width * self.scale), 8), max(round(height * self.scale), 8)
        runtime = document.runtime
        key = (id(runtime), width, height, *self._state(session))
        if key == self._key:
            return self.frame
        try:
            with session.device_frame():
                self._draw(session, width, height)
            self.renders += 1
            self.error = ""
        except LucarnaError as error:
            self.error = str(error)
            session.messages.error(error)
        # taken after drawing: new shapes move the residency's revision
        self._key = (id(runtime), width, height, *self._state(session))
        return self.frame

    def forget(self) -> None:
        """The document goes. Inside a device frame."""
        if self._stage is not None:
            self._stage.release()
        self._stage = self._owner = self.frame = self._key = None
        self.pinned = self.material = -1
        self._files.clear()
        self._job = None

    def _state(self, session: Session) -> tuple[Hashable, ...]:
        """What the picture depends on besides its size."""
        document = session.document
        assert document is not None
        residency, scene = document.runtime.residency, document.runtime.scene
        selected = document.primary if self.setup.shape == SELECTED else -1
        return (
            self.material, int(residency.materials.values_rev), int(residency.effects.revision), session.shaders.taken,
            astuple(self.setup), self.offset, selected, astuple(scene.environment), astuple(scene.look),
            surroundings_revision(document.runtime),
            self.setup.mesh in self._files,
        )  # fmt: skip

    def _draw(self, session: Session, width: int, height: int) -> None:
        from engine.app.material_stage import MaterialStage
        from engine.assets.scene import EnvironmentAsset

        document = session.document
        assert document is not None
        setup = self.setup
        runtime: Any = document.runtime  # the engine's own: see subject()
        if self._owner is not runtime:
            self._stage, self._owner = MaterialStage(runtime), runtime
            self._taken = session.shaders.taken
        if self._taken != session.shaders.taken:
            self._taken = session.shaders.taken
            self._stage.poll()
        scene = runtime.scene
        self._stage.surround(EnvironmentAsset("studio") if setup.light == "studio" else scene.environment, scene.look)
        self._stage.show(self._parts(session), self.material)
        around = self._stage.scene.environment
        around.background = "color" if setup.backdrop == "plain" else "environment"
        around.background_color, around.background_blur = PLAIN, BLUR if setup.backdrop == "blurred" else 0.0
        settings = type(session.settings)(environment_rotation=setup.rotation)
        self.frame = self._stage.render(session.host.view(self.camera(), width, height, settings))

    def _parts(self, session: Session) -> list[Any]:
        """What the material is put on; the sphere, with a note, where that is not there."""
        from engine.app.material_stage import Part

        document, setup = session.document, self.setup
        assert document is not None
        scene, meshes = document.runtime.scene, document.runtime.residency.meshes
        self.note = ""
        if setup.shape in SHAPES:
            return list(self._stage.shape(setup.shape))
        if setup.shape == SELECTED:
            rows = np.asarray(scene.instances.node) == document.primary
            found = sorted(set(np.asarray(scene.instances.mesh)[rows].tolist()))
            if found:
                return [Part(mesh, np.eye(4)) for mesh in found]
            self.note = "nothing with a mesh is selected"
        elif setup.shape == MESH:
            named = [i for i, mesh in enumerate(meshes) if mesh.asset.name == setup.mesh]
            if named:
                return [Part(named[0], np.eye(4))]
            self.note = f"there is no mesh {setup.mesh!r} here"
        else:
            parts = self._file(session, Path(setup.mesh))
            if parts:
                return parts
            self.note = self.note or f"nothing of {Path(setup.mesh).name} can be shown"
        return list(self._stage.shape("sphere"))

    def _file(self, session: Session, path: Path) -> list[Any]:
        """The parts of a file: of an .lmesh at once; of a model or scene once a thread has imported it."""
        known = self._files.get(str(path))
        if known is not None:
            return list(known)
        if path.suffix == ".lmesh":
            from engine.app.material_stage import Part

            assert session.document is not None
            ids = session.document.runtime.residency.load_mesh_file(path)
            self._files[str(path)] = [Part(mesh, np.eye(4)) for mesh in ids]
            return list(self._files[str(path)])
        if self._job is None or self._job.path != path:
            self._job = OpenJob(session.host, path)
        self.note = f"importing {path.name}"
        return []

    def _take_job(self, session: Session) -> None:
        """Take over what a finished import found."""
        job = self._job
        if job is None or not job.done:
            return
        self._job = None
        self._files[str(job.path)] = []
        if job.error is not None:
            session.fail(job.error)
        elif job.result is not None and session.document is not None:
            try:
                self._files[str(job.path)] = _parts_of(session.document.runtime, job.result.scene)
            except LucarnaError as error:
                session.fail(error)

    @property
    def busy(self) -> bool:
        """Whether a file is being imported for it."""
        return self._job is not None


def _parts_of(runtime: Any, scene_path: Path) -> list[Any]:
    """The meshes of a scene file, each where it stands in it."""
    from engine.app.material_stage import Part
    from engine.assets.scene_json import read_scene
    from engine.scene.scene import Scene

    asset = read_scene(scene_path)
    scene, parts = Scene.from_asset(asset), []
    for node, row in zip(asset.nodes, scene.row_of_node.tolist(), strict=True):
        if node.mesh is not None:
            ids = runtime.residency.load_mesh_file(scene_path.parent / node.mesh.file)
            if 0 <= node.mesh.index < len(ids):
                parts.append(Part(ids[node.mesh.index], scene.nodes.world_matrix(row)))
    return parts
