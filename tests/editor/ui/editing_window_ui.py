"""Editing in a real window with the real renderer: `editing_window_ui.py FOLDER die|restore`.

`die`: add, duplicate and drag with the gizmo, and be killed in the middle of the drag. `restore`: start again, restore
what was left, look at the new panels. Run by test_editing_window.py."""

from __future__ import annotations

import json
import os
import signal
import sys
import traceback
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
from imgui_bundle import hello_imgui, imgui, immapp  # noqa: E402  (needs the path above)
from imgui_bundle.immapp import testing  # noqa: E402  (needs the path above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)

from editor import journal  # noqa: E402  (needs the path above)
from editor.app import App  # noqa: E402  (needs the path above)
from editor.builtin_operations import builtin_operations  # noqa: E402  (needs the path above)
from editor.camera_controls import project  # noqa: E402  (needs the path above)
from editor.host import EngineHost  # noqa: E402  (needs the path above)
from editor.panels.frame_graph import FrameGraphPanel  # noqa: E402  (needs the path above)
from editor.panels.texture_viewer import TextureViewerPanel, list_sources  # noqa: E402  (needs the path above)
from editor.panels.viewport import ViewportPanel  # noqa: E402  (needs the path above)
from editor.preferences import Preferences  # noqa: E402  (needs the path above)
from editor.screenshot import save_window  # noqa: E402  (needs the path above)
from editor.session import Session  # noqa: E402  (needs the path above)


def at(app: App, row: int, x: float = 0.0, y: float = 0.0) -> Any:
    """The window position of a node, moved by a share of the picture's width."""
    left, top, width, height = app.panel(ViewportPanel).area
    document = app.ui.session.document
    assert document is not None
    point = document.runtime.scene.nodes.world_matrix(row)[:3, 3]
    pixels, _depth = project(app.ui.session.camera, point[None], width, height)
    return imgui.ImVec2(left + float(pixels[0, 0]) + x * width, top + float(pixels[0, 1]) + y * width)


def edit_and_die(ctx: Any, app: App, seen: dict[str, Any]) -> None:
    session = app.ui.session
    document = session.document
    assert document is not None
    session.camera = type(session.camera)((0.0, 0.0, 0.0), 0.0, -0.3, distance=5.0)
    operations = app.ui.operations
    document.select(2)
    operations.run("edit.duplicate", session)
    operations.run("add.point-light", session)
    document.select(2)
    ctx.yield_(3)
    start, end = at(app, 2, 0.055), at(app, 2, 0.2)
    ctx.mouse_move_to_pos(start)
    ctx.yield_(5)
    ctx.mouse_down(0)
    ctx.yield_(2)
    ctx.mouse_move_to_pos(end)
    ctx.yield_(3)
    nodes = document.runtime.scene.nodes
    seen["names"] = [n for n in nodes.name if n]
    seen["translation"] = nodes.translation[2].tolist()
    seen["lights"] = document.runtime.scene.lights.alive_count
    seen["drawn"] = int(document.runtime.scene.instances.drawn.sum())
    seen["pixels"] = int(np.asarray(session.image.frame.stats.counters.get("draws", 0)))
    sys.stdout.write("\n" + json.dumps(seen) + "\n")
    sys.stdout.flush()
    os.kill(os.getpid(), signal.SIGKILL)


def restore(ctx: Any, app: App, seen: dict[str, Any]) -> None:
    session = app.ui.session
    ctx.yield_(3)
    seen["asked"] = [r.edits for r in session.ui.recoveries]
    ctx.item_click("//Unsaved edits/Restore")
    for _ in range(200):
        if session.document is not None and session.image.frame is not None:
            break
        ctx.yield_()
    document = session.document
    assert document is not None, session.ui.error_bar
    session.camera = type(session.camera)((0.0, 0.0, 0.0), 0.0, -0.3, distance=5.0)
    ctx.yield_(3)
    nodes = document.runtime.scene.nodes
    seen["names"] = [n for n in nodes.name if n]
    seen["translation"] = nodes.translation[2].tolist()
    seen["lights"] = document.runtime.scene.lights.alive_count
    seen["drawn"] = int(document.runtime.scene.instances.drawn.sum())
    seen["entries"] = [e.describe() for e in document.history.entries]
    seen["image_error"] = session.image.error
    session.ui.focus_panel = "Textures"
    ctx.yield_(5)
    viewer = app.panel(TextureViewerPanel)
    seen["textures"] = [s.name for s in list_sources(session)]
    seen["texture_problem"] = viewer.problem
    seen["texture_colours"] = 0 if viewer.values is None else len(np.unique(viewer.values))
    session.ui.focus_panel = "Viewport"
    ctx.yield_(2)
    session.ui.focus_panel = "History"
    ctx.yield_(2)
    session.ui.focus_panel = "Frame graph"
    document.selection = (2,)
    ctx.mouse_move_to_pos((5, 5))
    ctx.yield_(4)
    boxes = app.panel(FrameGraphPanel).diagram.boxes
    seen["passes"] = [b.name for b in boxes if not b.reason]
    seen["left_out"] = [b.name for b in boxes if b.reason]
    session.ui.focus_panel = "Viewport"
    ctx.yield_(3)
    session.save()
    seen["saved"] = [n.name for n in _read(document.scene_path).nodes]


def _read(path: Path) -> Any:
    from engine.assets.scene_json import read_scene

    return read_scene(path)


def run(folder: Path, what: str) -> dict[str, Any]:
    scene = folder / "boxes.scene.json"
    if not scene.is_file():
        write_small_scene(folder)
    session = Session(EngineHost(), Preferences(welcome_seen=True, adaptive_resolution=False))
    session.save_preferences = False
    session.recovery_folder = journal.recovery_dir()
    app = App(session, builtin_operations(), size=(1300, 800), remember_layout=False)
    if what == "die":
        session.open(scene)
    else:
        session.ui.recoveries = journal.pending()
    seen: dict[str, Any] = {"error": ""}

    def guarded(ctx: Any) -> None:
        try:
            if what == "die":
                for _ in range(600):
                    if session.document is not None and session.image.frame is not None:
                        break
                    ctx.yield_()
                edit_and_die(ctx, app, seen)
            else:
                restore(ctx, app, seen)
        except BaseException:  # an exception must not unwind into the engine's coroutine
            seen["error"] = traceback.format_exc()

    try:
        testing.run(test_function=guarded, runner_params=app.params, add_ons_params=immapp.AddOnsParams())
    except RuntimeError as error:
        seen["error"] = f"{seen['error']}\n{error}"
    save_window(folder / "editing.png", hello_imgui.final_app_window_screenshot())
    return seen


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(run(Path(sys.argv[1]), sys.argv[2])) + "\n")
