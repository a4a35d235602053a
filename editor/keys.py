"""Shortcuts as text <-> imgui key chords, and running the operation that a key asks for."""

from __future__ import annotations

from imgui_bundle import imgui

from editor.ui import Ui

_MODIFIERS = {"Ctrl": "ctrl", "Shift": "shift", "Alt": "alt"}
_NAMES = {
    "Space": "space", "Escape": "escape", "Home": "home", "End": "end", "Enter": "enter", "Delete": "delete",
    ",": "comma", ".": "period", "=": "equal", "-": "minus", "PageUp": "page_up", "PageDown": "page_down", "0": "_0",
    "\\": "backslash",
}  # fmt: skip


#: operations whose keys mean something of their own while a text field has the focus
TEXT_FIELDS_OWN = {"edit.undo", "edit.redo", "edit.select-all", "edit.duplicate", "edit.group"}


def chord(shortcut: str) -> int:
    """`Ctrl+Shift+P` as an imgui key chord."""
    *modifiers, key = shortcut.split("+")
    name = _NAMES.get(key, key.lower())
    if key.startswith("Keypad"):
        name = f"keypad{key[6:]}"
    elif key.isdigit():
        name = f"_{key}"
    value = int(getattr(imgui.Key, name))
    for modifier in modifiers:
        value |= int(getattr(imgui.Key, f"mod_{_MODIFIERS[modifier]}"))
    return value


def needs_modifier(shortcut: str) -> bool:
    """Whether a shortcut is a bare key that must not fire while the user types or flies."""
    return "+" not in shortcut and not (shortcut.startswith("F") and shortcut[1:].isdigit())


def run_shortcuts(ui: Ui, *, flying: bool) -> None:
    """Run the operation whose keys were pressed in this frame. Text fields and fly mode keep bare keys."""
    io = imgui.get_io()
    if imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id | imgui.PopupFlags_.any_popup_level):
        return
    for shortcut, operation in ui.operations.shortcuts().items():
        bare = needs_modifier(shortcut)
        if (bare and flying) or (io.want_text_input and (bare or operation in TEXT_FIELDS_OWN)):
            continue
        if imgui.is_key_chord_pressed(chord(shortcut)):
            ui.operations.run(operation, ui.session)
