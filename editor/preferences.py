"""What the editor remembers about its user: recent files, keymap, scale. A small JSON file in the settings folder.

A damaged or foreign file never stops the editor: unknown keys and bad values fall back to the defaults, one by one.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from editor.navigation import POINTERS
from engine.core.atomic import write_text
from engine.core.errors import OutputError
from engine.core.paths import user_config_dir

RECENT_LIMIT = 12
THEMES = ("dark", "high-contrast")
#: what plays while another window is in front: ten pictures a second, as ever, nothing
IN_BACKGROUND = ("slow", "full", "stop")


@dataclass(slots=True)
class Preferences:
    """`ui_scale` multiplies what the display's own scale asks for."""

    recent: list[str] = field(default_factory=list)
    keymap: str = "industry"
    ui_scale: float = 1.0
    theme: str = "dark"
    #: the arrangement of panels in use, one of layout.WORKSPACES
    workspace: str = "Edit"
    welcome_seen: bool = False
    show_axes: bool = True
    show_stats: bool = True
    show_outline: bool = True
    #: the reach of every light, not of the selected ones only
    show_lights: bool = False
    #: grey ball, chrome ball and colour chart in the viewport's corner
    show_look_card: bool = False
    #: the viewport after each edit, small, in the history panel
    history_pictures: bool = True
    #: render at half resolution while something moves and full resolution is slow
    adaptive_resolution: bool = True
    #: while nothing happens, make the programs of the other render paths and debug views
    prepare_views: bool = True
    #: what plays while another window is in front, one of IN_BACKGROUND
    in_background: str = "slow"
    #: pictures a second at most; 0: as many as the display shows
    fps_limit: int = 0
    #: one of navigation.POINTERS: what two fingers do is the keymap's; whether they and the wheel go the other way
    pointer: str = "mouse"
    reverse_scroll: bool = False
    fly_speed: float = 1.0
    #: import sources again when they change; show the card of an import
    reimport: bool = True
    import_card: bool = True
    #: the assets panel: tree, list or grid; how large its pictures are, imgui units; which sorts show ("" = all)
    assets_view: str = "tree"
    assets_size: float = 88.0
    assets_sort: str = ""
    #: how the material preview is set up (see editor.preview.PreviewSetup)
    preview: dict[str, Any] = field(default_factory=dict)
    #: auto (as the system), or one of editor.strings.LANGUAGES
    language: str = "auto"
    #: shortcuts that differ from the preset's: operation -> its keys (see editor.keymap)
    shortcuts: dict[str, Any] = field(default_factory=dict)
    #: plug-ins that the user switched off, by name, and projects whose own may run
    plugins_off: list[str] = field(default_factory=list)
    trusted_projects: list[str] = field(default_factory=list)

    def add_recent(self, path: Path) -> None:
        text = str(path.resolve())
        self.recent = [text, *(p for p in self.recent if p != text)][:RECENT_LIMIT]


def preferences_path() -> Path:
    return user_config_dir() / "editor.json"


def layout_path() -> Path:
    """Where the window layout lies (written by the GUI library)."""
    return user_config_dir() / "layout.ini"


def load(path: Path | None = None) -> Preferences:
    """Read the preferences; what is missing, damaged or out of range takes its default."""
    preferences = Preferences()
    try:
        data: Any = json.loads((path or preferences_path()).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return preferences
    if not isinstance(data, dict):
        return preferences
    for item in fields(Preferences):
        value, default = data.get(item.name), getattr(preferences, item.name)
        if isinstance(default, float) and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if type(value) is type(default):
            setattr(preferences, item.name, value)
    preferences.recent = [p for p in preferences.recent if isinstance(p, str)][:RECENT_LIMIT]
    if not 0.5 <= preferences.ui_scale <= 3.0:
        preferences.ui_scale = 1.0
    if preferences.theme not in THEMES:
        preferences.theme = THEMES[0]
    if preferences.pointer not in POINTERS:
        preferences.pointer = POINTERS[0]
    if preferences.in_background not in IN_BACKGROUND:
        preferences.in_background = IN_BACKGROUND[0]
    if preferences.fps_limit != 0 and not 5 <= preferences.fps_limit <= 1000:
        preferences.fps_limit = 0
    if not 24.0 <= preferences.assets_size <= 192.0:
        preferences.assets_size = 88.0
    if not 0.001 <= preferences.fly_speed <= 1000.0:
        preferences.fly_speed = 1.0
    return preferences


def save(preferences: Preferences, path: Path | None = None) -> str:
    """Write atomically. Returns '' or, where the folder cannot be written, what went wrong: never a reason to stop."""
    try:
        write_text(path or preferences_path(), json.dumps(asdict(preferences), indent=2, sort_keys=True) + "\n")
    except OutputError as error:
        return str(error)
    return ""
