"""UI tests of keymap editor, palette with arguments, languages, plug-in windows; run by test_ui_habits.py in a process
of its own."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

from imgui_bundle import imgui  # noqa: E402  (the path is set above)
from ui_harness import fresh, main  # noqa: E402  (needs the path above)

from editor.app import App  # noqa: E402  (needs the path above)
from editor.panels.base import Panel  # noqa: E402  (needs the path above)
from editor.panels.console import ConsolePanel  # noqa: E402  (needs the path above)
from editor.plugins.discovery import Found  # noqa: E402  (needs the path above)
from editor.plugins.manager import Loaded  # noqa: E402  (needs the path above)


def show(ctx: Any, app: App, title: str) -> None:
    app.ui.session.ui.focus_panel = title
    ctx.yield_(4)


def a_key_is_bound_by_pressing_it(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    show(ctx, app, "Preferences")
    ctx.item_input_value("//###Preferences/##keys", "edit.group")
    ctx.yield_(2)
    ctx.item_click("//###Preferences/**/###bind")
    ctx.yield_(2)
    ctx.key_press(imgui.Key.f6)
    ctx.yield_(3)
    assert app.ui.keymap.changes == {"edit.group": ["F6"]}
    document.select(2)
    ctx.key_press(imgui.Key.f6)
    ctx.yield_(2)
    assert [e.describe() for e in document.history.entries] == ["Group lid"]
    ctx.item_click("//###Preferences/**/###reset")
    ctx.yield_(2)
    assert app.ui.keymap.changes == {}


def a_taken_key_is_asked_about(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    show(ctx, app, "Preferences")
    ctx.item_input_value("//###Preferences/##keys", "edit.group")
    ctx.yield_(2)
    ctx.item_click("//###Preferences/**/###bind")
    ctx.yield_(2)
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.d)
    ctx.yield_(2)
    assert app.ui.keymap.changes == {}
    ctx.item_click("//###Preferences/**/###take")
    ctx.yield_(2)
    assert app.ui.keymap.changes == {"edit.group": ["Ctrl+D"], "edit.duplicate": []}
    ctx.item_click("//###Preferences/**/###reset-keys")
    ctx.yield_(2)
    assert app.ui.keymap.changes == {}


def the_palette_asks_for_arguments(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    document.select(2)
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.mod_shift | imgui.Key.p)
    ctx.yield_(2)
    ctx.key_chars("rename to")
    ctx.yield_(2)
    ctx.key_press(imgui.Key.enter)
    ctx.yield_(3)
    ctx.item_click("//###arguments/**/##name")
    ctx.key_chars_replace("cover")
    ctx.item_click("//###arguments/###do")
    ctx.yield_(2)
    assert document.runtime.scene.nodes.name[2] == "cover"
    assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id | imgui.PopupFlags_.any_popup_level)


def languages_are_switched_live(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    windows = {w.label.split("###")[1]: w for w in app.params.docking_params.dockable_windows}
    app.ui.operations.run("help.language-zh", app.ui.session)
    ctx.yield_(3)
    try:
        assert "历史记录" in windows["History"].label
        ctx.item_click("//###Scene/**/##lid-2")
        assert document.selection == (2,)
        ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.d)
        ctx.yield_(2)
        assert len(document.history.entries) == 1
    finally:
        app.ui.operations.run("help.language-en", app.ui.session)
        ctx.yield_(3)
    assert windows["History"].label.endswith("History###History")


def the_console_says_what_was_done(ctx: Any, app: App) -> None:
    document = fresh(ctx, app)
    show(ctx, app, "Console")
    document.select(2)
    ctx.key_press(imgui.Key.mod_ctrl | imgui.Key.d)
    ctx.yield_(3)
    console = app.panel(ConsolePanel).console
    assert console is not None
    assert console.lines[-1].kind == "did"
    assert console.lines[-1].text == "select('lid'); run('edit.duplicate')"


class Broken(Panel):
    title = "Broken"
    dock = "Right"

    def draw(self, ui: Any) -> None:
        imgui.begin_child("left open", (0, 0))
        imgui.begin_group()
        raise ValueError("a plug-in's mistake")


class Good(Panel):
    title = "Good"
    dock = "Right"
    presses = 0

    def draw(self, ui: Any) -> None:
        if imgui.button("Press"):
            Good.presses += 1


def a_broken_panel_closes_and_the_window_goes_on(ctx: Any, app: App) -> None:
    fresh(ctx, app)
    manager = app.plugins
    good, bad = Loaded("good", Found("good"), "on"), Loaded("bad", Found("bad"), "on")
    manager.plugins += [good, bad]
    window = manager.add_window(good, Good())
    broken = manager.add_window(bad, Broken())
    ctx.yield_(4)
    assert bad.state == "failed"
    assert "habits_ui.py" in bad.error
    assert "a plug-in's mistake" in bad.error
    manager.windows.remove(broken)
    ctx.item_click("//###Good/Press")
    assert Good.presses == 1
    ctx.item_click("//###Scene/**/##lid-2")
    show(ctx, app, "Plug-ins")
    manager.windows.remove(window)
    manager.plugins.clear()
    ctx.yield_(2)


TESTS = {
    f.__name__: f
    for f in (
        a_key_is_bound_by_pressing_it,
        a_taken_key_is_asked_about,
        the_palette_asks_for_arguments,
        languages_are_switched_live,
        the_console_says_what_was_done,
        a_broken_panel_closes_and_the_window_goes_on,
    )
}

if __name__ == "__main__":
    main(TESTS)
