"""Scene: the tree of nodes. Click selects, Ctrl+click adds, double click frames, the eye hides."""

from __future__ import annotations

from typing import ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.document import Document
from editor.panels.base import Panel
from editor.panels.tree_rows import UNFOLD_LIMIT, TreeRow, ancestors, kinds, matching_rows, visible_rows
from editor.ui import Ui
from editor.widgets import bare_button, em, empty_state, fitted, search_field, text

KIND_ICONS = {
    "mesh": (icons.MESH, theme.INFO),
    "light": (icons.LIGHT, theme.ACCENT),
    "camera": (icons.CAMERA, theme.GOOD),
    "group": (icons.GROUP, theme.DIM),
    "": (icons.EMPTY, theme.FAINT),
}


class SceneTreePanel(Panel):
    title: ClassVar[str] = "Scene"
    icon: ClassVar[str] = icons.TREE
    dock: ClassVar[str] = "Left"

    def __init__(self) -> None:
        self.needle = ""
        self.unfolded: set[int] = set()
        self._document: Document | None = None
        self._selection: tuple[int, ...] = ()
        self._rows_key: object = None
        self._rows: list[TreeRow] = []
        self._kinds: dict[int, str] = {}
        self._fold_rev = 0

    def draw(self, ui: Ui) -> None:
        document = ui.session.document
        if document is None:
            empty_state(icons.TREE, "No scene is open", "Ctrl+O opens one")
            return
        self._follow(document)
        self.needle = search_field("##search", self.needle, f"{icons.SEARCH}  Search nodes")
        self._collect(document)
        flags = imgui.TableFlags_.scroll_y | imgui.TableFlags_.row_bg | imgui.TableFlags_.no_saved_settings
        imgui.push_style_var(imgui.StyleVar_.cell_padding, (2, 1))
        if imgui.begin_table("nodes", 2, flags):
            imgui.table_setup_column("name", imgui.TableColumnFlags_.width_stretch)
            imgui.table_setup_column("visible", imgui.TableColumnFlags_.width_fixed, em(1.6))
            scroll_to = self._scroll_target(document)
            clipper = imgui.ListClipper()
            clipper.begin(len(self._rows))
            if scroll_to >= 0:
                clipper.include_item_by_index(scroll_to)
            while clipper.step():
                for i in range(clipper.display_start, clipper.display_end):
                    self._row(ui, document, self._rows[i], scroll=i == scroll_to)
            imgui.end_table()
        imgui.pop_style_var()
        if not self._rows and self.needle:
            text(f"Nothing is called “{self.needle}”", theme.DIM)

    def _follow(self, document: Document) -> None:
        """A new document: fold it anew. A new selection from elsewhere: unfold the way to it."""
        if document is not self._document:
            self._document, self.needle, self._selection = document, "", ()
            nodes = document.runtime.scene.nodes
            few = len(nodes.name) <= UNFOLD_LIMIT
            self.unfolded = set(range(len(nodes.name))) if few else set(document.children_of(-1)[:1])
            self._rows_key = None
        if document.selection != self._selection:
            for row in document.selection:
                self.unfolded.update(ancestors(document, row))
            self._fold_rev += 1

    def _collect(self, document: Document) -> None:
        scene = document.runtime.scene
        key = (id(document), int(scene.structure_rev), len(scene.nodes.name), self.needle, self._fold_rev)
        if key != self._rows_key:
            self._rows_key = key
            self._rows = matching_rows(document, self.needle) if self.needle else visible_rows(document, self.unfolded)
            self._kinds = kinds(document)

    def _scroll_target(self, document: Document) -> int:
        """Index of the row to bring into view: the primary selection, once, after it changed."""
        if document.selection == self._selection:
            return -1
        self._selection = document.selection
        return next((i for i, r in enumerate(self._rows) if r.row == document.primary), -1)

    def _row(self, ui: Ui, document: Document, item: TreeRow, *, scroll: bool) -> None:
        row, nodes = item.row, document.runtime.scene.nodes
        imgui.table_next_row()
        imgui.table_next_column()
        if scroll:
            imgui.set_scroll_here_y(0.5)
        selected = row in document.selection
        start = imgui.get_cursor_pos_x()
        name = nodes.name[row] or f"node {row}"
        flags = (
            imgui.SelectableFlags_.allow_overlap
            | imgui.SelectableFlags_.allow_double_click
            | imgui.SelectableFlags_.span_all_columns
        )
        if imgui.selectable(f"##{name}-{row}", selected, flags, (0, imgui.get_frame_height() * 0.92))[0]:
            document.select(row, toggle=imgui.get_io().key_ctrl)
            self._selection = document.selection
            if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
                ui.operations.run("view.frame", ui.session)
        hovered = imgui.is_item_hovered()
        self._menu(ui, document, row)
        imgui.same_line(start + item.depth * em(0.95))
        imgui.align_text_to_frame_padding()
        self._arrow(item)
        imgui.same_line(0, em(0.15))
        shown = bool(nodes.visible_world[row]) and bool(nodes.visible[row])
        icon, color = KIND_ICONS[self._kinds.get(row) or ("group" if item.has_children else "")]
        text(icon, color if shown else theme.FAINT)
        imgui.same_line(0, em(0.35))
        text(fitted(name, imgui.get_content_region_avail().x), theme.TEXT if shown else theme.FAINT)
        imgui.table_next_column()
        own = bool(nodes.visible[row])
        color = theme.FAINT if not own else theme.DIM if hovered or selected else theme.rgb("#565c66")
        if bare_button(f"{icons.VISIBLE if own else icons.HIDDEN}###eye{row}", color):
            rows = document.selection if row in document.selection else (row,)
            ui.session.set_visible(rows, not own)

    def _arrow(self, item: TreeRow) -> None:
        if not item.has_children:
            imgui.dummy((em(1.15), 1))
            return
        opened = item.row in self.unfolded or bool(self.needle)
        position = imgui.get_cursor_screen_pos()
        if imgui.invisible_button(f"##arrow{item.row}", (em(1.15), imgui.get_frame_height() * 0.9)):
            self.unfolded.symmetric_difference_update({item.row})
            self._fold_rev += 1
        icon = icons.OPEN_NODE if opened else icons.CLOSED_NODE
        lines = imgui.get_window_draw_list()
        color = theme.u32(theme.TEXT if imgui.is_item_hovered() else theme.DIM)
        lines.add_text((position.x, position.y + imgui.get_style().frame_padding.y), color, icon)

    def _menu(self, ui: Ui, document: Document, row: int) -> None:
        if not imgui.begin_popup_context_item(f"##menu{row}"):
            return
        if row not in document.selection:
            document.select(row)
        for id in ("view.frame", "edit.hide", "edit.show-all", "edit.select-parent"):
            operation = ui.operations[id]
            key = operation.shortcuts[0] if operation.shortcuts else ""
            if imgui.menu_item(operation.label, key, False, operation.enabled(ui.session))[0]:
                ui.operations.run(id, ui.session)
        imgui.end_popup()


PANEL = SceneTreePanel
