"""The sample project in a real window: a slider dragged, shaders edited, broken, mended, all undone. After each step a
screenshot lies in FOLDER:  xvfb-run -a python tests/editor/ui/shader_ui.py FOLDER    (run by test_shader_window.py)
"""

from __future__ import annotations

import json
import os
import shutil
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

from imgui_bundle import imgui  # noqa: E402  (the path is set above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)
from window_run import WindowRun  # noqa: E402  (needs the path above)

from engine.app.project import new_project  # noqa: E402  (needs the path above)
from engine.core.paths import shaders_dir  # noqa: E402  (needs the path above)

FRAG, EFFECT, INCLUDE = "effects/surface.frag", "effects/surface.effect.toml", "lib/brdf.glsl"
SHADE, LAST = "vec3 color = shade(", "vec4(sanitise(color), 1.0)"
#: (mistake, file, what stands there, what is put there)
MISTAKES = (
    ("syntax", FRAG, LAST, "vec4(sanitise(color), 1.0"),
    ("type", FRAG, SHADE, "float color = shade("),
    ("missing include", FRAG, "lib/view.glsl", "lib/veiw.glsl"),
    ("include cycle", INCLUDE, "\n\n", '\n#include "lib/lights.glsl"\n'),
    ("unknown key", EFFECT, "\ndoc = ", "\ndok = "),
    ("not finite", FRAG, LAST, "vec4(log(-dot(color, color) - 1.0))"),
)
#: what is selected, and a parameter of its material
NODE, PARAM = "walnut plate", "base_color"


