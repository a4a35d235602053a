"""Assets: the folder of the project or of the opened file, as a tree, a list or a grid of thumbnails, with search and
filters. Double click opens; files dropped on the window open too; what is dragged out goes into slots and previews."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import ClassVar

from imgui_bundle import imgui

from editor import asset_thumbnails as pictures
from editor import dropping, icons, material_editing, theme
from editor.asset_thumbnails import Thumbnail
from editor.flowing import button_width
from editor.panels.base import ASSET, Panel
from editor.panels.folder_listing import Entry, FolderListing, can_open, size_text
from editor.session import shader_root
from editor.thumbnail_maker import ANIMATIONS, EFFECTS, ENVIRONMENTS, MATERIALS, MODELS, TEXTURES, sort_of
from editor.ui import Ui
from editor.widgets import em, empty_state, fitted, flow, icon_button, pretty, search_field, text, tooltip
from engine.core.errors import LucarnaError
from importers.project.references import project_root

KIND_LOOKS = {
    "folder": (icons.FOLDER, "#c9a46a"),
    "project": (icons.APP, "ACCENT"),
    "scene": (icons.TREE, "GOOD"),
    "source": (icons.MESH, "INFO"),
    "picture": (icons.PICTURE, "#b58ad0"),
    "engine": (icons.MATERIAL, "#7fbdb4"),
    "file": (icons.FILE, "FAINT"),
}
SORT_LOOKS = {
    TEXTURES: KIND_LOOKS["picture"], ENVIRONMENTS: (icons.ENVIRONMENT, "#8fb8d8"),
    MATERIALS: KIND_LOOKS["engine"], EFFECTS: (icons.CODE, "#7fbdb4"), ANIMATIONS: (icons.FILM, "DIM"),
}  # fmt: skip
SORTS = ("", MODELS, MATERIALS, TEXTURES, ENVIRONMENTS, EFFECTS, ANIMATIONS)
VIEWS = {"tree": icons.TREE, "list": icons.INSPECT, "grid": icons.GRID}
TEXTS = (".toml", ".glsl", ".vert", ".frag", ".comp", ".geom", ".tesc", ".tese", ".json", ".md", ".txt")
LARGEST_TEXT = 1 << 20


class AssetsPanel(Panel):
    title: ClassVar[str] = "Assets"
    icon: ClassVar[str] = icons.FOLDER_OPEN
    dock: ClassVar[str] = "LeftBottom"

    def __init__(self) -> None:
        self.needle = ""
        #: the folder that list and grid show, relative to the root
        self.folder = Path()
        self.chosen: Path | None = None
        self._listing: FolderListing | None = None
        self._root: Path | None = None

    def draw(self, ui: Ui) -> None:
        root = asset_root(ui)
        if root is None:
            empty_state(icons.FOLDER_OPEN, "Drop a file or a folder here", "or open one with Ctrl+O")
            return
        if self._listing is None:
            self._listing = FolderListing(ui.session.host.source_extensions())
        if root != self._root or not (root / self.folder).is_dir():
            self._root, self.folder = root, Path()
        self._bar(ui)
        preferences, listing = ui.session.preferences, self._listing
        searching = bool(self.needle or preferences.assets_sort)
        if preferences.assets_view != "tree" and not searching:
            self._crumbs(root)
        imgui.begin_child("files")
        if searching:
            self._many(ui, listing.find(root, self.needle, preferences.assets_sort), root)
        elif preferences.assets_view == "tree":
            text(root.name or str(root), theme.DIM)
            tooltip(str(root))
            self._branch(ui, listing, root, 0)
        else:
            self._many(ui, listing.entries(root / self.folder), root / self.folder)
        imgui.end_child()

    def watched(self) -> Iterable[Path]:
        """The folders that are listed, and files whose pictures are shown."""
        return self._listing.known() if self._listing is not None and self._root is not None else ()

    # --- above the files ---

    def _bar(self, ui: Ui) -> None:
        preferences = ui.session.preferences
        width = imgui.get_content_region_avail().x - em(2.0)
        imgui.begin_child("search", (width, imgui.get_frame_height()))
        self.needle = search_field("##filter", self.needle, f"{icons.SEARCH}  Filter files")
        imgui.end_child()
        imgui.same_line(0, em(0.2))
        chosen = preferences.assets_sort if preferences.assets_sort in SORTS else ""
        if icon_button(f"{icons.FILTER}###sort", f"Show one sort of file: {chosen or 'all'}", active=bool(chosen)):
            imgui.open_popup("sorts")
        if imgui.begin_popup("sorts"):
            for sort in SORTS:
                if imgui.menu_item_simple(pretty(sort) or "All", "", sort == chosen):
                    preferences.assets_sort = sort
                    ui.session.remember()
            imgui.end_popup()
        for name, icon in VIEWS.items():
            shown = preferences.assets_view == name or (name == "tree" and preferences.assets_view not in VIEWS)
            if name != "tree":
                flow(button_width(icon), 0.05)
            if icon_button(f"{icon}###view-{name}", f"As a {name}", active=shown):
                preferences.assets_view = name
                ui.session.remember()
        flow(em(3), 0.05)
        imgui.set_next_item_width(-1)
        changed, size = imgui.slider_float("##size", preferences.assets_size, 24.0, 192.0, "")
        if changed:
            preferences.assets_size = float(size)
        if imgui.is_item_deactivated_after_edit():
            ui.session.remember()
        tooltip("Size of the pictures")

    def _crumbs(self, root: Path) -> None:
        """The way from the root to the folder that is shown; a click goes back."""
        parts = [Path(), *reversed([p for p in (self.folder, *self.folder.parents) if p != Path()])]
        for index, part in enumerate(parts):
            if index:
                imgui.same_line(0, em(0.2))
                text("/", theme.FAINT)
                imgui.same_line(0, em(0.2))
            last = index == len(parts) - 1
            text(part.name or root.name or str(root), theme.TEXT if last else theme.DIM)
            if imgui.is_item_clicked():
                self.folder = part

    # --- the files ---

    def _branch(self, ui: Ui, listing: FolderListing, folder: Path, depth: int) -> None:
        if depth > 24:  # a loop of links
            return
        for entry in listing.entries(folder):
            if entry.kind == "folder":
                imgui.set_next_item_open(depth == 0 and entry.name in {"assets", "scenes"}, imgui.Cond_.once)
                icon, color = KIND_LOOKS["folder"]
                imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*theme.named(color)))
                opened = imgui.tree_node_ex(f"{icon}###{entry.path}", imgui.TreeNodeFlags_.span_avail_width)
                imgui.pop_style_color()
                self._drop_into(ui, entry.path)
                if imgui.begin_popup_context_item(f"##menu{entry.path}"):
                    self._menu(ui, entry)
                    imgui.end_popup()
                imgui.same_line(0, em(0.4))
                imgui.text_unformatted(entry.name)
                if opened:
                    self._branch(ui, listing, entry.path, depth + 1)
                    imgui.tree_pop()
            else:
                self._row(ui, entry, imgui.get_cursor_pos_x() + imgui.get_tree_node_to_label_spacing())

    def _many(self, ui: Ui, entries: list[Entry], base: Path) -> None:
        """A folder's content, or what was found, in rows or tiles; only those in sight are drawn."""
        if not entries:
            text("Nothing found" if self.needle or ui.session.preferences.assets_sort else "Empty", theme.FAINT)
            return
        clipper = imgui.ListClipper()
        if ui.session.preferences.assets_view != "grid":
            clipper.begin(len(entries), self._line(ui) + imgui.get_style().item_spacing.y)
            while clipper.step():
                for entry in entries[clipper.display_start : clipper.display_end]:
                    self._row(ui, entry, imgui.get_cursor_pos_x())
            return
        size = max(ui.session.preferences.assets_size, 40.0)
        gap = imgui.get_style().item_spacing.x
        columns = max(int((imgui.get_content_region_avail().x + gap) // (size + gap)), 1)
        clipper.begin(-(-len(entries) // columns), size + imgui.get_text_line_height_with_spacing() + em(0.4))
        while clipper.step():
            for line in range(clipper.display_start, clipper.display_end):
                for index, entry in enumerate(entries[line * columns : (line + 1) * columns]):
                    if index:
                        imgui.same_line()
                    self._tile(ui, entry, size)

    def _line(self, ui: Ui) -> float:
        """The height of a row in tree and list."""
        return float(max(imgui.get_text_line_height(), min(ui.session.preferences.assets_size * 0.4, em(5))))

    def _row(self, ui: Ui, entry: Entry, start: float) -> None:
        height = self._line(ui)
        imgui.set_cursor_pos_x(start)
        low = imgui.get_cursor_screen_pos()
        imgui.push_style_var(imgui.StyleVar_.selectable_text_align, (0.0, 0.5))
        clicked = imgui.selectable(
            f"##{entry.path}", self._current(ui, entry), imgui.SelectableFlags_.allow_double_click, (0, height)
        )[0]
        imgui.pop_style_var()
        found = self._picture(ui, entry)
        self._touched(ui, entry, found, bool(clicked))
        _draw_picture(entry, found, (low.x, low.y), height)
        lines = imgui.get_window_draw_list()
        x = low.x + height + em(0.4)
        room = imgui.get_window_pos().x + imgui.get_window_width() - x - em(0.8)
        color = theme.TEXT if can_open(entry) or found.state != pictures.NONE or entry.kind == "folder" else theme.DIM
        y = low.y + (height - imgui.get_text_line_height()) * 0.5
        lines.add_text((x, y), theme.u32(color), fitted(entry.name, max(room, em(2))))

    def _tile(self, ui: Ui, entry: Entry, size: float) -> None:
        imgui.begin_group()
        low = imgui.get_cursor_screen_pos()
        flags = imgui.SelectableFlags_.allow_double_click
        clicked = imgui.selectable(
            f"##{entry.path}", self._current(ui, entry), flags, (size, size + imgui.get_text_line_height())
        )[0]
        found = self._picture(ui, entry)
        self._touched(ui, entry, found, bool(clicked))
        _draw_picture(entry, found, (low.x, low.y), size)
        name = fitted(_short(entry.name), size)
        at = (low.x + 0.5 * (size - imgui.calc_text_size(name).x), low.y + size)
        imgui.get_window_draw_list().add_text(at, theme.u32(theme.TEXT), name)
        imgui.end_group()

    # --- one file ---

    def _current(self, ui: Ui, entry: Entry) -> bool:
        document = ui.session.document
        opened = document is not None and entry.path in {document.source, document.scene_path}
        return opened or entry.path == self.chosen

    def _picture(self, ui: Ui, entry: Entry) -> Thumbnail:
        session = ui.session
        if entry.kind == "folder" or session.document is None or session.null_pictures or self._listing is None:
            return Thumbnail(pictures.NONE)
        root = shader_root(session.document)
        return session.asset_pictures.get(entry.path, self._listing.stamp(entry.path), root, session.shaders.taken)

    def _touched(self, ui: Ui, entry: Entry, found: Thumbnail, clicked: bool) -> None:
        """Clicks, drags, the menu and the tooltip of the item before."""
        if clicked:
            self.chosen = ui.session.asset = entry.path
            if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
                self._open(ui, entry)
        if entry.kind != "folder" and imgui.begin_drag_drop_source(imgui.DragDropFlags_.none):
            ui.session.ui.dragged = entry.path
            imgui.set_drag_drop_payload_py_id(ASSET, 0)
            imgui.text_unformatted(entry.name)
            imgui.end_drag_drop_source()
        if entry.kind == "folder":
            self._drop_into(ui, entry.path)
        about = f"{entry.name}\n{size_text(entry.size)}" if entry.kind != "folder" else entry.name
        if found.state == pictures.BROKEN:
            about += f"\n\n{icons.ERROR}  {found.error}"
        tooltip(about + ("\n\nDouble click opens it" if self._can_open(entry) else ""))
        if imgui.begin_popup_context_item(f"##menu{entry.path}"):
            self._menu(ui, entry)
            imgui.end_popup()

    def _drop_into(self, ui: Ui, folder: Path) -> None:
        """A file that is let go over a folder moves there, and what refers to it follows."""
        if imgui.begin_drag_drop_target():
            if imgui.accept_drag_drop_payload_py_id(ASSET) is not None and ui.session.ui.dragged is not None:
                ui.operations.run("file.move", ui.session, old=ui.session.ui.dragged, new=folder)
            imgui.end_drag_drop_target()

    @staticmethod
    def _can_open(entry: Entry) -> bool:
        openable = can_open(entry) or entry.kind == "folder" or _is_text(entry)
        return openable or sort_of(entry.name) in (MATERIALS, TEXTURES)

    def _open(self, ui: Ui, entry: Entry) -> None:
        if entry.kind == "folder":
            assert self._root is not None
            self.folder = entry.path.relative_to(self._root)
        elif sort_of(entry.name) == MATERIALS:
            _preview(ui, entry.path)
        elif sort_of(entry.name) == TEXTURES:
            ui.operations.run("texture.show", ui.session, path=entry.path)
        elif can_open(entry):
            ui.session.open(entry.path)
        elif _is_text(entry):
            ui.session.open_code(entry.path)

    def _menu(self, ui: Ui, entry: Entry) -> None:
        if self._can_open(entry) and imgui.menu_item_simple("Open"):
            self._open(ui, entry)
        if _can_place(entry) and imgui.menu_item_simple("Place in the scene"):
            ui.operations.run("prefab.place", ui.session, path=entry.path, at=tuple(ui.session.camera.target))
        if sort_of(entry.name) == ENVIRONMENTS and imgui.menu_item_simple("Look at the texture"):
            ui.operations.run("texture.show", ui.session, path=entry.path)
        if sort_of(entry.name) == ENVIRONMENTS and imgui.menu_item_simple("Light the scene with it"):
            dropping.light_with(ui.session, entry.path)
        if sort_of(entry.name) == MODELS and imgui.menu_item_simple("Put the previewed material on it"):
            _preview(ui, entry.path)
        if _is_text(entry) and imgui.menu_item_simple("Open as text"):
            ui.session.open_code(entry.path)
        if sort_of(entry.name) == MATERIALS and imgui.menu_item_simple("New material that inherits from this"):
            _derive(ui, entry.path)
        imgui.separator()
        if imgui.menu_item_simple("Rename or move…"):
            ui.session.ui.rename_asset = entry.path
        self._links(ui, entry)
        if imgui.menu_item_simple("Copy path"):
            imgui.set_clipboard_text(str(entry.path))

    def _links(self, ui: Ui, entry: Entry) -> None:
        """Sub-menus of who uses the file and what it uses; a click chooses that one."""
        links = ui.session.links
        if self._root is not None:
            links.refresh(project_root(entry.path))
        for label, found in (("Used by", links.used_by(entry.path)), ("Uses", links.uses(entry.path))):
            if imgui.begin_menu(f"{label} {len(found) or 'nothing'}###{label}", bool(found)):
                for path in found:
                    if imgui.menu_item_simple(f"{path.name}##{path}"):
                        self._choose(ui, path)
                    tooltip(str(path))
                imgui.end_menu()

    def _choose(self, ui: Ui, path: Path) -> None:
        """Show that file: its folder, and nothing that filters it away."""
        self.chosen = ui.session.asset = path
        self.needle = ui.session.preferences.assets_sort = ""
        if self._root is not None and self._root in path.parents:
            self.folder = path.parent.relative_to(self._root)


def _can_place(entry: Entry) -> bool:
    return entry.kind == "scene" or (entry.kind == "source" and sort_of(entry.name) == MODELS)


def _derive(ui: Ui, path: Path) -> None:
    try:
        child = material_editing.derive(path)
    except LucarnaError as error:
        ui.session.fail(error)
        return
    _preview(ui, child)


def _preview(ui: Ui, path: Path) -> None:
    ui.session.preview.load(ui.session)
    ui.session.preview.take(ui.session, path)
    ui.session.ui.focus_panel = "Material preview"


def _short(name: str) -> str:
    """Without the ending that the picture tells."""
    return next(
        (name.removesuffix(e) for e in (".material.toml", ".scene.json", ".effect.toml") if name.endswith(e)), name
    )


def _is_text(entry: Entry) -> bool:
    return entry.name.lower().endswith(TEXTS) and entry.size <= LARGEST_TEXT


def _draw_picture(entry: Entry, found: Thumbnail, at: tuple[float, float], size: float) -> None:
    """The thumbnail in a square at `at`; the icon of its sort where there is none, and a sign while it is made or where
    it could not be."""
    lines = imgui.get_window_draw_list()
    end = (at[0] + size, at[1] + size)
    if found.native:
        lines.add_image_rounded(
            imgui.ImTextureRef(found.native), at, end, (0, 0), (1, 1), 0xFFFFFFFF, imgui.get_style().frame_rounding
        )
        return
    large = size > em(2.2)
    if large and entry.kind != "folder" and found.state != pictures.NONE:
        lines.add_rect_filled(at, end, theme.u32(theme.FRAME), imgui.get_style().frame_rounding)
    icon, color = (
        SORT_LOOKS.get(sort_of(entry.name), KIND_LOOKS[entry.kind]) if entry.kind != "folder" else KIND_LOOKS["folder"]
    )
    sign = {pictures.WAITING: (icons.WAITING, theme.DIM), pictures.BROKEN: (icons.ERROR, theme.ERROR)}.get(found.state)
    font = min(size * 0.45, em(3.0)) if large else imgui.get_font_size()
    wide = imgui.calc_text_size(icon).x * font / imgui.get_font_size()
    middle = (at[0] + 0.5 * (size - wide), at[1] + 0.5 * (size - font))
    faint = 0.35 if sign is not None and large else 1.0
    lines.add_text(imgui.get_font(), font, middle, theme.u32(theme.named(color), faint), icon)
    if sign is not None:
        corner = (end[0] - em(1.2), end[1] - em(1.2)) if large else (end[0] - em(0.35), end[1] - em(0.75))
        lines.add_text(imgui.get_font(), em(1.0 if large else 0.6), corner, theme.u32(sign[1]), sign[0])


def asset_root(ui: Ui) -> Path | None:
    """The folder of the project around what is open, else the folder of the opened file; None with nothing open."""
    document = ui.session.document
    if document is None:
        return None
    if document.project_root is not None:
        return document.project_root
    return document.source if document.source.is_dir() else project_root(document.source)


PANEL = AssetsPanel
