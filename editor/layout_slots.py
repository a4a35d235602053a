"""Three slots for an arrangement of the window: which panels are open and where they stand, as files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from imgui_bundle import imgui

from editor.preferences import layout_path
from engine.core.atomic import write_text
from engine.core.errors import InputError, LucarnaError

SLOTS = (1, 2, 3)


def slot_path(slot: int) -> Path:
    return layout_path().parent / "layouts" / f"slot-{slot}.json"


def save(slot: int, windows: Any) -> None:
    """Write the window's arrangement; `windows`: hello_imgui's. Raises OutputError."""
    data = {"open": [w.label.rpartition("###")[2] for w in windows if w.is_visible],
            "places": imgui.save_ini_settings_to_memory()}  # fmt: skip
    write_text(slot_path(slot), json.dumps(data, indent=1) + "\n")


def load(slot: int, windows: Any) -> None:
    """Arrange the window as it was saved; outside imgui's frame. Raises InputError where there is nothing to load."""
    path = slot_path(slot)
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        shown, places = set(map(str, data["open"])), str(data["places"])
    except FileNotFoundError as error:
        raise InputError(f"no layout was saved in slot {slot}", hint="View, Save layout") from error
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError("is no saved layout", where=path, hint="save it anew") from error
    for window in windows:
        window.is_visible = window.label.rpartition("###")[2] in shown or not window.can_be_closed
    imgui.load_ini_settings_from_memory(places)


def run(request: tuple[str, int], windows: Any) -> str:
    """Carry out ("save" | "load", slot); what to tell the user."""
    what, slot = request
    try:
        (save if what == "save" else load)(slot, windows)
    except LucarnaError as error:
        return str(error)
    return f"Layout {'saved in' if what == 'save' else 'of'} slot {slot}"
