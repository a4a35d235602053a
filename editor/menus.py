"""The menu bar and the status bar, both made from the operations."""

from __future__ import annotations

from pathlib import Path

from imgui_bundle import hello_imgui, imgui

from editor import icons, numbers, theme
from editor.keys import shown_shortcut
from editor.live_hints import live_hints
from editor.operations import Operation
from editor.strings import tr
from editor.tasks import Task, running
from editor.ui import Ui
from editor.widgets import cut, em, text, tooltip

MENUS = ("File", "Edit", "Add", "View", "Compare", "Playback", "Shaders", "Window", "Help")


def draw_menu_bar(ui: Ui) -> None:
    for name in MENUS:
        if imgui.begin_menu(name):
            for operation in ui.operations.menu(name):
                _item(ui, operation)
                if operation.id == "file.open":
                    _recent(ui)
            if name == "Window":
                _panels()
            imgui.end_menu()
    _title(ui)


def _item(ui: Ui, operation: Operation) -> None:
    if operation.separator:
        imgui.separator()
    label, session = operation.label, ui.session
    if session.document is not None and operation.id in {"edit.undo", "edit.redo"}:
        history = session.document.history
        what = history.undo_label if operation.id == "edit.undo" else history.redo_label
        label = f"{label}: {what}" if what else label
    checked = operation.checked(session) if operation.checked is not None else False
    keys = ui.operations.keys_of(operation)
    key = shown_shortcut(keys[0]) if keys else ""
    if imgui.menu_item(f"{label}###{operation.id}", key, checked, operation.enabled(session))[0]:
        ui.operations.attempt(operation.id, session)
    if operation.doc:
        tooltip(operation.doc)


def _recent(ui: Ui) -> None:
    recent = ui.session.preferences.recent
    if imgui.begin_menu("Open recent", bool(recent)):
        for path in recent:
            if imgui.menu_item_simple(f"{Path(path).name}##{path}"):
                ui.session.open(Path(path))
            tooltip(path)
        imgui.end_menu()


def _panels() -> None:
    """Tick boxes for the panels: bring back what was closed."""
    imgui.separator()
    if imgui.begin_menu("Panels"):
        for window in hello_imgui.get_runner_params().docking_params.dockable_windows:
            if window.can_be_closed and imgui.menu_item(window.label, "", window.is_visible)[0]:
                window.is_visible = not window.is_visible
        imgui.end_menu()


def _title(ui: Ui) -> None:
    """In the middle of the bar: what is open, and whether it has unsaved changes."""
    document = ui.session.document
    if document is None:
        return
    title = f"{document.name}{'  •' if document.dirty else ''}"
    x = imgui.get_window_width() * 0.5 - imgui.calc_text_size(title).x * 0.5
    if x > imgui.get_cursor_pos_x() + em(1):
        imgui.set_cursor_pos_x(x)
        text(title, theme.TEXT if document.dirty else theme.DIM)
        tooltip(f"{document.source}\n{'Unsaved changes' if document.dirty else 'No unsaved changes'}")


def _task_list(tasks: list[Task]) -> None:
    """The first of them in the bar; a click shows all, how far they are, and calls them off."""
    first = tasks[0]
    more = f"   (+{len(tasks) - 1})" if len(tasks) > 1 else ""
    done = f"  {first.progress * 100:.0f} %" if first.progress >= 0.0 else ""
    text(f"{icons.WAITING}  {tr(first.title)}{done}{more}", theme.ACCENT)
    tooltip("Click for the list of what goes on")
    if imgui.is_item_clicked():
        imgui.open_popup("tasks")
    if imgui.begin_popup("tasks"):
        for i, task in enumerate(tasks):
            imgui.push_id(i)
            text(tr(task.title))
            if task.text:
                text(task.text, theme.DIM)
            imgui.progress_bar(task.progress if task.progress >= 0.0 else -imgui.get_time(), (em(16), em(0.9)), "")
            if task.cancel is not None:
                imgui.same_line()
                if imgui.small_button("Cancel"):
                    task.cancel()
            imgui.pop_id()
        imgui.end_popup()


def draw_status_bar(ui: Ui) -> None:
    session = ui.session
    counts = session.messages.counts()
    shown = False
    for severity, icon, color in (
        ("error", icons.ERROR, theme.ERROR),
        ("warning", icons.WARNING, theme.WARNING),
    ):
        count = next(n for s, n in counts.items() if s.value == severity)
        if count:
            text(f"{icon} {count}", color)
            tooltip(f"{count} {severity}s in the log")
            imgui.same_line(0, em(0.9))
            shown = True
    found = numbers.report(session)
    if found is not None:
        text(f"{icons.NUMBERS} {numbers.summary(found)}", theme.GOOD if found.first is None else theme.ERROR)
        tooltip("\n".join(found.lines()))
        if imgui.is_item_clicked():
            session.ui.focus_panel = "Numbers"
        imgui.same_line(0, em(0.9))
    tasks = running(session)
    if tasks:
        _task_list(tasks)
    elif session.document is not None:
        io = imgui.get_io()
        held = {name for name, down in (("ctrl", io.key_ctrl), ("shift", io.key_shift), ("alt", io.key_alt)) if down}
        tools = session.tools
        preferences = session.preferences
        now = live_hints(
            preferences.keymap, held, tool=tools.mode, flying=ui.flying, measuring=tools.measuring,
            pointer=preferences.pointer,
        )  # fmt: skip
        line = "     ".join(f"{tr(gesture)}: {tr(what).lower()}" for gesture, what in now)
        device = imgui.calc_text_size(_device_line(ui)).x + em(3)
        text(cut(line, max(imgui.get_content_region_avail().x - device, em(4))), theme.FAINT)
    else:
        text("Ready" if not shown else "", theme.FAINT)
    line = _device_line(ui)
    if line:
        caps = session.device.caps
        imgui.same_line(imgui.get_window_width() - imgui.calc_text_size(line).x - em(1.0))
        text(line, theme.WARNING if caps.software else theme.FAINT)
        tooltip(f"{caps.device}\n{caps.version}")


def _device_line(ui: Ui) -> str:
    """What draws, in a few words; '' before there is a device."""
    if ui.session.device is None:
        return ""
    caps = ui.session.device.caps
    return f"{caps.device.split('(')[0].strip()}{' (software)' if caps.software else ''}"
