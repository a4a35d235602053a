"""A figure of five bones with clips to walk, run and wave and one morph target, as files; and a host that opens it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from fake_engine import FakeHost
from small_scene import box

from editor.document import Document
from editor.host import Resolved
from editor.preferences import Preferences
from editor.session import Session
from engine.app.runtime import Runtime
from engine.assets.clip import Channel, ClipAsset
from engine.assets.lanim import write_lanim
from engine.assets.lmesh import write_lmesh
from engine.assets.mesh import MorphTarget, Skeleton
from engine.assets.scene import MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import write_scene
from engine.gpu import open_device
from engine.math import quat

#: name, parent, place
BONES = (("hips", 0, 1.0), ("spine", 1, 0.4), ("arm", 2, 0.4), ("hand", 3, 0.3), ("leg", 1, -0.5))


def write_animated_scene(folder: Path) -> Path:
    """Write `figure.scene.json` with its mesh and clips; returns its path."""
    folder.mkdir(parents=True, exist_ok=True)
    mesh = box()
    count = mesh.vertex_count
    nodes = [NodeAsset("figure")]
    nodes += [NodeAsset(name, parent, (0.0, y, 0.0)) for name, parent, y in BONES]
    heights = np.array([1.0, 1.4, 1.8, 2.1, 0.5])
    bind = np.tile(np.eye(4, dtype=np.float32), (5, 1, 1))
    bind[:, 1, 3] = -heights
    mesh.skeleton = Skeleton([b[0] for b in BONES], np.array([-1, 0, 1, 2, 0], np.int32), bind)
    mesh.streams["joints"] = np.tile(np.array([0, 1, 2, 4], np.uint16), (count, 1))
    mesh.streams["weights"] = np.tile(np.array([20000, 20000, 15000, 10535], np.uint16), (count, 1))
    mesh.morphs = [MorphTarget("wide", {"position": mesh.streams["position"].astype(np.float32) * [1.0, 0.0, 0.0]})]
    mesh.morphs[0].streams["position"] = mesh.morphs[0].streams["position"].astype(np.float32)
    write_lmesh(folder / "figure.lmesh", [mesh])
    nodes.append(
        NodeAsset("skin", 0, mesh=MeshRef("figure.lmesh", 0, "box", [""]), joints=[1, 2, 3, 4, 5], weights=[0.0])
    )
    for clip in clips():
        write_lanim(folder / f"figure.{clip.name}.lanim", clip)
    names = [f"figure.{c.name}.lanim" for c in clips()]
    write_scene(folder / "figure.scene.json", SceneAsset("figure", nodes, names))
    return folder / "figure.scene.json"


def clips() -> list[ClipAsset]:
    walk = ClipAsset("walk", [_sway(1, 1.0, 0.3), _sway(5, 1.0, 0.6), _step(1.0, 1.2)])
    run = ClipAsset("run", [_sway(1, 0.6, 0.6), _sway(5, 0.6, 1.2), _step(0.6, 2.0)])
    weights = Channel(6, "weights", "linear", np.array([0, 1], "f4"), np.array([[0], [1]], "f4"), "skin")
    wave = ClipAsset("wave", [_sway(3, 1.0, 1.0), weights])
    return [walk, run, wave]


def _sway(node: int, seconds: float, angle: float) -> Channel:
    times = np.linspace(0.0, seconds, 5).astype("f4")
    turns = quat.from_axis_angle(np.array([1.0, 0.0, 0.0]), angle * np.sin(2.0 * np.pi * times / seconds))
    return Channel(node, "rotation", "linear", times, turns.astype("f4"), BONES[node - 1][0])


def _step(seconds: float, metres: float) -> Channel:
    values = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, metres]], "f4")
    return Channel(1, "translation", "linear", np.array([0.0, seconds], "f4"), values, "hips")


class NullHost(FakeHost):
    """The real engine on a device that draws nothing; every path opens the figure in `folder`."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self.scene = write_animated_scene(folder)

    def open_device(self, attach: bool) -> Any:
        return open_device("null")

    def resolve(self, path: Path, progress: Any) -> Resolved:
        return Resolved(path, self.scene)

    def open_runtime(self, device: Any, scene: Path, root: Path | None = None, base: Path | None = None) -> Any:
        runtime = Runtime(device)
        runtime.open(scene, base=base)
        return runtime

    def view(self, camera: Any, width: int, height: int, settings: Any) -> Any:
        from editor.host import EngineHost

        return EngineHost().view(camera, width, height, settings)

    def new_settings(self) -> Any:
        from editor.host import EngineHost

        return EngineHost().new_settings()


def animated_session(folder: Path) -> Session:
    """A session with the figure open."""
    host = NullHost(folder)
    session = Session(host, Preferences(welcome_seen=True))
    session.save_preferences = False
    session.device = host.open_device(False)
    runtime = host.open_runtime(session.device, host.scene)
    session.adopt(Document(Resolved(host.scene, host.scene), runtime))
    session.playback.playing = False
    return session
