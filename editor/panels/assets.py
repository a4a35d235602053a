"""Assets: the folder of the project or of the opened file. Double click opens; files dropped on the window open too."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.panels.base import Panel
from editor.panels.folder_listing import Entry, FolderListing, can_open, size_text
from editor.ui import Ui
from editor.widgets import em, empty_state, fitted, search_field, text, tooltip

KIND_LOOKS = {
    "folder": (icons.FOLDER, theme.rgb("#c9a46a")),
    "project": (icons.APP, theme.ACCENT),
    "scene": (icons.TREE, theme.GOOD),
    "source": (icons.MESH, theme.INFO),
    "picture": (icons.PICTURE, theme.rgb("#b58ad0")),
    "engine": (icons.MATERIAL, theme.rgb("#7fbdb4")),
    "file": (icons.FILE, theme.FAINT),
}


class AssetsPanel(Panel):
    title: ClassVar[str] = "Assets"
    icon: ClassVar[str] = icons.FOLDER_OPEN
    dock: ClassVar[str] = "LeftBottom"

    def __init__(self) -> None:
        self.needle = ""
        self._listing: FolderListing | None = None

    def draw(self, ui: Ui) -> None:
        root = asset_root(ui)
        if root is None:
            empty_state(icons.FOLDER_OPEN, "Drop a file or a folder here", "or open one with Ctrl+O")
            return
        if self._listing is None:
            self._listing = FolderListing(ui.session.host.source_extensions())
        self.needle = search_field("##filter", self.needle, f"{icons.SEARCH}  Filter files")
        imgui.begin_child("files")
        text(root.name or str(root), theme.DIM)
        tooltip(str(root))
        self._folder(ui, self._listing, root, 0)
        imgui.end_child()

    def _folder(self, ui: Ui, listing: FolderListing, folder: Path, depth: int) -> None:
        if depth > 24:  # a loop of links
            return
        for entry in listing.entries(folder):
            if entry.kind == "folder":
                imgui.set_next_item_open(depth == 0 and entry.name in {"assets", "scenes"}, imgui.Cond_.once)
                flags = imgui.TreeNodeFlags_.span_avail_width
                icon, color = KIND_LOOKS["folder"]
                imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*color))
                opened = imgui.tree_node_ex(f"{icon}###{entry.path}", flags)
                imgui.pop_style_color()
                imgui.same_line(0, em(0.4))
                imgui.text_unformatted(entry.name)
                if opened:
                    self._folder(ui, listing, entry.path, depth + 1)
                    imgui.tree_pop()
            elif not self.needle or self.needle.lower() in entry.name.lower():
                self._file(ui, entry)

    def _file(self, ui: Ui, entry: Entry) -> None:
        icon, color = KIND_LOOKS[entry.kind]
        document = ui.session.document
        current = document is not None and entry.path in {document.source, document.scene_path}
        start = imgui.get_cursor_pos_x() + imgui.get_tree_node_to_label_spacing()
        imgui.set_cursor_pos_x(start)
        clicked = imgui.selectable(f"##{entry.path}", current, imgui.SelectableFlags_.allow_double_click)[0]
        openable = can_open(entry)
        if clicked and openable and imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            ui.session.open(entry.path)
        tooltip(f"{entry.name}\n{size_text(entry.size)}" + ("\nDouble click opens it" if openable else ""))
        if openable and imgui.begin_popup_context_item(f"##menu{entry.path}"):
            if imgui.menu_item_simple("Open"):
                ui.session.open(entry.path)
            if imgui.menu_item_simple("Copy path"):
                imgui.set_clipboard_text(str(entry.path))
            imgui.end_popup()
        imgui.same_line(start)
        text(icon, color)
        imgui.same_line(0, em(0.4))
        text(fitted(entry.name, imgui.get_content_region_avail().x), theme.TEXT if openable else theme.DIM)


def asset_root(ui: Ui) -> Path | None:
    """The project's folder, or the folder of the opened file, or None."""
    document = ui.session.document
    if document is None:
        return None
    if document.project_root is not None:
        return document.project_root
    return document.source if document.source.is_dir() else document.source.parent


PANEL = AssetsPanel
