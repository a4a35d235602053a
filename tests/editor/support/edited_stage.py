"""A scene of everything without a device, its state as comparable bytes, and random edits to it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from editor.commands import structure
from editor.document import Document
from editor.host import Resolved
from engine.assets.scene import CameraAsset, LightAsset, MeshRef, NodeAsset, SceneAsset
from engine.core.errors import InputError
from engine.scene.patch import remember
from engine.scene.scene import Scene


class FileRuntime:
    """A scene with two meshes, a light, a camera, a sheared node and a skin; no device."""

    def __init__(self) -> None:
        shear = (1.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.1, 0.2, 0.3, 1.0)
        self.asset = SceneAsset(
            "stage",
            [
                NodeAsset("root"),
                NodeAsset("arm", 0, (1.0, 2.0, 3.0), (0.0, 0.6, 0.0, 0.8), (1.0, 2.0, 0.5)),
                NodeAsset("box", 1, (0.1, 0.2, 0.3), mesh=MeshRef("a.lmesh", 0, "box", ["red.material.toml"])),
                NodeAsset("lamp", 1, light=LightAsset("spot", intensity=3.0)),
                NodeAsset("eye", -1, camera=CameraAsset(yfov=0.5)),
                NodeAsset("skewed", 0, matrix=shear),
                NodeAsset("bone", 0),
                NodeAsset("skin", 0, mesh=MeshRef("a.lmesh", 1, "skin"), joints=[6]),
            ],
        )
        self.scene = Scene.from_asset(self.asset)
        self.scene.instances.add_many([2, 2, 7], [0, 0, 1], [0, 1, 0], [0, 1, 0], np.zeros((3, 3)), np.ones(3))
        self.scene.skins.add(7, [6], np.eye(4)[None], [1.0])
        self.scene.update()
        self.residency: Any = None
        self.duration = 0.0


def document() -> Document:
    return Document(Resolved(Path("stage.glb"), Path("stage.scene.json")), FileRuntime())


def state(doc: Document) -> dict[str, Any]:
    """Every stored bit of the scene, as comparable values."""
    s = remember(doc.runtime.scene)
    tables = {n: (t.count, {c: v.tobytes() for c, v in t.columns.items()}) for n, t in s.tables.items()}
    free = {n: t.free for n, t in s.tables.items()}
    skins = {n: v.tobytes() for n, v in s.skins.items()}
    return {
        "tables": tables, "free": free, "names": s.names, "skins": skins, "sources": s.sources,
        "rows": s.row_of_node.tolist(), "selection": doc.selection, "overrides": dict(doc.overrides),
        "world": doc.runtime.scene.nodes.world[doc.runtime.scene.nodes.alive].tobytes(),
    }  # fmt: skip


def without_view(values: dict[str, Any]) -> dict[str, Any]:
    """Without what is no part of the document's content: the selection, and values noted for saving."""
    return {k: v for k, v in values.items() if k not in {"selection", "overrides"}}


def act(doc: Document, kind: str, seed: int) -> None:
    """One random edit that is possible now."""
    rng = np.random.default_rng(seed)
    scene = doc.runtime.scene
    alive = np.flatnonzero(scene.nodes.alive)
    if kind in {"undo", "redo"}:
        getattr(doc.history, kind)()
        return
    if not len(alive):
        structure.add_empty(doc, np.eye(4))
        return
    rows = [int(r) for r in rng.choice(alive, min(len(alive), 1 + seed % 3), replace=False)]
    if kind == "structure":
        name = sorted(("add", "light", "delete", "duplicate", "group", "reparent"))[seed % 6]
        if name == "add":
            structure.add_empty(doc, np.eye(4), rows[0])
        elif name == "light":
            structure.add_light(doc, np.eye(4), LightAsset("point"), rows[0])
        elif name == "reparent":
            try:
                structure.reparent(doc, rows[:1], rows[-1] if len(rows) > 1 else -1)
            except InputError:
                return
        elif name != "duplicate" or len(alive) < 60:
            {"delete": structure.delete, "duplicate": structure.duplicate, "group": structure.group}[name](doc, rows)
    elif kind == "move":
        doc.edit("nodes", "translation", rows, [tuple(rng.normal(size=3)) for _ in rows], gesture=seed % 2 or None)
    elif kind == "hide":
        doc.edit("nodes", "visible", rows, [bool(seed % 2)] * len(rows))
    elif kind == "name":
        doc.edit("nodes", "name", rows, [f"n{seed}"] * len(rows))
    else:
        lights = np.flatnonzero(scene.lights.alive)
        if len(lights):
            doc.edit("lights", "intensity", [int(lights[0])], [float(seed)])
