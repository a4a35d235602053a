"""Shortcuts as text <-> imgui key chords, and running the operation that a key asks for."""

from __future__ import annotations

from functools import cache
from string import ascii_lowercase, ascii_uppercase, digits

from imgui_bundle import imgui

from editor.physical_keys import letter_at
from editor.ui import Ui

_MODIFIERS = {"Ctrl": "ctrl", "Shift": "shift", "Alt": "alt"}
_NAMES = {
    "Space": "space", "Escape": "escape", "Home": "home", "End": "end", "Enter": "enter", "Delete": "delete",
    ",": "comma", ".": "period", "=": "equal", "-": "minus", "PageUp": "page_up", "PageDown": "page_down", "0": "_0",
    "Insert": "insert", "Backspace": "backspace", "Tab": "tab", "Up": "up_arrow", "Down": "down_arrow",
    "Left": "left_arrow", "Right": "right_arrow", "/": "slash", ";": "semicolon", "'": "apostrophe",
    "`": "grave_accent", "[": "left_bracket", "]": "right_bracket",
    "Keypad.": "keypad_decimal", "Keypad/": "keypad_divide", "Keypad*": "keypad_multiply",
    "Keypad-": "keypad_subtract",
    "\\": "backslash",
}  # fmt: skip


#: operations whose keys mean something of their own while a text field has the focus
TEXT_FIELDS_OWN = {"edit.undo", "edit.redo", "edit.select-all", "edit.duplicate", "edit.group"}


@cache
def chord(shortcut: str) -> int:
    """`Ctrl+Shift+P` as an imgui key chord."""
    *modifiers, key = shortcut.split("+")
    name = _NAMES.get(key, key.lower())
    if key.startswith("Keypad") and key not in _NAMES:
        name = f"keypad{key[6:]}"
    elif key.isdigit():
        name = f"_{key}"
    value = int(getattr(imgui.Key, name))
    for modifier in modifiers:
        value |= int(getattr(imgui.Key, f"mod_{_MODIFIERS[modifier]}"))
    return value


def by_place(shortcut: str) -> str:
    """Bare letters, and those with Shift alone, go by their place on the keyboard; `Ctrl+Z` by its letter."""
    *held, key = shortcut.split("+")
    if len(key) != 1 or not key.isalpha() or any(word != "Shift" for word in held):
        return shortcut
    return "+".join([*held, letter_at(key).upper()])


def shown_shortcut(shortcut: str) -> str:
    """As it is written on this keyboard."""
    return by_place(shortcut)


def pressed_shortcut() -> str:
    """The key that was pressed in this frame with what is held, as a shortcut; '' for none or a modifier alone."""
    io = imgui.get_io()
    held = [name for name, down in (("Ctrl", io.key_ctrl), ("Shift", io.key_shift), ("Alt", io.key_alt)) if down]
    for key in _BINDABLE:
        if imgui.is_key_pressed(imgui.Key(chord(key) & ~int(imgui.Key.mod_mask_)), False):
            bare = len(key) == 1 and key.isalpha() and all(word == "Shift" for word in held)
            place = next((p for p in ascii_lowercase if letter_at(p) == key.lower()), key) if bare else key
            return "+".join([*held, place.upper() if len(place) == 1 else place])
    return ""


_BINDABLE = (
    *ascii_uppercase, *digits, *(f"F{n}" for n in range(1, 13)), *(f"Keypad{n}" for n in range(10)),
    *(name for name in _NAMES if name not in ("0", "Escape")),
)  # fmt: skip


def needs_modifier(shortcut: str) -> bool:
    """Whether a shortcut is a bare key that must not fire while the user types or flies."""
    return "+" not in shortcut and not (shortcut.startswith("F") and shortcut[1:].isdigit())


def run_shortcuts(ui: Ui, *, flying: bool) -> None:
    """Run the operation whose keys were pressed in this frame. Text fields and fly mode keep bare keys."""
    io = imgui.get_io()
    if imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id | imgui.PopupFlags_.any_popup_level):
        return
    ui.keymap.apply()
    if ui.keymap.listening:  # the next key is to be bound, not run; who waits says so again in every frame
        ui.keymap.listening = False
        return
    for shortcut, operation in ui.operations.shortcuts().items():
        bare = needs_modifier(shortcut)
        if (bare and flying) or (io.want_text_input and (bare or operation in TEXT_FIELDS_OWN)):
            continue
        if imgui.is_key_chord_pressed(chord(by_place(shortcut))):
            ui.operations.attempt(operation, ui.session)
