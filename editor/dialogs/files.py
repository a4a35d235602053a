"""The open and save dialogs: own windows, alike on every system, needing no desktop service."""

from __future__ import annotations

from pathlib import Path

from imgui_bundle import imgui

from editor import icons, saving, theme
from editor.panels.assets import KIND_LOOKS
from editor.panels.folder_listing import Entry, FolderListing, can_open, size_text
from editor.ui import Ui
from editor.widgets import bold, em, icon_button, text, tooltip


class FileDialog:
    """`saving`: asks for a new *.scene.json; else for a project, folder, scene or source."""

    def __init__(self, *, saving: bool) -> None:
        self.saving = saving
        self.name = "Save scene as" if saving else "Open"
        self.has_recent = not saving
        self.folder = Path.cwd()
        self.file = ""
        self.show_all = False
        self._listing: FolderListing | None = None
        #: the file that would be replaced; a second press on the button does it
        self._replace: Path | None = None

    def draw(self, ui: Ui) -> None:
        if self._asked(ui):
            self._start(ui)
            imgui.open_popup(self.name)
        viewport = imgui.get_main_viewport()
        size = (min(em(50), viewport.size.x * 0.9), min(em(34), viewport.size.y * 0.85))
        imgui.set_next_window_pos(viewport.get_center(), imgui.Cond_.appearing, (0.5, 0.5))
        imgui.set_next_window_size(size, imgui.Cond_.appearing)
        flags = imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_collapse
        if not imgui.begin_popup_modal(self.name, None, flags)[0]:
            return
        if self._listing is None:
            self._listing = FolderListing(ui.session.host.source_extensions())
        self._path_bar()
        footer = imgui.get_frame_height_with_spacing() + em(0.6)
        imgui.begin_child("body", (0, -footer))
        self._places(ui)
        imgui.same_line()
        self._files(ui)
        imgui.end_child()
        self._footer(ui)
        if imgui.is_key_pressed(imgui.Key.escape):
            imgui.close_current_popup()
        imgui.end_popup()

    def _asked(self, ui: Ui) -> bool:
        """Whether somebody asked for it since the last frame."""
        requests = ui.session.ui
        asked = requests.save_dialog if self.saving else requests.open_dialog
        if self.saving:
            requests.save_dialog = False
        else:
            requests.open_dialog = False
        return asked

    def _shows(self, entry: Entry) -> bool:
        """Whether a file is listed before "all files" is ticked."""
        return can_open(entry)

    def _start(self, ui: Ui) -> None:
        self._replace = None
        document = ui.session.document
        if document is not None:
            target = saving.suggested_target(document) if self.saving else document.source
            self.folder = target if target.is_dir() else target.parent
            self.file = target.name if self.saving else ""
        while not self.folder.is_dir() and self.folder != self.folder.parent:
            self.folder = self.folder.parent

    def _path_bar(self) -> None:
        if icon_button(f"{icons.UP}##up", "The folder above"):
            self.folder = self.folder.parent
        imgui.same_line(0, em(0.3))
        parts = [*reversed(self.folder.parents), self.folder]
        for i, part in enumerate(parts[-5:]):
            if i:
                imgui.same_line(0, 0)
                text("/", theme.FAINT)
                imgui.same_line(0, 0)
            if icon_button(f"{part.name or part.anchor}##{part}", ""):
                self.folder = part

    def _places(self, ui: Ui) -> None:
        imgui.begin_child("places", (em(13), 0), imgui.ChildFlags_.borders)
        home = Path.home()
        for name, place in (("Home", home), ("Working folder", Path.cwd())):
            if imgui.selectable(f"{icons.FOLDER}  {name}", self.folder == place)[0]:
                self.folder = place
        if ui.session.preferences.recent and self.has_recent:
            imgui.separator_text("Recent")
            for recent in ui.session.preferences.recent:
                path = Path(recent)
                if imgui.selectable(f"{path.name}##{recent}", False)[0]:
                    imgui.close_current_popup()
                    ui.session.open(path)
                if imgui.is_item_hovered():
                    imgui.set_tooltip(recent)
        imgui.end_child()

    def _files(self, ui: Ui) -> None:
        assert self._listing is not None
        imgui.begin_child("files", (0, 0), imgui.ChildFlags_.borders)
        rows = [e for e in self._listing.entries(self.folder) if e.kind == "folder" or self.show_all or self._shows(e)]
        if not rows:
            text("Nothing here that can be opened", theme.DIM)
        clipper = imgui.ListClipper()
        clipper.begin(len(rows))
        while clipper.step():
            for i in range(clipper.display_start, clipper.display_end):
                self._entry(ui, rows[i])
        imgui.end_child()

    def _entry(self, ui: Ui, entry: Entry) -> None:
        icon, tint = KIND_LOOKS[entry.kind]
        color = theme.named(tint)
        start = imgui.get_cursor_pos_x()
        flags = imgui.SelectableFlags_.allow_double_click | imgui.SelectableFlags_.no_auto_close_popups
        if imgui.selectable(f"##{entry.name}", entry.name == self.file, flags)[0]:
            double = imgui.is_mouse_double_clicked(imgui.MouseButton_.left)
            if entry.kind != "folder":
                self.file = entry.name
                if double:
                    self._accept(ui)
            elif double:
                self.folder, self.file = entry.path, self.file if self.saving else ""
            elif not self.saving:
                self.file = entry.name
        imgui.same_line(start)
        text(icon, color)
        imgui.same_line(0, em(0.5))
        imgui.text_unformatted(entry.name)
        if entry.size:
            size = size_text(entry.size)
            imgui.same_line(imgui.get_window_width() - imgui.calc_text_size(size).x - em(1.2))
            text(size, theme.FAINT)

    def _footer(self, ui: Ui) -> None:
        imgui.spacing()
        if self._replace is not None and self._replace.name not in {self.file, f"{self.file}.scene.json"}:
            self._replace = None
        imgui.set_next_item_width(-em(25) if not self.saving else -em(14))
        entered, self.file = imgui.input_text("##name", self.file, imgui.InputTextFlags_.enter_returns_true)
        imgui.same_line()
        if not self.saving:
            _changed, self.show_all = imgui.checkbox("All files", self.show_all)
            imgui.same_line()
        with bold(ui):
            verb = "Replace" if self._replace is not None else "Save"
            accepted = imgui.button(f"{verb if self.saving else 'Open'}###accept", (em(6), 0))
        if self._replace is not None:
            tooltip(f"{self._replace.name} is there already")
        imgui.same_line()
        if imgui.button("Cancel", (em(6), 0)):
            imgui.close_current_popup()
        if entered or accepted:
            self._accept(ui)

    def _accept(self, ui: Ui) -> None:
        path = (self.folder / self.file).expanduser() if self.file else self.folder
        if not self.saving:
            imgui.close_current_popup()
            ui.session.open(path)
            return
        if not self.file:
            return
        if not path.name.endswith(".scene.json"):
            path = path.with_name(path.name + ".scene.json")
        document = ui.session.document
        if path.exists() and path != self._replace and document is not None and path != document.saved_to:
            self._replace = path
            return
        imgui.close_current_popup()
        ui.session.save(path)
