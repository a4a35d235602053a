"""Scene: the tree of nodes. Click selects, Ctrl+click adds, Shift+click takes all between, double click frames, a drag
hangs nodes below another, F2 renames, the eye hides."""

from __future__ import annotations

from typing import ClassVar

from imgui_bundle import imgui

from editor import icons, prefab_values, prefabs, theme
from editor.document import Document
from editor.editing_operations import reparent
from editor.panels.base import Panel
from editor.panels.tree_rows import UNFOLD_LIMIT, TreeRow, ancestors, kinds, matching_rows, visible_rows
from editor.ui import Ui
from editor.widgets import bare_button, em, empty_state, fitted, own_text, search_field, text
from engine.assets.prefab import NODE, ROOT

KIND_ICONS = {
    "mesh": (icons.MESH, "INFO"),
    "light": (icons.LIGHT, "ACCENT"),
    "camera": (icons.CAMERA, "GOOD"),
    "group": (icons.GROUP, "DIM"),
    "": (icons.EMPTY, "FAINT"),
}


#: operations of a row's context menu; "" is a line between
MENU = (
    "view.frame", "edit.isolate", "", "edit.rename", "edit.duplicate", "edit.group", "edit.unparent", "edit.delete", "",
    "edit.hide", "edit.show-all", "edit.lock", "",
    "prefab.make", "prefab.open", "prefab.revert", "prefab.apply", "", "edit.select-parent", "edit.select-children",
)  # fmt: skip
#: nodes that came with a prefab
PREFAB = "INFO"
#: what a dragged row carries: the row
PAYLOAD = "node"


def indent(deepest: int, width: float) -> float:
    """Pixels a level: less in deep trees, so that the deepest name keeps more than half of `width`."""
    return min(em(0.95), max(em(0.2), 0.45 * width / max(deepest, 1)))


