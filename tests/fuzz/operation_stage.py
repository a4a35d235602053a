"""What the fuzzer of operations works on: a scene with some of everything, opened by the real engine on a device that
draws nothing, and its content as a hash."""

from __future__ import annotations

import hashlib
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [p for p in (str(ROOT), str(ROOT / "tests" / "editor" / "support")) if p not in sys.path]

from animated_scene import NullHost, write_animated_scene  # noqa: E402  (the path is set above)
from edited_stage import state, without_view  # noqa: E402  (the path is set above)
from small_scene import write_small_scene  # noqa: E402  (the path is set above)

from editor.document import Document  # noqa: E402  (the path is set above)
from editor.host import Resolved  # noqa: E402  (the path is set above)
from editor.preferences import Preferences  # noqa: E402  (the path is set above)
from editor.saving import edited_scene  # noqa: E402  (the path is set above)
from editor.session import Session  # noqa: E402  (the path is set above)
from engine.assets.scene import CameraAsset, LightAsset, MeshRef, NodeAsset  # noqa: E402  (the path is set above)
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
    """The real engine without pictures; opens scene files and nothing else."""

    def __init__(self) -> None:
        self.device = None  # type: ignore[assignment]  # opened below; the fake's is not wanted
        self.runtimes, self.extra_nodes = [], 0

    def resolve(self, path: Path, progress: Any) -> Resolved:
        from engine.core.errors import InputError

        if not path.is_file():
            raise InputError("there is no such file", where=path)
        return Resolved(path, path)


def open_session(folder: Path) -> Session:
    """A session that journals into `folder`/recovery, with nothing open yet."""
    session = Session(StageHost(), Preferences(welcome_seen=True))
    session.save_preferences = False
    session.device = session.host.open_device(False)
    session.recovery_folder = folder / "recovery"
    return session


def open_scene(session: Session, scene: Path) -> Document:
    resolved = Resolved(scene, scene)
    session.adopt(Document(resolved, session.host.open_runtime(session.device, scene)))
    session.playback.playing = False
    assert session.document is not None
    return session.document


def content(document: Document, *, exact: bool) -> str:
    """Hashes of all that the document is: what saving would write, what its materials say, its animation, and with
    `exact` every bit of the scene's tables (which clips move, so not while there are some).

    With LUCARNA_FUZZ_EXPLAIN=FOLDER what is hashed lies there by its hash, to be compared."""
    residency = document.runtime.residency
    materials = []
    for material in range(len(residency.materials.records)):
        record = residency.material(material)
        if residency.materials.base_of(material) != material:
            continue  # what one object says of it; the scene has that, and which number it is drawn with says nothing
        values = {p.name: record.asset.params.get(p.name, p.default) for p in record.effect.params}
        asset = record.asset
        materials.append((material, values, sorted(asset.textures.items()), asset.features, asset.queue))
    runtime = document.runtime
    animation = getattr(runtime, "animation", None)
    parts = {
        "scene": scene_bytes(document),
        "materials": repr(materials).encode(),
        "animation": repr((getattr(animation, "text", ""), runtime.drive, bool(runtime.deck.root_motion))).encode(),
        "bits": repr(_bits(document)).encode() if exact else b"",
    }
    hashes = {name: hashlib.sha256(data).hexdigest()[:12] for name, data in parts.items()}
    explain = os.environ.get("LUCARNA_FUZZ_EXPLAIN")
    for name, data in parts.items() if explain else ():
        (Path(explain or "") / f"{name}-{hashes[name]}").write_bytes(data)
    return " ".join(f"{name}:{value}" for name, value in hashes.items())


def _bits(document: Document) -> Any:
    """Every stored bit of the scene's tables, but of materials that one object has to itself only what they vary."""
    values = without_view(state(document))
    values["sources"] = {row: _plain(node) for row, node in values["sources"].items()}
    table = document.runtime.scene.instances
    base_of = document.runtime.residency.materials.base_of
    values["tables"]["instances"][1]["material"] = [
        base_of(int(m)) if alive and m >= 0 else -1 for m, alive in zip(table.material, table.alive, strict=True)
    ]
    return _ordered(values)


def _plain(node: Any) -> Any:
    """What an object has of its own as a file says it: a colour that was set is a tuple, one that was read a list."""
    if node is None or node.mesh is None or not node.mesh.overrides:
        return node
    said = [{k: list(v) if isinstance(v, tuple) else v for k, v in slot.items()} for slot in node.mesh.overrides]
    return replace(node, mesh=replace(node.mesh, overrides=said))


def _ordered(value: Any) -> Any:
    """Dictionaries by their keys: in which order they were filled says nothing."""
    return {k: _ordered(value[k]) for k in sorted(value, key=repr)} if isinstance(value, dict) else value


def scene_bytes(document: Document) -> bytes:
    """The scene file that saving would write."""
    return format_scene(edited_scene(document.runtime, document.overrides)).encode()
