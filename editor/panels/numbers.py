"""Numbers: NaN, infinities and values out of range, pass by pass; a click goes to the first such pixel."""

from __future__ import annotations

from typing import ClassVar

from imgui_bundle import imgui

from editor import icons, numbers, theme
from editor.flowing import button_width
from editor.panels.base import Panel
from editor.panels.timings import short_count
from editor.ui import Ui
from editor.widgets import em, empty_state, fitted, flow, flow_text, icon_button, mono, text, tooltip
from engine.report.number_check import HIGHEST, NumberReport, NumberRow

#: (heading, width in em, what it says)
COLUMNS = (
    ("Pass", 0.0, "In the order of execution, with the texture that it wrote, looked at right after it"),
    ("NaN", 2.4, "Pixels with a channel that is not a number"),
    ("Inf", 2.4, "Pixels with a channel that is infinite"),
    ("Range", 2.7, f"Pixels of textures that hold light below 0 or above {HIGHEST:g}, which is the most it may be"),
    ("First", 4.8, "The first NaN or Inf, row by row from the top left; a click on the row goes there"),
)


class NumbersPanel(Panel):
    title: ClassVar[str] = "Numbers"
    icon: ClassVar[str] = icons.NUMBERS
    dock: ClassVar[str] = "Bottom"
    opened: ClassVar[bool] = False

    def draw(self, ui: Ui) -> None:
        session = ui.session
        if session.document is None or not numbers.offered(session):
            empty_state(icons.NUMBERS, "No picture yet", "Open a scene to look for NaN and infinities in its passes")
            return
        ui.keep_live()
        self._bar(ui)
        found = numbers.report(session)
        if found is None:
            empty_state(icons.NUMBERS, "Not checked", "Switch the check on: it looks into what every pass wrote")
            return
        self._table(ui, found)

    def _bar(self, ui: Ui) -> None:
        session = ui.session
        on = numbers.checking(session)
        changed, _ = imgui.checkbox("Check every picture", on)
        tooltip("Looks into every texture right after its pass: costs time, so it is off by default")
        if changed:
            ui.operations.run("view.check-numbers", session)
        flow(button_width("Mark the pixels") + em(1.5))
        imgui.begin_disabled(not on)
        changed, _ = imgui.checkbox("Mark the pixels", session.settings.values().get("view") == numbers.VIEW)
        imgui.end_disabled()
        tooltip("The picture dimmed: magenta NaN, yellow infinite, cyan negative, orange too bright")
        if changed:
            ui.operations.run("view.mark-numbers", session)
        found = numbers.report(session)
        if found is None:
            return
        flow_text(numbers.summary(found), theme.GOOD if found.first is None else theme.ERROR)
        flow(button_width(icons.COPY), 0.6)
        if icon_button(f"{icons.COPY}##copy-numbers", "Copy as text"):
            session.ui.copy_text = "\n".join(found.lines())
            session.ui.notice = "Copied what was found"

    def _table(self, ui: Ui, found: NumberReport) -> None:
        flags = imgui.TableFlags_.row_bg | imgui.TableFlags_.no_saved_settings | imgui.TableFlags_.scroll_y
        if not imgui.begin_table("numbers", len(COLUMNS), flags):
            return
        imgui.table_setup_scroll_freeze(0, 1)
        for name, width, _doc in COLUMNS:
            flag = imgui.TableColumnFlags_.width_fixed if width else imgui.TableColumnFlags_.width_stretch
            imgui.table_setup_column(name, flag, em(width) if width else 1.0)
        imgui.table_next_row(imgui.TableRowFlags_.headers)
        for i, (name, _width, doc) in enumerate(COLUMNS):
            imgui.table_set_column_index(i)
            imgui.table_header(name)
            tooltip(doc)
        for index, row in enumerate(found.rows):
            self._row(ui, index, row, first=row is found.first)
        imgui.end_table()
        for name in found.unchecked:
            text(f"Not looked into: {name}", theme.FAINT)

    def _row(self, ui: Ui, index: int, row: NumberRow, *, first: bool) -> None:
        color = theme.ERROR if row.bad else theme.TEXT
        imgui.table_next_row()
        imgui.table_next_column()
        spans = imgui.SelectableFlags_.span_all_columns
        if imgui.selectable(f"##row{index}", False, spans)[0]:
            numbers.go_to(ui.session, row)
        if row.first is not None:
            tooltip(f"{row.pass_name}: {row.describe()}\n{row.made:,} of them made by this pass\nClick to go there")
        imgui.same_line(0, 0)
        name = f"{icons.ERROR}  {row.pass_name}" if first else row.pass_name
        text(fitted(name, imgui.get_content_region_avail().x), color)
        level = f" mip {row.level}" if row.level else ""
        imgui.same_line(0, em(0.5))
        if (room := imgui.get_content_region_avail().x) > em(2):
            text(fitted(f"{row.resource}{level}", room), theme.DIM)
        with mono(ui):
            for count, shade in (
                (row.nan, theme.ERROR), (row.inf, theme.ERROR), (row.negative + row.over, theme.WARNING),
            ):  # fmt: skip
                imgui.table_next_column()
                text(short_count(count) if count else "·", shade if count else theme.FAINT)
            imgui.table_next_column()
            if row.first is not None:
                x, y, layer = row.first
                text(f"{x}, {y}" + (f", {layer}" if layer else ""), theme.ACCENT)


PANEL = NumbersPanel
