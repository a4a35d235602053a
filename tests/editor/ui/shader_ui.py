"""Shaders edited, broken and mended in a real window: `shader_ui.py FOLDER`; run by test_shader_window.py."""

from __future__ import annotations

import json
import os
import shutil
import sys
import time
import traceback
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
from imgui_bundle import hello_imgui, imgui, immapp  # noqa: E402  (needs the path above)
from imgui_bundle.immapp import testing  # noqa: E402  (needs the path above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)

from editor.app import App  # noqa: E402  (needs the path above)
from editor.builtin_operations import builtin_operations  # noqa: E402  (needs the path above)
from editor.host import EngineHost  # noqa: E402  (needs the path above)
from editor.preferences import Preferences  # noqa: E402  (needs the path above)
from editor.screenshot import save_window  # noqa: E402  (needs the path above)
from editor.session import Session  # noqa: E402  (needs the path above)
from engine.core.paths import shaders_dir  # noqa: E402  (needs the path above)

FRAG, EFFECT, INCLUDE = "shaders/effects/surface.frag", "shaders/effects/surface.effect.toml", "shaders/lib/brdf.glsl"
SHADE, LAST = "vec3 color = shade(", "vec4(sanitise(color), 1.0)"
#: (mistake, file, what stands there, what is put there)
MISTAKES = (
    ("syntax", FRAG, LAST, "vec4(sanitise(color), 1.0"),
    ("type", FRAG, SHADE, "float color = shade("),
    ("missing include", FRAG, "lib/view.glsl", "lib/veiw.glsl"),
    ("include cycle", INCLUDE, "\n\n", '\n#include "lib/lights.glsl"\n'),
    ("unknown key", EFFECT, "\ndoc = ", "\ndok = "),
)