class ShaderRun:
    """The steps, each on its own; `seen` is what the test looks at."""

    def __init__(self, folder: Path) -> None:
        self.seen: dict[str, Any] = {"error": "", "mistakes": {}}
        self.project = folder / "project"
        if self.project.exists():
            shutil.rmtree(self.project)
        new_project(self.project)
        self.shaders = self.project / "shaders"
        shutil.copytree(shaders_dir(), self.shaders)
        self.run = WindowRun(folder, size=(1120, 720))
        self.run.session.select_on_open = NODE
        self.run.session.settings.samples = 1
        self.run.session.settings.shadows = False
        self.run.session.open(self.project)

    def steps(self, run: WindowRun) -> None:
        session = run.session
        opened = run.until(lambda: session.document is not None and session.image.frame is not None)
        assert opened, session.ui.error_bar
        session.playback.playing = False
        session.seek(0.0)
        self.first = run.picture()
        run.shot("opened")
        self.drag_a_slider()
        self.edit_the_text()
        for name, file, old, new in MISTAKES:
            self.make_a_mistake(name, file, old, new)
        self.type_and_undo()
        self.complete()
        self.search()
        self.edit_on_both_sides()
        self.undo_everything()
        self.open_what_never_compiled()

    def drag_a_slider(self) -> None:
        run, session = self.run, self.run.session
        assert session.document is not None
        before = session.document.history.revision
        run.ctx.item_drag_with_delta("//###Inspector/**/roughness/##value", (-90, 0))
        run.ctx.yield_(2)
        self.good = run.picture()
        entries = session.document.history.entries
        self.seen["dragged"] = (len(entries), session.document.history.revision > before + 1, entries[-1].describe())
        self.seen["drag_shows"] = bool((self.good != self.first).any())
        run.shot("slider-dragged")

    def edit_the_text(self) -> None:
        run, session = self.run, self.run.session
        run.do(lambda: run.app.ui.operations.run("shader.effect", session))
        run.ctx.yield_(6)
        front = session.code.front
        assert front is not None
        self.seen["opened"] = [d.name for d in session.code.documents]
        self.text = front.text
        self.good = run.picture()
        run.shot("text-opened")
        front.put(self.text.replace(LAST, "vec4(sanitise(color.bgr), 1.0)"))
        self.seen["unsaved_changes_nothing"] = bool((run.picture() == self.good).all())
        run.do(session.save_code)
        self.seen["edited"] = float((run.picture() != self.good).any(axis=-1).mean())
        run.shot("text-edited")
        front.put(self.text)
        run.do(session.save_code)
        self.seen["restored"] = bool((run.picture() == self.good).all())

    def make_a_mistake(self, name: str, file: str, old: str, new: str) -> None:
        """By another program, as far as the editor can tell."""
        run, session = self.run, self.run.session
        path = self.shaders / file
        sound = path.read_text(encoding="utf-8")
        assert old in sound, (name, old)
        run.write(path, sound.replace(old, new, 1))
        came = run.until(lambda: bool(session.shaders.problems))
        same = bool((run.picture() == self.good).all())
        problem = session.shaders.problems[0] if came else None
        if problem is not None:
            run.do(lambda: run.app.ui.operations.run("shader.next-error", session))
            run.ctx.yield_(3)
        front = session.code.front
        said = {
            "same_picture": same, "place": problem.place if problem else "", "badge": session.shaders.badge,
            "message": problem.text if problem else "", "opened": front.name if front else "",
        }  # fmt: skip
        run.shot(f"broken-{name.replace(' ', '-')}")
        run.write(path, sound)
        said["mended"] = run.until(lambda: not session.shaders.problems)
        said["same_after"] = bool((run.picture() == self.good).all())
        self.seen["mistakes"][name] = said
        run.shot(f"mended-{name.replace(' ', '-')}")

    def type_and_undo(self) -> None:
        """Typed into the text field, undone by its own undo, saved by Ctrl+S, which then is not the scene's."""
        run, session, document = self.run, self.run.session, self.run.session.document
        assert document is not None
        front = session.code.open(self.shaders / FRAG, 1, 1)
        run.ctx.yield_(4)
        run.ctx.key_chars("// typed ")
        run.ctx.yield_(3)
        self.seen["typed"] = (front.text.startswith("// typed // The"), front.dirty, document.history.revision)
        run.ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.z)
        run.ctx.yield_(3)
        self.seen["typing_undone"] = (front.text == self.text, front.dirty, document.history.revision)
        run.ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.y)
        run.ctx.yield_(3)
        self.seen["typing_redone"] = front.text.startswith("// typed // The")
        run.ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.z)
        run.ctx.yield_(3)
        run.ctx.key_chars("/**/")
        run.ctx.yield_(2)
        run.ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.s)
        run.ctx.yield_(3)
        written = (self.shaders / FRAG).read_text(encoding="utf-8").startswith("/**/")
        self.seen["saved_by_key"] = (written, front.dirty, document.dirty)
        front.put(self.text)
        run.do(session.save_code)

    def complete(self) -> None:
        """Ctrl+Space after `m.ro`, more typed while the list is open, Enter."""
        run, session = self.run, self.run.session
        front = session.code.open(self.shaders / FRAG)
        front.put(self.text.replace("s.metallic = m.metallic;", "s.metallic = m.metallic; m.ro", 1))
        line = front.text[: front.text.index("; m.ro")].count("\n") + 1
        run.ctx.yield_(3)
        session.code.cursor = (line, len(front.text.split("\n")[line - 1]) + 1)
        run.ctx.yield_(4)
        run.ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.space)
        run.ctx.yield_(4)
        self.seen["completion_open"] = bool(imgui.is_popup_open("", imgui.PopupFlags_.any_popup))
        run.ctx.key_chars("ug")
        run.ctx.yield_(3)
        self.seen["narrowed"] = front.text.split("\n")[line - 1].endswith("m.roug")
        run.shot("completion")
        run.ctx.key_press(imgui.Key.enter)
        run.ctx.yield_(4)
        self.seen["completed"] = front.text.split("\n")[line - 1].endswith("m.roughness")
        front.put(self.text)
        run.do(session.save_code)

    def search(self) -> None:
        run, session = self.run, self.run.session
        run.do(lambda: run.app.ui.operations.run("shader.find", session))
        run.ctx.yield_(4)
        front = session.code.front
        assert front is not None
        run.ctx.key_chars("s.emission")
        run.ctx.yield_(2)
        run.ctx.key_press(imgui.Key.enter)
        run.ctx.yield_(3)
        run.ctx.item_input_value("//###Shader editor/**/##replace", "s.glow")
        run.shot("find-and-replace")
        run.ctx.item_click("//###Shader editor/**/All")
        run.ctx.yield_(3)
        self.seen["replaced"] = front.text == self.text.replace("s.emission", "s.glow") != self.text
        field = run.panel("Shader editor").fields[front.path]
        run.do(field.editor.undo)
        self.seen["replacing_undone"] = front.text == self.text
        run.ctx.item_click("//###Shader editor/**/###close")
        run.ctx.yield_(3)

    def edit_on_both_sides(self) -> None:
        """Unsaved changes here, and another program's: nothing is overwritten until the user says which."""
        run, session = self.run, self.run.session
        front = session.code.open(self.shaders / FRAG)
        front.put(self.text.replace("vec3 color = s.emission;", "vec3 color = 2.0 * s.emission;") + "// mine\n")
        run.write(self.shaders / FRAG, "// theirs\n" + self.text)
        self.seen["conflict"] = run.until(lambda: front.conflict)
        run.do(session.save_code)
        self.seen["theirs_kept"] = (self.shaders / FRAG).read_text(encoding="utf-8").startswith("// theirs")
        run.shot("conflict")
        run.ctx.item_click("//###Shader editor/**/Show difference")
        run.ctx.yield_(4)
        run.shot("difference-side-by-side")
        run.ctx.item_click("//Difference/Side by side")
        run.ctx.yield_(3)
        run.shot("difference-unified")
        run.ctx.item_click("//Difference/Close")
        run.ctx.yield_(2)
        self.seen["still_a_conflict"] = front.conflict
        run.ctx.item_click("//###Shader editor/**/Take theirs")
        run.ctx.yield_(3)
        self.seen["took"] = (front.text.startswith("// theirs"), front.dirty, front.conflict)
        front.put(self.text)
        run.do(session.save_code)

    def undo_everything(self) -> None:
        run, session = self.run, self.run.session
        assert session.document is not None
        for document in list(session.code.documents):
            session.code.close(document)
        window = next(w for w in run.app.params.docking_params.dockable_windows if "Shader editor" in w.label)
        window.is_visible = False  # the viewport is as large as at first again
        while session.document.history.undo_label:
            run.ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.z)
            run.ctx.yield_(2)
        run.until(lambda: session.image.pixels().shape == self.first.shape)
        self.seen["undone"] = bool((run.picture() == self.first).all())
        self.seen["clean"] = not session.document.dirty and not session.shaders.problems
        run.shot("all-undone")

    def open_what_never_compiled(self) -> None:
        """A scene whose effect was never good: magenta, and why."""
        run, session = self.run, self.run.session
        scene = write_small_scene(self.project / "never")
        bad = self.shaders / "effects" / "bad.effect.toml"
        bad.write_text('name = "bad"\nextends = "surface"\n[technique.forward]\nfragment = "effects/bad.frag"\n')
        (bad.parent / "bad.frag").write_text(
            "layout(location = 0) out vec4 o_color;\nvoid main() { o_colour = vec4(1); }\n"
        )
        material = self.project / "never" / "boxes.red.material.toml"
        material.write_text(material.read_text().replace('effect = "surface"', 'effect = "bad"'))
        session.select_on_open = "cube"
        run.do(lambda: session.open(scene))
        run.until(lambda: session.job is None and session.document is not None and session.document.source == scene)
        run.until(lambda: bool(session.shaders.problems))
        pixels = run.picture()
        middle = pixels[pixels.shape[0] // 2 - 20 : pixels.shape[0] // 2 + 20, pixels.shape[1] // 2, :3]
        magenta = bool(((middle[:, 0] > 180) & (middle[:, 1] < 60) & (middle[:, 2] > 180)).any())
        problem = session.shaders.problems[0] if session.shaders.problems else None
        self.seen["never"] = (magenta, session.shaders.badge, problem.place if problem else "")
        run.shot("never-compiled")


def main(folder: Path) -> dict[str, Any]:
    os.environ.setdefault("LUCARNA_CACHE", str(folder / "cache"))
    os.environ.setdefault("LUCARNA_CONFIG", str(folder / "config"))
    steps = ShaderRun(folder)
    steps.run.play(steps.steps)
    return {**steps.seen, "error": steps.run.error, "shots": [steps.run.path(name).name for name in steps.run.shots]}


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(main(Path(sys.argv[1]).resolve())) + "\n")
