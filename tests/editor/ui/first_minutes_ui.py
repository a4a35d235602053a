"""The first five minutes of a new user in a real window: `first_minutes_ui.py FOLDER`; a picture after each step.

Run by test_first_minutes.py, and by `python -m tests.tools.tour`, which makes the tour of it.
"""

from __future__ import annotations

import ctypes
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
from imgui_bundle import imgui  # noqa: E402  (the path is set above)
from window_run import WindowRun  # noqa: E402  (needs the path above)

from editor import welcome  # noqa: E402  (needs the path above)
from editor.animating.editing import AnimationEditor  # noqa: E402  (needs the path above)
from editor.as_command import render_command  # noqa: E402  (needs the path above)
from editor.panels.blend_space import make_blend  # noqa: E402  (needs the path above)
from engine.assets.samples.sample import make_sample, write_sample  # noqa: E402  (needs the path above)
from importers.cli.main import main as lucarna  # noqa: E402  (needs the path above)

SIZE = (1280, 800)
#: (key, debug view)
VIEWS = (("3", "normal"), ("4", "roughness"))
LAST = "vec4(sanitise(color), 1.0)"


class FirstMinutes:
    """One walk; `seen` is what the test looks at."""

    def __init__(self, folder: Path) -> None:
        self.seen: dict[str, Any] = {"error": ""}
        write_sample(make_sample("walker"), folder / "scene")
        (folder / "model").mkdir(parents=True)
        scene, model = folder / "scene/walker.scene.json", folder / "model/walker.glb"
        assert lucarna(["export", str(scene), "--out", str(model)]) == 0
        self.model = folder / "model"
        self.start = time.perf_counter()
        self.run = WindowRun(folder, size=SIZE)
        session = self.run.session
        session.settings.samples = 1
        session.preferences.welcome_seen = False
        welcome.greet(session)

    def steps(self, run: WindowRun) -> None:
        self.welcome()
        self.drop_a_folder()
        self.look_through_the_views()
        self.turn_the_light()
        self.compare()
        self.break_and_mend_a_shader()
        self.blend_two_clips()
        self.copy_as_command()

    def key(self, chord: Any) -> None:
        self.run.ctx.key_press(chord)
        self.run.ctx.yield_(3)

    def welcome(self) -> None:
        """A window with something that moves in it, and one card."""
        run, session = self.run, self.run.session
        self.seen["window_seconds"] = time.perf_counter() - self.start
        assert run.until(lambda: session.document is not None and session.image.frame is not None), session.ui.error_bar
        self.seen["sample_seconds"] = time.perf_counter() - self.start
        self.seen["animated"] = session.playback.available
        first = run.picture()
        session.seek(session.playback.duration * 0.25)
        self.seen["moves"] = bool((run.picture() != first).any())
        run.shot("welcome")
        self.seen["card"] = session.ui.welcome
        run.ctx.item_click("//###welcome/Blender")
        self.seen["keymap"] = session.preferences.keymap
        run.ctx.item_click("//###welcome/Industry")
        self.key(imgui.Key.escape)
        self.seen["card_again"] = session.ui.welcome or not session.preferences.welcome_seen

    def drop_a_folder(self) -> None:
        run, session = self.run, self.run.session
        sample = session.document
        if run.app._drop is not None:  # as the window library calls it
            run.do(lambda: run.app._drop(0, 1, (ctypes.c_char_p * 1)(os.fsencode(self.model))))
        else:
            run.do(lambda: session.open(self.model))
        assert run.until(lambda: session.job is None and session.document not in (None, sample)), session.ui.error_bar
        session.playback.playing = False
        session.seek(0.3)
        run.until(lambda: session.image.frame is not None and session.image.compiling is None)
        assert session.document is not None
        self.seen["dropped"] = session.document.source.name
        self.seen["import_card"] = session.ui.import_card
        run.shot("dropped")
        session.ui.import_card = False

    def look_through_the_views(self) -> None:
        run, session = self.run, self.run.session
        self.lit = run.picture()
        self.seen["views"] = []
        for key, view in VIEWS:
            self.key(getattr(imgui.Key, f"_{key}"))
            differs = float((run.picture() != self.lit).any(axis=-1).mean())
            self.seen["views"].append((session.settings.values()["view"] == view, differs))
            if view == "normal":
                run.shot("view-normals")
        self.key(imgui.Key._1)
        self.seen["lit_again"] = bool((run.picture() == self.lit).all())

    def turn_the_light(self) -> None:
        run, session, ctx = self.run, self.run.session, self.run.ctx
        x, y, width, height = run.panel("Viewport").area
        ctx.key_down(imgui.Key.mod_shift)
        ctx.mouse_move_to_pos((x + 0.3 * width, y + 0.3 * height))
        ctx.mouse_down(1)
        ctx.mouse_move_to_pos((x + 0.6 * width, y + 0.3 * height))
        ctx.mouse_up(1)
        ctx.key_up(imgui.Key.mod_shift)
        ctx.yield_(3)
        self.seen["turned"] = session.settings.values()["environment_rotation"]
        assert session.document is not None
        self.seen["turn_entries"] = [e.describe() for e in session.document.history.entries]
        run.shot("light-turned")

    def compare(self) -> None:
        """The state before against this one: hold a key, then wipe."""
        run, session, ctx = self.run, self.run.session, self.run.ctx
        comparing = session.comparing
        ctx.key_down(imgui.Key.backslash)
        ctx.yield_(3)
        shown = comparing.shown_moment(session)
        self.seen["held"] = shown is not None and bool((shown.pixels == self.lit).all())
        ctx.key_up(imgui.Key.backslash)
        ctx.yield_(2)
        self.seen["let_go"] = comparing.held
        ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.backslash)
        session.apply_settings({"exposure": 0.7, "tone_map": "agx"}, label="Another look")
        self.key(imgui.Key.mod_shift | imgui.Key.backslash)
        x, y, width, height = run.panel("Viewport").area
        ctx.mouse_move_to_pos((x + 0.5 * width, y + 0.8 * height))
        ctx.mouse_down(0)
        ctx.mouse_move_to_pos((x + 0.4 * width, y + 0.8 * height))
        ctx.mouse_up(0)
        run.until(lambda: comparing.flip is not None)
        self.seen["split"], self.seen["flip"] = comparing.split, comparing.flip
        run.shot("wiped")
        self.key(imgui.Key.mod_shift | imgui.Key.backslash)
        session.undo()

    def break_and_mend_a_shader(self) -> None:
        run, session = self.run, self.run.session
        assert session.document is not None
        session.document.select(next(r for r, n in enumerate(session.document.runtime.scene.nodes.name) if n == "body"))
        run.do(lambda: run.app.ui.operations.run("shader.effect", session))
        run.ctx.yield_(4)
        run.do(session.copy_code_into_project)
        good = run.picture()
        front = session.code.front
        assert front is not None
        text = front.text
        front.put(text.replace(LAST, "vec4(sanitise(colour), 1.0)"))
        run.do(session.save_code)
        run.until(lambda: session.shaders.problems)
        self.seen["problem"] = str(session.shaders.problems[0].text) if session.shaders.problems else ""
        self.seen["last_good_stays"] = bool((run.picture() == good).all())
        run.do(lambda: run.app.ui.operations.run("shader.next-error", session))
        run.ctx.yield_(4)
        run.shot("shader-broken")
        front.put(text)
        run.do(session.save_code)
        run.until(lambda: not session.shaders.problems)
        self.seen["mended"] = not session.shaders.problems and bool((run.picture() == good).all())

    def blend_two_clips(self) -> None:
        run, session, ctx = self.run, self.run.session, self.run.ctx
        run.do(lambda: run.app.ui.operations.run("layout.animate", session))
        ctx.yield_(6)
        run.do(lambda: make_blend(AnimationEditor(session), ["walk", "run"], 1))
        session.ui.focus_panel = "Blend space"
        ctx.yield_(6)
        before = run.picture()
        x, y, width, height = run.panel("Blend space").area
        ctx.mouse_move_to_pos((x + 0.1 * width, y + 0.8 * height))
        ctx.mouse_down(0)
        ctx.mouse_move_to_pos((x + 0.55 * width, y + 0.8 * height))
        ctx.mouse_up(0)
        self.seen["blended"] = float((run.picture() != before).any(axis=-1).mean())
        run.shot("blended")

    def copy_as_command(self) -> None:
        run, session = self.run, self.run.session
        wanted: list[str] = []
        run.do(lambda: wanted.append(render_command(session)))
        self.key(imgui.Key.mod_ctrl | imgui.Key.mod_shift | imgui.Key.c)
        copied: list[str] = []
        run.do(lambda: copied.append(imgui.get_clipboard_text()))
        self.seen["command"], self.seen["command_is_it"] = copied[0], copied == wanted
        run.shot("command-copied")


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    walk = FirstMinutes(folder)
    walk.run.play(walk.steps)
    walk.seen["error"], walk.seen["shots"] = walk.run.error, walk.run.shots
    walk.seen["distinct"] = int(np.unique(walk.lit.reshape(-1, 4), axis=0).shape[0]) if hasattr(walk, "lit") else 0
    sys.stdout.write("\n" + json.dumps(walk.seen) + "\n")
