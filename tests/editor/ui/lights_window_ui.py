"""Lights in a real window with the real renderer: `lights_window_ui.py FOLDER`; run by test_lights_window.py.

Places every kind, tunes one, gives it a profile by the dialog, breaks and mends its file, scatters drifting lights,
makes a ring, switches the path, looks through the debug views by their keys, undoes it all, redoes and saves it."""

from __future__ import annotations

import json
import sys
import traceback
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

import numpy as np  # noqa: E402  (the path is set above)
from edited_stage import state, without_view  # noqa: E402  (needs the path above)
from imgui_bundle import hello_imgui, imgui, immapp  # noqa: E402  (needs the path above)
from imgui_bundle.immapp import testing  # noqa: E402  (needs the path above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)

from editor.app import App  # noqa: E402  (needs the path above)
from editor.builtin_operations import builtin_operations  # noqa: E402  (needs the path above)
from editor.host import EngineHost  # noqa: E402  (needs the path above)
from editor.panels.lights import LightsPanel  # noqa: E402  (needs the path above)
from editor.preferences import Preferences  # noqa: E402  (needs the path above)
from editor.screenshot import save_window  # noqa: E402  (needs the path above)
from editor.session import Session  # noqa: E402  (needs the path above)
from editor.widgets import pretty  # noqa: E402  (needs the path above)
from engine.assets.lanim import read_lanim  # noqa: E402  (needs the path above)
from engine.assets.scene_json import read_scene  # noqa: E402  (needs the path above)
from engine.render.lighting import PATH_CHOICES  # noqa: E402  (needs the path above)
from engine.scene.lights import LIGHT_TYPES  # noqa: E402  (needs the path above)

IES = "IESNA91\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 10\n0 45 90\n0\n{}\n"
PATHS = ("forward", "deferred", "tiled-deferred", "forward-plus")


