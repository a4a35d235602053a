"""The inspector's part on prefabs: which one the selected node came from, and what the instance has of its own, value
by value, each to be given back or to be made the prefab's."""

from __future__ import annotations

from imgui_bundle import imgui

from editor import icons, prefabs, theme
from editor.document import Document
from editor.prefab_values import LABELS, REMOVED, OwnValue, OwnValues
from editor.ui import Ui
from editor.widgets import em, fitted, flow, icon_button, own_text, section, text, tooltip

#: values that are listed before the list scrolls in a window of its own
LINES = 8


class PrefabPart:
    """Draws nothing for a node that is no part of an instance."""

    def __init__(self) -> None:
        self._own = OwnValues()

    def draw(self, ui: Ui, document: Document, row: int) -> None:
        root = prefabs.root_of(document, row)
        path = prefabs.path_of(document, root) if root >= 0 else None
        if path is None or not section(ui, f"{icons.PACKAGE}  Prefab"):
            return
        session = ui.session
        own_text(fitted(path.name, imgui.get_content_region_avail().x), theme.ACCENT)
        tooltip(str(path))
        own = self._own.of(document, root)
        for number, (id, label) in enumerate(
            (("prefab.open", "Open"), ("prefab.revert", "Revert all"), ("prefab.apply", "Apply all"))
        ):
            if number:
                flow(_button_width(label), 0.3)
            imgui.begin_disabled(bool(number) and not own)
            if imgui.button(f"{label}##{id}"):
                ui.operations.run(id, session)
            imgui.end_disabled()
            tooltip(ui.operations[id].doc)
        if row != root:
            flow(_button_width("Select the instance"), 0.3)
            if imgui.button("Select the instance"):
                document.select(root)
        if not own:
            text("Nothing of its own", theme.DIM)
        else:
            text(f"Of its own: {len(own)}", theme.DIM)
            self._list(ui, document, own)
        imgui.spacing()

    def _list(self, ui: Ui, document: Document, own: list[OwnValue]) -> None:
        line = imgui.get_frame_height_with_spacing() + imgui.get_text_line_height_with_spacing()
        imgui.begin_child("own values", (0, min(len(own), LINES) * line + em(0.3)))
        clipper = imgui.ListClipper()
        clipper.begin(len(own), line)
        while clipper.step():
            for i in range(clipper.display_start, clipper.display_end):
                imgui.push_id(i)
                self._value(ui, document, own[i])
                imgui.pop_id()
        imgui.end_child()

    @staticmethod
    def _value(ui: Ui, document: Document, value: OwnValue) -> None:
        """Two lines: whose and what, with the buttons; how it is here, and in the prefab."""
        given = {"node": value.node, "field": value.field}
        buttons = em(4.2)
        start = imgui.get_cursor_pos()
        width = imgui.get_content_region_avail().x
        imgui.align_text_to_frame_padding()
        name = value.node.rpartition("/")[2]
        label = LABELS[value.field]
        own_text(fitted(name, width - buttons - imgui.calc_text_size(label).x - em(1.0)), theme.TEXT)
        if imgui.is_item_clicked() and value.row >= 0:
            document.select(value.row)
        tooltip(f"{value.node}\nClick to select it" if value.row >= 0 else value.node)
        imgui.same_line(0, em(0.5))
        text(label, theme.ACCENT)
        imgui.same_line(start.x + width - buttons)
        if icon_button(f"{icons.RESET}###revert", "Give it back: as the prefab has it"):
            ui.operations.run("prefab.revert-value", ui.session, **given)
        imgui.same_line(0, 0)
        if icon_button(f"{icons.UP}###apply", "Apply: make it the prefab's, and so all instances'"):
            ui.operations.run("prefab.apply-value", ui.session, **given)
        half = (width - em(2.6)) / 2.0
        said = f"{fitted(value.here, half)}  ←  {fitted(value.there, half)}"
        if value.field == REMOVED:
            said = fitted("The prefab has it, this instance has not", width - em(0.6))
        imgui.set_cursor_pos_x(start.x + em(0.6))
        text(said, theme.DIM)
        tooltip(f"Here: {value.here}\nIn the prefab: {value.there}" if value.field != REMOVED else "")


def _button_width(label: str) -> float:
    return imgui.calc_text_size(label).x + 2.0 * imgui.get_style().frame_padding.x
