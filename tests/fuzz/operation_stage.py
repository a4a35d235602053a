"""What the fuzzer of operations works on: a scene with some of everything, opened by the real engine on a device that
draws nothing, and its content as a hash."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [p for p in (str(ROOT), str(ROOT / "tests" / "editor" / "support")) if p not in sys.path]

from animated_scene import NullHost, write_animated_scene  # noqa: E402  (the path is set above)
from edited_stage import state, without_view  # noqa: E402  (the path is set above)
from small_scene import write_small_scene  # noqa: E402  (the path is set above)
from small_source import write_small_source  # noqa: E402  (the path is set above)

from editor.document import Document  # noqa: E402  (the path is set above)
from editor.host import EngineHost, Resolved  # noqa: E402  (the path is set above)
from editor.preferences import Preferences  # noqa: E402  (the path is set above)
from editor.saving import current_scene, edited_scene  # noqa: E402  (the path is set above)
from editor.session import Session  # noqa: E402  (the path is set above)
from engine.assets.scene import CameraAsset, LightAsset, MeshRef, NodeAsset, SceneAsset  # noqa: E402  (the path is set above)
from engine.assets.scene_json import format_scene, read_scene, write_scene  # noqa: E402  (the path is set above)

SHEAR = (1.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.1, 0.2, 0.3, 1.0)


def write_stage(folder: Path, *, animated: bool) -> Path:
    """Write the scene with its files, where it is not there yet. `animated`: with clips, a skin and a morph target."""
    write = write_animated_scene if animated else write_small_scene
    path = folder / ("figure.scene.json" if animated else "boxes.scene.json")
    if path.is_file():
        return path
    assert write(folder) == path
    if animated:
        write_small_scene(folder)
    asset = read_scene(path)
    box = MeshRef("boxes.lmesh", 0, "box", ["boxes.red.material.toml"])
    asset.nodes += [
        NodeAsset("skewed", 0, matrix=SHEAR, mesh=box),
        NodeAsset("sun", -1, light=LightAsset("directional", intensity=3.0)),
        NodeAsset("eye", 0, (0.0, 1.0, 5.0), camera=CameraAsset(yfov=0.6)),
        NodeAsset("böx 木", len(asset.nodes), mesh=box),
    ]
    write_scene(path, asset)
    return path


class StageHost(NullHost):
    """The real engine without pictures; opens scene files and sources."""

    def __init__(self) -> None:
        self.device = None  # type: ignore[assignment]  # opened below; the fake's is not wanted
        self.runtimes, self.extra_nodes = [], 0

    def resolve(self, path: Path, progress: Any) -> Resolved:
        if path.name.endswith(".scene.json") and path.is_file():
            return Resolved(path, path)
        return EngineHost().resolve(path, progress)


def open_session(folder: Path) -> Session:
    """A session that journals into `folder`/recovery, with nothing open yet."""
    session = Session(StageHost(), Preferences(welcome_seen=True, reimport=False))  # asked for by an operation
    session.save_preferences = False
    session.device = session.host.open_device(False)
    session.recovery_folder = folder / "recovery"
    return session


def write_source(folder: Path) -> Path:
    """Write a source, where it is not there yet: what is imported and may be imported again."""
    path = folder / "crate.gltf"
    return path if path.is_file() else write_small_source(path)


def scene_of(folder: Path) -> Path:
    """The scene or source that was written there."""
    names = ("crate.gltf", "figure.scene.json", "boxes.scene.json")
    return next(path for name in names if (path := folder / name).is_file())


def opened(session: Session, path: Path) -> Document:
    """A document of that scene or source, in no tab yet."""
    resolved = session.host.resolve(path, lambda text, share: None)
    return Document(resolved, session.host.open_runtime(session.device, resolved.scene))


def content(document: Document, *, exact: bool) -> str:
    """Hashes of all that the document is: what saving would write, what its materials say, its animation, and with
    `exact` every bit of the scene's tables (which clips move, so not while there are some).

    With LUCARNA_FUZZ_EXPLAIN=FOLDER what is hashed lies there by its hash, to be compared."""
    runtime = document.runtime
    animation = getattr(runtime, "animation", None)
    parts = {
        "scene": scene_bytes(document),
        "materials": repr(_materials(document)).encode(),
        "animation": repr((getattr(animation, "text", ""), runtime.drive, bool(runtime.deck.root_motion))).encode(),
        "bits": repr(_bits(document)).encode() if exact else b"",
    }
    hashes = {name: hashlib.sha256(data).hexdigest()[:12] for name, data in parts.items()}
    explain = os.environ.get("LUCARNA_FUZZ_EXPLAIN")
    for name, data in parts.items() if explain else ():
        (Path(explain or "") / f"{name}-{hashes[name]}").write_bytes(data)
    return " ".join(f"{name}:{value}" for name, value in hashes.items())


def _materials(document: Document) -> Any:
    """What the materials say that are drawn or were edited (one that was loaded for a moment is no content), by their
    files, and what each object shows of its own."""
    edited = {row for name, _column, row in document.overrides if name == "materials"}
    return _said(document.runtime, edited), _shown(document.runtime)


def _said(runtime: Any, more: Collection[int] = ()) -> list[Any]:
    residency = runtime.residency
    said = []
    for material in {residency.materials.base_of(m) for m in {*_drawn(runtime).values(), *more}}:
        record = residency.material(material)
        values = {p.name: record.asset.params.get(p.name, p.default) for p in record.effect.params}
        asset = record.asset
        name = _file_of(residency, material)
        said.append((name, values, sorted(asset.textures.items()), asset.features, asset.queue))
    return sorted(said, key=repr)


def _shown(runtime: Any) -> dict[int, Any]:
    """Instance -> its material's file, and what the object has of its own."""
    residency = runtime.residency
    return {
        row: (_file_of(residency, residency.materials.base_of(m)), sorted(residency.material(m).overrides.items()))
        for row, m in _drawn(runtime).items()
    }


