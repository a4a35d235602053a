"""The history's pictures, an instance's own values, placed characters and the import card that folds, in a real
window: `instances_window_ui.py FOLDER WIDTHxHEIGHT`. Run by test_instances_window.py."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support"), str(ROOT / "tests" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
from animated_scene import write_animated_scene  # noqa: E402  (needs the path above)
from imgui_bundle import imgui  # noqa: E402  (the path is set above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)
from small_source import write_small_source  # noqa: E402  (needs the path above)
from window_run import WindowRun  # noqa: E402  (needs the path above)


def window(name: str) -> Any:
    return imgui.internal.find_window_by_name(name)


def pictures(run: WindowRun) -> list[float]:
    """How bright the picture after each entry is, the opened state first; -1 where there is none."""
    session, found = run.session, []
    document = session.document
    assert document is not None

    def look() -> None:
        made = {key[1]: picture.texture for key, picture in session.history_pictures._made.items()}
        for entry in (None, *document.history.entries, *document.history.undone):
            texture = made.get(id(entry) if entry is not None else 0)
            with session.device_frame():
                found.append(-1.0 if texture is None else float(np.asarray(texture.read())[..., :3].mean()))

    run.do(look)
    return found


def history(run: WindowRun, seen: dict[str, Any]) -> None:
    """Edits, each with its picture; a drag has one; a click jumps."""
    session = run.session
    document = session.document
    assert document is not None
    ops = run.app.ui.operations
    run.ctx.yield_(6)
    document.select(2)
    run.do(lambda: session.edit("nodes", "scale", (2,), ((0.3, 0.3, 0.3),), label="Shrink the cube"))
    run.ctx.yield_(6)

    def drag() -> None:
        for i in range(4):
            session.edit("nodes", "translation", (2,), ((0.3 * i, 0.4, 0.0),), gesture="drag", label="Drag")

    run.do(drag)
    run.ctx.yield_(6)
    run.do(lambda: ops.run("view.set", session, name="exposure", value=1.5))
    run.ctx.yield_(6)
    session.ui.focus_panel = "History"
    run.ctx.yield_(6)
    seen["pictures"] = pictures(run)
    run.shot("history")
    run.ctx.mouse_move("**/##entry1")
    run.ctx.sleep_no_skip(0.8, 0.1)
    run.shot("hover")
    run.ctx.item_click("**/##entry1")
    run.ctx.yield_(6)
    seen["at"] = len(document.history.entries)
    seen["same"] = pictures(run) == seen["pictures"]
    run.shot("jumped")
    run.do(lambda: ops.run("edit.history", session, entries=3))


def prefab(run: WindowRun, root: Path, seen: dict[str, Any]) -> None:
    """A prefab, an instance that differs, one value given back by its button."""
    session = run.session
    document = session.document
    assert document is not None
    ops, nodes = run.app.ui.operations, document.runtime.scene.nodes
    document.select(0)
    run.do(lambda: ops.run("prefab.make", session))
    place = {"path": root / "prefabs/stage.scene.json", "at": (2.5, 0.0, 0.0)}
    run.do(lambda: ops.run("prefab.place", session, **place))
    names = list(document.runtime.scene.nodes.name)
    cube = max(i for i, name in enumerate(names) if name == "cube")
    run.do(lambda: session.edit("nodes", "translation", (cube,), ((0.0, 0.9, 0.0),), label="Lift the second"))
    run.do(lambda: session.edit("lights", "intensity", (1,), (40.0,)))
    document.select(cube)
    session.frame_all()
    run.ctx.yield_(8)
    run.shot("own-values")
    run.ctx.item_click("**/$$0/###revert")
    run.ctx.yield_(4)
    seen["reverted"] = [round(v, 3) for v in nodes.translation[cube].tolist()]
    seen["label"] = document.history.undo_label
    run.shot("reverted")


def clips(run: WindowRun, root: Path, seen: dict[str, Any]) -> None:
    session = run.session
    document = session.document
    assert document is not None
    ops = run.app.ui.operations
    path = root / "figure/figure.scene.json"
    run.do(lambda: ops.run("prefab.place", session, path=path, at=(-2.0, 0.0, 0.0)))
    run.do(lambda: ops.run("prefab.place", session, path=path, at=(-4.0, 0.0, 0.0)))
    session.playback.playing = False
    session.frame_all()
    session.ui.focus_panel = "Timeline"
    run.ctx.yield_(6)
    before = run.picture()
    run.do(lambda: session.seek(0.3))
    run.ctx.yield_(6)
    seen["moved"] = float((run.picture() != before).any(axis=-1).mean())
    runtime: Any = document.runtime
    seen["clips"] = [clip.name for clip in runtime.clips]
    run.shot("figures")


def card(run: WindowRun, seen: dict[str, Any]) -> None:
    """The card of a source: whole, folded by a selection, brought back by the menu, and how much it covers."""
    session = run.session
    run.ctx.yield_(10)
    found = window("###import-card")
    seen["whole"] = found.size.y
    seen["covers"] = covered(run)
    run.shot("card")
    document = session.document
    assert document is not None
    document.select(0)
    run.ctx.yield_(6)
    seen["line"] = window("###import-card").size.y
    run.shot("folded")
    run.do(lambda: run.app.ui.operations.run("file.import-card", session))
    run.ctx.yield_(6)
    document.select(-1)
    run.ctx.yield_(6)
    seen["by_hand"] = window("###import-card").size.y
    run.shot("by-hand")
    session.preferences.ui_scale, session.ui.scale_changed = 2.0, True
    run.ctx.yield_(10)
    seen["by_hand_at_2"] = covered(run)
    run.shot("by-hand-at-2")
    run.ctx.item_click("//###import-card/–")
    run.ctx.yield_(6)
    seen["line_at_2"] = covered(run)
    run.shot("line-at-2")


def covered(run: WindowRun) -> float:
    """The card's share of the picture."""
    from editor.panels.viewport import ViewportPanel

    _, _, width, height = run.app.panel(ViewportPanel).area
    size = window("###import-card").size
    return float(size.x * size.y / (width * height))


def main(folder: Path, width: int, height: int) -> dict[str, Any]:
    root = folder / "game"
    write_small_scene(root / "scenes")
    write_small_source(root / "assets/crate.gltf")
    write_animated_scene(root / "figure")
    (root / "project.toml").write_text('[project]\nname = "Game"\nstart = "scenes/boxes.scene.json"\n')
    run = WindowRun(folder, size=(width, height))
    seen: dict[str, Any] = {}

    def steps(run: WindowRun) -> None:
        session = run.session
        run.do(lambda: run.app.dropped([root / "scenes/boxes.scene.json"]))
        assert run.until(lambda: session.document is not None and session.image.frame is not None)
        history(run, seen)
        prefab(run, root, seen)
        clips(run, root, seen)
        run.do(lambda: run.app.dropped([root / "assets/crate.gltf"]))
        assert run.until(lambda: len(session.tabs) == 2 and session.image.frame is not None), session.ui.error_bar
        card(run, seen)

    run.play(steps)
    return {**seen, "shots": run.shots, "error": run.error or seen.get("error", "")}


if __name__ == "__main__":
    size = [int(n) for n in sys.argv[2].split("x")] if len(sys.argv) > 2 else [1280, 720]
    sys.stdout.write("\n" + json.dumps(main(Path(sys.argv[1]), *size)) + "\n")
