"""UI test in a real window with the real renderer: `window_ui.py FOLDER`; run by test_window.py."""

from __future__ import annotations

import ctypes
import json
import os
import sys
import traceback
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
from imgui_bundle import hello_imgui, immapp  # noqa: E402  (needs the path above)
from imgui_bundle.immapp import testing  # noqa: E402  (needs the path above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)

from editor.app import App  # noqa: E402  (needs the path above)
from editor.builtin_operations import builtin_operations  # noqa: E402  (needs the path above)
from editor.host import EngineHost  # noqa: E402  (needs the path above)
from editor.preferences import Preferences  # noqa: E402  (needs the path above)
from editor.screenshot import save_window  # noqa: E402  (needs the path above)
from editor.session import Session  # noqa: E402  (needs the path above)


def difference(a: Any, b: Any) -> float:
    """Share of pixels that differ."""
    return float((np.asarray(a, np.int16) != np.asarray(b, np.int16)).any(axis=-1).mean())


def run(folder: Path) -> dict[str, Any]:
    scene = write_small_scene(folder)
    session = Session(EngineHost(), Preferences(welcome_seen=True, adaptive_resolution=False))
    session.save_preferences = False
    app = App(session, builtin_operations(), size=(1100, 700), remember_layout=False)
    session.open(scene)
    seen: dict[str, Any] = {"error": ""}

    grabs: list[Any] = []  # pictures asked for (None) and taken: the test runs on a thread without the GL context
    end_frame = app.params.callbacks.post_render_dockable_windows

    def take_pictures() -> None:
        end_frame()
        if grabs and grabs[-1] is None:
            grabs[-1] = np.array(session.image.pixels())

    app.params.callbacks.post_render_dockable_windows = take_pictures

    def picture(ctx: Any) -> Any:
        ctx.yield_(3)
        grabs.append(None)
        ctx.yield_(2)
        assert grabs[-1] is not None
        return grabs[-1]

    def steps(ctx: Any) -> None:
        for _ in range(600):
            if session.document is not None and session.image.frame is not None:
                break
            ctx.yield_()
        document = session.document
        assert document is not None, session.ui.error_bar
        ctx.item_click("//###Scene/**/##cube-2")
        ctx.yield_(3)
        assert document.selection == (2,)
        assert not session.image.error, session.image.error
        before = picture(ctx)
        seen["distinct_colours"] = len(np.unique(before.reshape(-1, 4), axis=0))
        renders = session.image.renders
        ctx.yield_(5)
        seen["idle_renders"] = session.image.renders - renders

        ctx.item_drag_with_delta("//###Inspector/**/metallic/##value", (120, 0))
        dragged = picture(ctx)
        seen["dragged"] = difference(before, dragged)
        seen["entries"] = [c.describe() for c in document.history.entries]
        session.undo()
        seen["undone"] = difference(before, picture(ctx))

        ctx.item_click("//###Scene/**/###eye2")
        seen["hidden"] = difference(before, picture(ctx))
        session.undo()
        ctx.yield_(3)

        centre = session.pick(0.5, 0.5)
        seen["picked"] = session.node_name(centre)
        session.edit("nodes", "translation", (2,), ((0.0, 0.4, 0.0),))
        seen["moved"] = difference(before, picture(ctx))
        ctx.item_drag_with_delta("//###Inspector/**/metallic/##value", (120, 0))
        seen["saved"] = session.save()
        seen["dirty"] = document.dirty

        seen["can_drop"] = app._drop is not None
        if app._drop is not None:  # as the window library calls it, on the file's name
            other = write_small_scene(folder / "other")
            app._drop(0, 1, (ctypes.c_char_p * 1)(os.fsencode(other)))
            for _ in range(600):
                if session.job is None and session.document is not document:
                    break
                ctx.yield_()
            seen["dropped"] = session.document is not None and session.document is not document
        ctx.yield_(3)

    def guarded(ctx: Any) -> None:
        try:
            steps(ctx)
        except BaseException:  # an exception must not unwind into the engine's coroutine
            seen["error"] = traceback.format_exc()

    try:
        testing.run(test_function=guarded, runner_params=app.params, add_ons_params=immapp.AddOnsParams())
    except RuntimeError as error:
        seen["error"] = f"{seen['error']}\n{error}"
    save_window(folder / "window.png", hello_imgui.final_app_window_screenshot())
    return seen


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(run(Path(sys.argv[1]))) + "\n")