def _drawn(runtime: Any) -> dict[int, int]:
    table = runtime.scene.instances
    return {int(row): int(table.material[row]) for row in table.alive_rows() if table.material[row] >= 0}


def reopened(session: Session, document: Document) -> tuple[Any, Any]:
    """What of the document must be found in the files that it was saved to, and what is."""
    assert document.saved_to is not None
    runtime = session.host.open_runtime(session.device, document.saved_to)
    try:
        return _lasting(document.runtime, current_scene(document)), _lasting(runtime, runtime.asset)
    finally:
        runtime.close()


def _lasting(runtime: Any, asset: SceneAsset) -> Any:
    """What a file keeps, but for references, which are other from another folder."""
    materials = [said for said in _said(runtime) if said[0] != "default"]
    name_of = {-1: ""} | {index: node.name for index, node in enumerate(asset.nodes)}
    nodes = [
        # what an instance has within rounding as its prefab it has as its prefab, and where its parts stand in the
        # order of the file says nothing
        (n.name, name_of[n.parent], *(np.round(part, 6).tolist() for part in (n.translation, n.rotation, n.scale)),
         n.matrix, n.visible, n.camera, bool(n.light), n.weights)
        for n in asset.nodes
    ]  # fmt: skip
    animation = getattr(getattr(runtime, "animation", None), "text", "")
    return materials, sorted(map(repr, _shown(runtime).values())), sorted(nodes, key=repr), animation, asset.look


def _file_of(residency: Any, material: int) -> str:
    return Path(residency.material(material).path).name or "default"


def _bits(document: Document) -> Any:
    """Every stored bit of the scene's tables; of meshes and materials their files, since which number they were given
    when they were loaded says nothing."""
    values = without_view(state(document))
    table, residency = document.runtime.scene.instances, document.runtime.residency
    place = {n: (path.name, i) for path, ids in residency.mesh_files.items() for i, n in enumerate(ids)}
    columns = values["tables"]["instances"][1]
    columns["mesh"] = [place.get(int(m)) if alive else None for m, alive in zip(table.mesh, table.alive, strict=True)]
    del columns["material"]  # what each shows is said of the materials
    return _ordered(values)


def _ordered(value: Any) -> Any:
    """Dictionaries by their keys: in which order they were filled says nothing."""
    return {k: _ordered(value[k]) for k in sorted(value, key=repr)} if isinstance(value, dict) else value


def scene_bytes(document: Document) -> bytes:
    """The scene file that saving would write."""
    return format_scene(edited_scene(document.runtime, document.overrides)).encode()