#: of a row; put together once, since an enum of Python takes its time
_ROW = (
    int(imgui.SelectableFlags_.allow_overlap)
    | int(imgui.SelectableFlags_.allow_double_click)
    | int(imgui.SelectableFlags_.span_all_columns)
)


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
        self._kinds_key: object = None
        self._deepest = 0
        self._indent = 0.0
        self._fold_rev = 0
        self._selected_of: tuple[int, ...] = ()
        self._selected: frozenset[int] = frozenset()
        self._renaming = -1
        self._name = ""
        self._focus_name = False
        #: what the tooltip of an instance says, and of which
        self._told: tuple[object, str] = (None, "")

    def draw(self, ui: Ui) -> None:
        document = ui.session.document
        if document is None:
            empty_state(icons.TREE, "No scene is open", "Ctrl+O opens one")
            return
        self._follow(document)
        if self._selected_of is not document.selection:
            self._selected_of, self._selected = document.selection, frozenset(document.selection)
        if ui.session.ui.rename >= 0:
            self._renaming, ui.session.ui.rename = ui.session.ui.rename, -1
            self._name, self._focus_name = str(document.runtime.scene.nodes.name[self._renaming]), True
            imgui.set_window_focus()
        self.needle = search_field("##search", self.needle, f"{icons.SEARCH}  Search nodes")
        self._collect(document)
        flags = imgui.TableFlags_.scroll_y | imgui.TableFlags_.row_bg | imgui.TableFlags_.no_saved_settings
        imgui.push_style_var(imgui.StyleVar_.cell_padding, (2, 1))
        if imgui.begin_table("nodes", 2, flags):
            imgui.table_setup_column("name", imgui.TableColumnFlags_.width_stretch)
            imgui.table_setup_column("visible", imgui.TableColumnFlags_.width_fixed, em(1.6))
            scroll_to = self._scroll_target(document)
            self._indent = indent(self._deepest, imgui.get_content_region_avail().x)
            clipper = imgui.ListClipper()
            clipper.begin(len(self._rows))
            if scroll_to >= 0:
                clipper.include_item_by_index(scroll_to)
            while clipper.step():
                for i in range(clipper.display_start, clipper.display_end):
                    self._row(ui, document, self._rows[i], scroll=i == scroll_to)
            imgui.end_table()
            self._drop_on_rest(ui)
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
            self._renaming = -1
            self._rows_key = None
        if document.selection != self._selection:
            before = len(self.unfolded)
            self.unfolded |= ancestors(document, document.selection)
            self._fold_rev += len(self.unfolded) > before

    def _collect(self, document: Document) -> None:
        scene = document.runtime.scene
        key = (id(document), int(scene.structure_rev), len(scene.nodes.name), self.needle, self._fold_rev)
        if key != self._rows_key:
            self._rows_key = key
            self._rows = matching_rows(document, self.needle) if self.needle else visible_rows(document, self.unfolded)
            if self._kinds_key != key[:3]:
                self._kinds_key, self._kinds = key[:3], kinds(document)
            self._deepest = max((r.depth for r in self._rows), default=0)

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
        selected = row in self._selected
        start = imgui.get_cursor_pos_x()
        name = nodes.name[row] or f"node {row}"
        if imgui.selectable(f"##{name}-{row}", selected, _ROW, (0, imgui.get_frame_height() * 0.92))[0]:
            if imgui.get_io().key_shift and document.primary >= 0:
                self._select_between(document, document.primary, row)
            else:
                document.select(row, toggle=imgui.get_io().key_ctrl)
            self._selection = document.selection
            if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
                ui.operations.run("view.frame", ui.session)
        hovered = imgui.is_item_hovered()
        self._about_prefab(document, row)
        self._drag(ui, document, row, name)
        self._menu(ui, document, row)
        imgui.same_line(start + item.depth * self._indent)
        imgui.align_text_to_frame_padding()
        self._arrow(item)
        imgui.same_line(0, em(0.15))
        shown = bool(nodes.visible_world[row]) and bool(nodes.visible[row])
        icon, tint = KIND_ICONS[self._kinds.get(row) or ("group" if item.has_children else "")]
        color = theme.named(tint)
        source = document.runtime.scene.sources.get(row)
        if source is not None and source.extras and (ROOT in source.extras or NODE in source.extras):
            color = theme.named(PREFAB)
            icon = icons.PACKAGE if ROOT in source.extras else icon
        text(icon, color if shown else theme.FAINT)
        imgui.same_line(0, em(0.35))
        if row == self._renaming:
            self._rename_field(ui, document, row)
        else:
            if row in document.locked:
                text(icons.LOCKED, theme.FAINT)
                imgui.same_line(0, em(0.3))
            own_text(fitted(name, imgui.get_content_region_avail().x), theme.TEXT if shown else theme.FAINT)
        imgui.table_next_column()
        own = bool(nodes.visible[row])
        color = theme.FAINT if not own else theme.DIM if hovered or selected else theme.SLIDER
        if bare_button(f"{icons.VISIBLE if own else icons.HIDDEN}###eye{row}", color):
            rows = document.selection if row in document.selection else (row,)
            ui.session.set_visible(rows, not own)

    def _about_prefab(self, document: Document, row: int) -> None:
        """Over an instance: of which prefab, and what it has of its own."""
        source = document.runtime.scene.sources.get(row)
        if source is None or ROOT not in source.extras or not imgui.is_item_hovered(imgui.HoveredFlags_.delay_normal):
            return
        key = (row, document.history.revision)
        if self._told[0] != key:
            changed, removed = prefab_values.changes(document, row)
            lines = [f"{node}: {', '.join(fields)}" for node, fields in list(changed.items())[:12]]
            lines += [f"{node}: removed" for node in removed[:12]]
            own = "\n".join(lines) if lines else "nothing of its own"
            self._told = (key, f"Instance of {prefabs.path_of(document, row)}\n\n{own}")
        imgui.set_tooltip(self._told[1])

    def _select_between(self, document: Document, a: int, b: int) -> None:
        """Everything from row `a` to row `b` as the tree shows it; `b` becomes the last selected."""
        shown = [r.row for r in self._rows]
        if a not in shown or b not in shown:
            document.select(b)
            return
        low, high = sorted((shown.index(a), shown.index(b)))
        document.selection = (*(r for r in shown[low : high + 1] if r != b), b)

    def _drag(self, ui: Ui, document: Document, row: int, name: str) -> None:
        if imgui.begin_drag_drop_source(imgui.DragDropFlags_.none):
            count = len(document.selection) if row in document.selection else 1
            imgui.set_drag_drop_payload_py_id(PAYLOAD, row)
            text(name if count == 1 else f"{count} nodes")
            imgui.end_drag_drop_source()
        if imgui.begin_drag_drop_target():
            self._accept(ui, row)
            imgui.end_drag_drop_target()

    def _accept(self, ui: Ui, parent: int) -> None:
        payload = imgui.accept_drag_drop_payload_py_id(PAYLOAD)
        document = ui.session.document
        if payload is not None and document is not None:
            dragged = int(payload.data_id)
            rows = document.selection if dragged in document.selection else (dragged,)
            reparent(ui.session, rows, parent)
            if parent >= 0:
                self.unfolded.add(parent)
                self._fold_rev += 1

    def _drop_on_rest(self, ui: Ui) -> None:
        """While a row is dragged: the tree's border is the top of the tree."""
        payload = imgui.get_drag_drop_payload_py_id()
        if payload is None:
            return
        low, size = imgui.get_item_rect_min(), imgui.get_item_rect_size()
        rows = imgui.get_frame_height() * (len(self._rows) + 1)
        if size.y <= rows + em(1):
            return
        area = imgui.internal.ImRect(low.x, low.y + rows, low.x + size.x, low.y + size.y)
        if imgui.internal.begin_drag_drop_target_custom(area, imgui.get_id("rest")):
            self._accept(ui, -1)
            imgui.end_drag_drop_target()

    def _rename_field(self, ui: Ui, document: Document, row: int) -> None:
        imgui.set_next_item_width(-1)
        if self._focus_name:
            imgui.set_keyboard_focus_here()
        flags = imgui.InputTextFlags_.auto_select_all | imgui.InputTextFlags_.enter_returns_true
        entered, self._name = imgui.input_text("##rename", self._name, flags)
        left = imgui.is_item_deactivated() and not self._focus_name
        self._focus_name = False
        if entered or left:
            name = self._name.strip()
            if (
                name
                and (entered or imgui.is_item_deactivated_after_edit())
                and name != document.runtime.scene.nodes.name[row]
            ):
                ui.session.edit("nodes", "name", [row], [name], label=f"Rename {ui.session.node_name(row)}")
            self._renaming = -1

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
        for id in MENU:
            if not id:
                imgui.separator()
                continue
            operation = ui.operations[id]
            key = operation.shortcuts[0] if operation.shortcuts else ""
            if imgui.menu_item(operation.label, key, False, operation.enabled(ui.session))[0]:
                ui.operations.run(id, ui.session)
        imgui.end_popup()


PANEL = SceneTreePanel
