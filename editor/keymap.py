"""Keymap: which keys run which operation: a preset, and over it the user's changes, kept as the difference. No imgui.

operation's own keys ─► preset ─► the user's changes ─► Operations.rebound ─► menu, palette, keys, help card
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from editor.navigation import DEFAULT_PRESET
from editor.operations import Operations
from editor.preferences import Preferences
from engine.core.atomic import write_text
from engine.core.errors import FormatError, InputError

SCHEMA = "lucarna.keymap/1"
MODIFIERS = ("Ctrl", "Shift", "Alt")
_KEY = re.compile(
    r"([A-Z0-9]|F([1-9]|1[0-9]|2[0-4])|Keypad[0-9./*-]|Space|Escape|Home|End|Enter|Delete|Insert|Backspace|Tab|"
    r"PageUp|PageDown|Up|Down|Left|Right|[,.=\-\\/;'`\[\]])"
)

#: what a preset has otherwise than the operations declare; industry is as they declare
PRESET_KEYS: dict[str, dict[str, tuple[str, ...]]] = {
    "industry": {},
    "blender": {
        "tool.move": ("G",), "tool.rotate": ("R",), "tool.scale": ("S",), "tool.select": ("W",), "tool.local": (),
        "edit.delete": ("X", "Delete"), "edit.duplicate": ("Shift+D",), "edit.isolate": ("/", "Keypad/"),
        "edit.select-all": ("A",), "edit.deselect": ("Alt+A", "Escape"), "edit.redo": ("Ctrl+Shift+Z",),
        "edit.unparent": ("Alt+P",), "edit.group": ("Ctrl+G",),
        "view.frame": ("Keypad.",), "view.frame-all": ("Home",), "help.palette": ("F3", "Ctrl+Shift+P"),
    },
    "viewer": {
        "view.frame": ("F",), "view.frame-all": ("Enter", "Home", "A"), "help.keys": ("H", "F1"), "edit.hide": (),
        "view.panel-console": ("Shift+;",), "help.palette": ("Ctrl+Shift+P", "F3"),
    },
}  # fmt: skip


def normal(shortcut: str) -> str:
    """`shift+ctrl+p` -> `Ctrl+Shift+P`. Raises InputError for what is no key."""
    *held, key = re.sub(r"\+\+$", "+=", shortcut.strip()).split("+")
    named = {m.lower(): m for m in MODIFIERS}
    modifiers = {named.get(word.strip().lower(), "") for word in held}
    key = key.strip()
    key = key.upper() if len(key) == 1 else key[:1].upper() + key[1:]
    if "" in modifiers or not _KEY.fullmatch(key):
        raise InputError(f"{shortcut!r} is no key", hint="such as G, F5, Ctrl+Shift+P or Keypad0")
    return "+".join([*(m for m in MODIFIERS if m in modifiers), key])


class Keymap:
    """The keys in use. `apply` after anything that it depends on changed; every change here applies itself."""

    def __init__(self, operations: Operations, preferences: Preferences) -> None:
        self.operations, self.preferences = operations, preferences
        self._applied: object = None
        #: whether somebody waits for a key to bind it
        self.listening = False
        self.apply()

    @property
    def preset(self) -> str:
        return self.preferences.keymap if self.preferences.keymap in PRESET_KEYS else DEFAULT_PRESET

    @property
    def changes(self) -> dict[str, list[str]]:
        """Operation -> its keys, of the preset in use: what the user changed and nothing else."""
        found: dict[str, list[str]] = self.preferences.shortcuts.setdefault(self.preset, {})
        return found

    def apply(self) -> None:
        state = (self.preset, json.dumps(self.preferences.shortcuts, sort_keys=True), len(list(self.operations)))
        if state == self._applied:
            return
        rebound = dict(PRESET_KEYS[self.preset])
        rebound.update({id: tuple(keys) for id, keys in self.changes.items()})
        self.operations.rebind(rebound)
        self._applied = (self.preset, json.dumps(self.preferences.shortcuts, sort_keys=True), state[2])

    def keys(self, id: str) -> tuple[str, ...]:
        return self.operations.keys_of(self.operations[id])

    def preset_keys(self, id: str) -> tuple[str, ...]:
        """As they are without the user's changes."""
        return PRESET_KEYS[self.preset].get(id, self.operations[id].shortcuts)

    def conflicts(self, id: str, keys: Sequence[str]) -> list[str]:
        """The other operations that one of the keys runs now."""
        taken = self.operations.shortcuts()
        return list(dict.fromkeys(taken[key] for key in keys if taken.get(key, id) != id))

    def bind(self, id: str, keys: Sequence[str], *, replace: bool = False) -> None:
        """Give an operation these keys. Raises InputError for what is no key, and for a key that another has; with
        `replace` that one loses it."""
        wanted = list(dict.fromkeys(normal(key) for key in keys))
        others = self.conflicts(id, wanted)
        if others and not replace:
            raise InputError(f"{', '.join(wanted)} is taken by {', '.join(others)}", hint="take it away there first")
        for other in others:
            self._set(other, [key for key in self.keys(other) if key not in wanted])
        self._set(id, wanted)
        self.apply()

    def _set(self, id: str, keys: list[str]) -> None:
        if tuple(keys) == self.preset_keys(id):
            self.changes.pop(id, None)
        else:
            self.changes[id] = keys

    def reset(self, id: str | None = None) -> None:
        """One operation's keys, or all, as the preset has them."""
        if id is None:
            self.changes.clear()
        else:
            self.changes.pop(id, None)
        self.apply()

    def export_to(self, path: Path) -> None:
        """Write preset and changes. Raises OutputError."""
        data = {"schema": SCHEMA, "preset": self.preset, "changes": self.changes}
        write_text(path, json.dumps(data, indent=2, sort_keys=True) + "\n")

    def import_from(self, path: Path) -> list[str]:
        """Take over what `export_to` wrote, of this or another version; returns operations in it that there are not.
        Raises InputError or FormatError, and then changes nothing."""
        try:
            data: Any = json.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise InputError(f"the keymap cannot be read: {error.strerror}", where=path) from error
        except ValueError as error:
            raise FormatError("this is no keymap", where=path) from error
        if not isinstance(data, dict) or data.get("schema") != SCHEMA or data.get("preset") not in PRESET_KEYS:
            raise FormatError("this is no keymap", where=path, hint=f"expected schema {SCHEMA} and a known preset")
        changes: dict[str, list[str]] = {}
        for id, keys in dict(data.get("changes", {})).items():
            if not isinstance(keys, list) or not all(isinstance(key, str) for key in keys):
                raise FormatError(f"the keys of {id} are no list of texts", where=path)
            changes[str(id)] = [normal(key) for key in keys]
        self.preferences.keymap = data["preset"]
        self.preferences.shortcuts[data["preset"]] = {k: v for k, v in changes.items() if k in self.operations}
        self.apply()
        return [id for id in changes if id not in self.operations]