def run(folder: Path, show: str) -> dict[str, Any]:
    """`show`: what the last picture of the window shows: a debug view."""
    scene = write_small_scene(folder)
    lamp = folder / "lamp.ies"
    lamp.write_text(IES.format("100 200 0"), encoding="utf-8")
    session = Session(EngineHost(), Preferences(welcome_seen=True, adaptive_resolution=False))
    session.save_preferences = False
    app = App(session, builtin_operations(), size=(1100, 640), remember_layout=False)
    session.open(scene)
    seen: dict[str, Any] = {"error": ""}
    grabs: list[Any] = []
    end_frame = app.params.callbacks.post_render_dockable_windows

    def take_pictures() -> None:
        end_frame()
        if grabs and grabs[-1] is None:
            grabs[-1] = np.array(session.image.pixels())

    app.params.callbacks.post_render_dockable_windows = take_pictures

    def picture(ctx: Any) -> Any:
        ctx.yield_(2)
        grabs.append(None)
        ctx.yield_(2)
        assert grabs[-1] is not None, "the window stopped drawing"
        return grabs[-1].astype(int)

    def choose(ctx: Any, path: str) -> None:
        ctx.item_click("//###Viewport/##path")
        ctx.yield_(4)
        ctx.item_click(f"//##Combo_00/$${PATH_CHOICES.index(path)}/{pretty(path)}")
        ctx.yield_(2)

    def wait_for(ctx: Any, reached: Any, what: str) -> None:
        for _ in range(600):
            if reached():
                return
            ctx.yield_()
        raise AssertionError(what)

    def steps(ctx: Any) -> None:
        wait_for(ctx, lambda: session.document is not None and session.image.frame is not None, "opened")
        document = session.document
        assert document is not None
        lights, nodes = document.runtime.scene.lights, document.runtime.scene.nodes
        before = without_view(state(document))
        seen["lights_before"] = lights.alive_count
        dark = picture(ctx)
        for kind in LIGHT_TYPES:
            ctx.menu_click(f"//##MainMenuBar/Add/###add.{kind}-light")
            ctx.yield_(2)
        seen["placed"] = lights.alive_count - seen["lights_before"]
        seen["placing_shows"] = float(np.abs(picture(ctx) - dark).mean())

        # tune a point light: brightness, temperature, profile
        ctx.menu_click("//##MainMenuBar/Add/###add.point-light")
        ctx.yield_(3)
        row = int(np.flatnonzero(lights.alive & (lights.node == document.primary))[0])
        was = float(lights.intensity[row])
        ctx.item_drag_with_delta(f"//###Inspector/**/brightness{row}/##value", (60, 0))
        seen["brighter"] = float(lights.intensity[row]) / was
        even = picture(ctx)
        ctx.item_click(f"//###Inspector/**/profile{row}/###choose")
        ctx.yield_(4)
        ctx.item_click("//Choose an IES file/**/##lamp.ies")
        ctx.item_click("//Choose an IES file/###accept")
        ctx.yield_(3)
        seen["profile"] = lights.asset(row).profile
        shaped = picture(ctx)
        seen["profile_shows"] = float(np.abs(shaped - even).mean())
        lamp.write_text(IES.format("100 x00 0"), encoding="utf-8")
        wait_for(ctx, lambda: session.shaders.problems, "the broken file was noticed")
        ctx.yield_(3)
        seen["badge"] = session.shaders.badge
        seen["kept"] = float(np.abs(picture(ctx) - shaped).max())
        lamp.write_text(IES.format("100 5 0"), encoding="utf-8")
        wait_for(ctx, lambda: not session.shaders.problems, "the mended file was noticed")
        ctx.yield_(3)
        seen["mended_shows"] = float(np.abs(picture(ctx) - shaped).mean())

        # many at once, drifting; a ring of the lamp
        panel = app.panel(LightsPanel)
        session.ui.focus_panel = "Lights"
        document.selection = ()
        ctx.yield_(3)
        panel.settings.count, panel.settings.drift = 12, 0.3
        ctx.item_click("//###Lights/**/scatterbox/##value")
        ctx.yield_(2)
        panel.settings.box_low, panel.settings.box_high = (-2.0, 0.1, -2.0), (2.0, 1.0, 2.0)
        ctx.item_click("//###Lights/###scatter")
        ctx.yield_(3)
        (top,) = document.selection
        swarm = document.children_of(top)
        places = nodes.world[swarm, :, 3].copy()
        seen["in_box"] = bool(((places >= (-2.4, -0.2, -2.4)) & (places <= (2.4, 1.3, 2.4))).all())
        seen["duration"] = session.playback.duration
        session.seek(4.0)
        ctx.yield_(2)
        seen["drifted"] = float(np.linalg.norm(nodes.world[swarm, :, 3] - places, axis=1).min())
        session.seek(0.0)
        document.select(int(lights.node[row]))
        panel.array.shape, panel.array.count, panel.array.radius = "ring", 6, 1.5
        ctx.yield_(2)
        ctx.item_click("//###Lights/###array")
        ctx.yield_(2)
        seen["ring"] = len(document.selection)
        seen["lights"] = lights.alive_count

        # one picture by every path, from the toolbar
        document.selection = ()
        pictures = {}
        session.ui.focus_panel = "Viewport"
        ctx.yield_(3)
        for path in PATHS:
            choose(ctx, path)
            ctx.yield_(3)  # what is new to the driver is compiled over some frames, in which the last picture stays
            wait_for(ctx, lambda: session.image.compiling is None, "compiled")
            pictures[path] = picture(ctx)
            seen.setdefault("paths", []).append(session.image.frame.path.path)
        seen["paths_differ"] = max(int(np.abs(pictures[p] - pictures["deferred"]).max()) for p in PATHS)
        choose(ctx, "auto")
        ctx.yield_(3)
        seen["auto"] = session.image.frame.path.reason

        # debug views by their keys
        for key in (*range(1, 10), *(f"Shift+{k}" for k in range(1, 10))):
            chord = getattr(imgui.Key, f"_{str(key)[-1]}")
            ctx.mouse_move_to_pos((650, 5))
            ctx.key_press(imgui.Key.mod_shift | chord if "Shift" in str(key) else chord)
            ctx.yield_(3)
            frame = session.image.frame
            shown = picture(ctx)
            legend = frame.legend.heading if frame.legend is not None else ""
            seen.setdefault("views", {})[str(session.settings.view)] = [legend, float(shown[..., :3].std())]
        session.settings.view = "lit"

        # everything back, and forth
        entries = len(document.history.entries)
        seen["entries"] = [e.describe() for e in document.history.entries]
        for _ in range(entries):
            ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.z)
            ctx.yield_(2)
        after = without_view(state(document))
        seen["restored"] = [k for k in before if before[k] != after[k]]
        seen["drifting_after_undo"] = len(document.runtime.beside)
        for _ in range(entries):
            session.redo()
        ctx.yield_(3)
        seen["again"] = lights.alive_count
        session.save(folder / "lit.scene.json")
        made = read_scene(folder / "lit.scene.json")
        seen["saved"] = {
            "lights": sum(n.light is not None for n in made.nodes), "clips": made.clips,
            "moves": len(read_lanim(folder / made.clips[-1]).channels),
        }  # fmt: skip
        document.select(int(lights.node[row]))
        session.preferences.show_lights = True
        session.settings.view = show
        session.ui.focus_panel = "Lights" if show != "lit" else "Inspector"
        ctx.mouse_move_to_pos((5, 5))
        ctx.yield_(4)

    def guarded(ctx: Any) -> None:
        io = imgui.test_engine.get_io(hello_imgui.get_imgui_test_engine())
        io.config_run_speed = imgui.test_engine.TestRunSpeed.fast
        io.config_watchdog_kill_test = 240.0
        try:
            steps(ctx)
        except BaseException:  # an exception must not unwind into the engine's coroutine
            seen["error"] = traceback.format_exc()

    try:
        testing.run(test_function=guarded, runner_params=app.params, add_ons_params=immapp.AddOnsParams())
    except RuntimeError as error:
        seen["error"] = f"{seen['error']}\n{error}"
    save_window(folder / "lights.png", hello_imgui.final_app_window_screenshot())
    return seen


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(run(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "depth")) + "\n")