def run(folder: Path) -> dict[str, Any]:
    scene = write_small_scene(folder)
    shutil.copytree(shaders_dir(), folder / "shaders")
    session = Session(EngineHost(), Preferences(welcome_seen=True, adaptive_resolution=False))
    session.save_preferences = False
    session.select_on_open = "cube"
    app = App(session, builtin_operations(), size=(1200, 750), remember_layout=False)
    session.open(scene)
    seen: dict[str, Any] = {"error": "", "mistakes": {}}

    grabs: list[Any] = []  # pictures asked for (None) and taken: the test runs on a thread without the GL context
    jobs: list[Any] = []  # what must run where the GL context is
    end_frame = app.params.callbacks.post_render_dockable_windows

    def take_pictures() -> None:
        end_frame()
        while jobs:
            jobs.pop(0)()
        if grabs and grabs[-1] is None:
            grabs[-1] = np.array(session.image.pixels())

    app.params.callbacks.post_render_dockable_windows = take_pictures

    def picture(ctx: Any) -> Any:
        ctx.yield_(3)
        grabs.append(None)
        ctx.yield_(2)
        assert grabs[-1] is not None
        return grabs[-1]

    def do(ctx: Any, job: Any) -> None:
        jobs.append(job)
        ctx.yield_(2)

    def write(file: str, text: str) -> None:
        path = folder / file
        path.write_text(text, encoding="utf-8")
        info = path.stat()
        os.utime(path, ns=(info.st_atime_ns, info.st_mtime_ns + 1_000_000))

    def until(ctx: Any, what: Any) -> bool:
        end = time.monotonic() + 20.0
        while not what() and time.monotonic() < end:
            ctx.yield_()
        return bool(what())

    def steps(ctx: Any) -> None:
        opened = until(ctx, lambda: session.document is not None and session.image.frame is not None)
        assert opened, session.ui.error_bar
        document = session.document
        assert document is not None
        do(ctx, lambda: app.ui.operations.run("shader.effect", session))
        ctx.yield_(4)
        front = session.code.front
        assert front is not None
        seen["opened"] = [d.name for d in session.code.documents]
        first = picture(ctx)
        text = front.text

        # through the panel's document: new pixels after the save
        front.put(text.replace(LAST, "vec4(sanitise(color.bgr), 1.0)"))
        seen["unsaved_changes_nothing"] = bool((picture(ctx) == first).all())
        do(ctx, session.save_code)
        swapped = picture(ctx)
        seen["edited"] = float((swapped != first).any(axis=-1).mean())
        front.put(text)
        do(ctx, session.save_code)
        good = picture(ctx)
        seen["restored"] = bool((good == first).all())
        do(ctx, lambda: session.edit("materials", "roughness", (0,), (0.9,)))
        good = picture(ctx)

        for name, file, old, new in MISTAKES:  # by another program, as far as the editor can tell
            sound = (folder / file).read_text(encoding="utf-8")
            assert old in sound, (name, old)
            write(file, sound.replace(old, new, 1))
            came = until(ctx, lambda: bool(session.shaders.problems))
            same = bool((picture(ctx) == good).all())
            problem = session.shaders.problems[0] if came else None
            if problem is not None:
                do(ctx, lambda: app.ui.operations.run("shader.next-error", session))
                ctx.yield_(3)
            where = session.code.front
            said = {
                "same_picture": same, "place": problem.place if problem else "", "badge": session.shaders.badge,
                "message": problem.text if problem else "", "opened": where.name if where else "",
            }  # fmt: skip
            write(file, sound)
            said["mended"] = until(ctx, lambda: not session.shaders.problems)
            said["same_after"] = bool((picture(ctx) == good).all())
            seen["mistakes"][name] = said

        # typed into the text field, undone by its own undo, saved by Ctrl+S, which then is not the scene's
        front = session.code.open(folder / FRAG, 1, 1)
        ctx.yield_(4)
        ctx.key_chars("// typed ")
        ctx.yield_(3)
        seen["typed"] = (front.text.startswith("// typed // The"), front.dirty, document.history.revision)
        ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.z, 9)
        ctx.yield_(3)
        seen["typing_undone"] = (front.text == text, front.dirty, document.history.revision)
        ctx.key_chars("/**/")
        ctx.yield_(2)
        ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.s)
        ctx.yield_(3)
        seen["saved_by_key"] = (
            (folder / FRAG).read_text(encoding="utf-8").startswith("/**/"),
            front.dirty,
            document.dirty,
        )
        front.put(text)
        do(ctx, session.save_code)

        # completion: Ctrl+Space after `m.rough`
        front = session.code.open(folder / FRAG)
        front.put(text.replace("s.metallic = m.metallic;", "s.metallic = m.metallic; m.rough", 1))
        line = front.text[: front.text.index("; m.rough")].count("\n") + 1
        column = len(front.text.split("\n")[line - 1]) + 1
        ctx.yield_(3)
        session.code.cursor = (line, column)
        ctx.yield_(4)
        ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.space)
        ctx.yield_(4)
        seen["completion_open"] = bool(imgui.is_popup_open("", imgui.PopupFlags_.any_popup))
        ctx.key_press(imgui.Key.enter)
        ctx.yield_(4)
        seen["completed"] = front.text.split("\n")[line - 1].endswith("m.roughness")
        front.put(text)
        do(ctx, session.save_code)

        # unsaved changes here, and another program's: nothing is overwritten until the user says which
        front = session.code.open(folder / FRAG)
        front.put(text + "// mine\n")
        write(FRAG, "// theirs\n" + text)
        seen["conflict"] = until(ctx, lambda: front.conflict)
        do(ctx, session.save_code)
        seen["theirs_kept"] = (folder / FRAG).read_text(encoding="utf-8").startswith("// theirs")
        ctx.item_click("//###Shader editor/**/Take theirs")
        ctx.yield_(3)
        seen["took"] = (front.text.startswith("// theirs"), front.dirty, front.conflict)
        front.put(text)
        do(ctx, session.save_code)
        session.undo()
        seen["undone"] = bool((picture(ctx) == first).all())

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
