"""What operations ask of the window: dialogs, panels, notices. The window carries it out and clears it. No imgui."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from editor.journal import Recovery


@dataclass(frozen=True, slots=True)
class ChooseFile:
    """A file to choose: `endings` in small letters, `start` a folder or the last file, `take` gets the path."""

    title: str
    endings: tuple[str, ...]
    start: Path
    take: Callable[[Path], None]


@dataclass(slots=True)
class UiRequests:
    """What operations ask of the window, which carries it out and clears it."""

    palette: bool = False
    open_dialog: bool = False
    save_dialog: bool = False
    choose: ChooseFile | None = None
    welcome: bool = False
    help: bool = False
    about: bool = False
    reset_layout: bool = False
    #: a workspace to switch to, and ("save" | "load", slot) of an arrangement to keep or to take
    workspace: str = ""
    layout_slot: tuple[str, int] | None = None
    reload_plugins: bool = False
    quit: bool = False
    focus_panel: str = ""
    toggle_panel: str = ""
    error_bar: str = ""
    notice: str = ""
    #: what to do once the user has said what becomes of unsaved changes
    after_discard: Callable[[], None] | None = None
    #: whether that is about everything that is open, not only the document in front
    discard_all: bool = False
    status_hint: str = ""
    scale_changed: bool = False
    #: sessions that died with unsaved edits, to ask about
    recoveries: list[Recovery] = field(default_factory=list)
    #: node row whose name the tree should edit, or -1
    rename: int = -1
    #: show what is known of the import of the document in front
    import_card: bool = False
    #: the user asked for it: it stays as it is until he folds it
    import_card_opened: bool = False
    #: whether it shows one line at present
    import_card_folded: bool = False
    #: a file of the project to rename or move
    rename_asset: Path | None = None
    #: rows under the pointer to choose from
    pick_list: tuple[int, ...] = ()
    copy_text: str = ""
    #: edits of a material's parameters are of the selected objects alone
    only_object: bool = False
    #: takes the clipboard's text
    paste: Callable[[str], None] | None = None
    #: the file that is being dragged out of the assets panel
    dragged: Path | None = None
    #: a texel to show in the texture viewer (numbers.PixelRequest), or None
    show_pixel: Any = None
    #: what to show in the texture viewer: a target of the frame by name, or an image file
    show_texture: str | Path = ""
