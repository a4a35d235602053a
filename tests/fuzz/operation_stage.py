"""What the fuzzer of operations works on: a scene with some of everything, opened by the real engine on a device that
draws nothing, and its content as a hash."""

from __future__ import annotations

import hashlib
import sys
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
    """A hash of all that the document is: what saving would write, what its materials say, and with `exact` every bit
    of the scene's tables (which clips move, so not while there are some)."""
    digest = hashlib.sha256(scene_bytes(document))
    residency = document.runtime.residency
    for material in range(len(residency.materials.records)):
        record = residency.material(material)
        values = {p.name: record.asset.params.get(p.name, p.default) for p in record.effect.params}
        asset = record.asset
        digest.update(repr((material, values, sorted(asset.textures.items()), asset.features, asset.queue)).encode())
    runtime = document.runtime
    animation = getattr(runtime, "animation", None)
    digest.update(repr((getattr(animation, "text", ""), runtime.drive, bool(runtime.deck.root_motion))).encode())
    if exact:
        digest.update(repr(without_view(state(document))).encode())
    return digest.hexdigest()[:16]


def scene_bytes(document: Document) -> bytes:
    """The scene file that saving would write."""
    return format_scene(edited_scene(document.runtime, document.overrides)).encode()
