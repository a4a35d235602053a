"""Asset report: what the scene is made of, how much memory that takes, and what is wrong with it. A click on a mesh or
a material selects what wears it, one on a texture shows it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.asset_report import AssetReport, as_text, asset_report, nodes_of
from editor.panels.base import Panel
from editor.panels.log import LOOKS
from editor.ui import Ui
from editor.widgets import (
    em,
    empty_state,
    fitted,
    icon_button,
    mono,
    pages,
    property_grid,
    property_text,
    text,
    tooltip,
    wrapped_text,
)
from engine.framegraph.resources import human_bytes

#: heading, width in em (0: what is left), the value to sort by, as text
Column = tuple[str, float, Callable[[Any], Any], Callable[[Any], str]]


def _count(name: str) -> tuple[Callable[[Any], Any], Callable[[Any], str]]:
    return (lambda row: getattr(row, name)), (lambda row: f"{getattr(row, name):,}")


def _bytes(name: str) -> tuple[Callable[[Any], Any], Callable[[Any], str]]:
    return (lambda row: getattr(row, name)), (lambda row: human_bytes(getattr(row, name)))


def _name(row: Any) -> str:
    return str(row.name)


MESHES: tuple[Column, ...] = (
    ("Mesh", 0.0, _name, _name), ("Memory", 5.0, *_bytes("bytes")), ("Triangles", 5.0, *_count("triangles")),
    ("Vertices", 5.0, *_count("vertices")), ("Uses", 3.4, *_count("uses")),
)  # fmt: skip
TEXTURES: tuple[Column, ...] = (
    ("Texture", 0.0, _name, _name), ("Memory", 5.0, *_bytes("bytes")),
    ("Size", 6.4, lambda t: t.width * t.height, lambda t: f"{t.width} × {t.height}"),
    ("Format", 5.6, lambda t: t.format, lambda t: t.format), ("Mips", 3.2, *_count("mips")),
    ("On disk", 5.0, *_bytes("disk")),
)  # fmt: skip
MATERIALS: tuple[Column, ...] = (
    ("Material", 0.0, _name, _name), ("Memory", 5.0, *_bytes("bytes")), ("Textures", 4.6, *_count("textures")),
    ("Effect", 5.0, lambda m: m.effect, lambda m: m.effect), ("Parts", 3.4, *_count("parts")),
)  # fmt: skip


class AssetReportPanel(Panel):
    title: ClassVar[str] = "Asset report"
    icon: ClassVar[str] = icons.PACKAGE
    dock: ClassVar[str] = "Bottom"
    opened: ClassVar[bool] = False

    def __init__(self) -> None:
        self.report = AssetReport()
        self._key: object = None

    def draw(self, ui: Ui) -> None:
        document = ui.session.document
        if document is None:
            empty_state(icons.PACKAGE, "Nothing open", "What a scene is made of and takes shows here")
            return
        key = (id(document.runtime), document.history.revision, document.runtime.residency.structure_rev)
        if key != self._key:
            self._key, self.report = key, asset_report(document)
        report = self.report
        if icon_button(f"{icons.COPY}##copy-assets", "Copy as text"):
            ui.session.ui.copy_text = as_text(report, document.name)
            ui.session.ui.notice = "Copied the asset report"
        imgui.same_line(0, em(0.4))
        total = f"{report.totals[0][1]}, {sum(report.counts.values())} findings"
        text(fitted(total, imgui.get_content_region_avail().x), theme.DIM)
        with pages("report") as shown:
            if shown:
                self._pages(ui, report)

    def _pages(self, ui: Ui, report: AssetReport) -> None:
        for title, draw in (
            ("All", lambda: self._totals(report)),
            ("Meshes##tab", lambda: self._table(ui, "meshes", MESHES, report.meshes)),
            ("Textures##tab", lambda: self._table(ui, "textures", TEXTURES, report.textures)),
            ("Materials##tab", lambda: self._table(ui, "materials", MATERIALS, report.materials)),
            ("Findings##tab", lambda: self._findings(report)),
        ):
            if imgui.begin_tab_item(title)[0]:
                draw()
                imgui.end_tab_item()

    @staticmethod
    def _totals(report: AssetReport) -> None:
        with property_grid("totals") as shown:
            for what, amount, doc in report.totals if shown else ():
                property_text(what, amount, doc)

    def _table(self, ui: Ui, name: str, columns: Sequence[Column], rows: Sequence[Any]) -> None:
        flags = (
            imgui.TableFlags_.row_bg | imgui.TableFlags_.sortable | imgui.TableFlags_.scroll_y
            | imgui.TableFlags_.scroll_x | imgui.TableFlags_.resizable | imgui.TableFlags_.no_saved_settings
        )  # fmt: skip
        room = imgui.get_content_region_avail().x - em(sum(width + 0.9 for _h, width, _v, _t in columns) + 1.5)
        if not imgui.begin_table(name, len(columns), flags):
            return
        imgui.table_setup_scroll_freeze(1, 1)
        for heading, width, _value, _text in columns:
            flag = imgui.TableColumnFlags_.width_fixed.value
            if heading == "Memory":
                flag |= imgui.TableColumnFlags_.default_sort | imgui.TableColumnFlags_.prefer_sort_descending
            imgui.table_setup_column(heading, flag, em(width) if width else max(room, em(9)))
        imgui.table_headers_row()
        ordered = _sorted(rows, columns)
        clipper = imgui.ListClipper()
        clipper.begin(len(ordered))
        while clipper.step():
            for row in ordered[clipper.display_start : clipper.display_end]:
                self._row(ui, name, columns, row)
        imgui.end_table()

    def _row(self, ui: Ui, name: str, columns: Sequence[Column], row: Any) -> None:
        imgui.table_next_row()
        imgui.table_next_column()
        clicked = imgui.selectable(f"##{name}{id(row)}", False, imgui.SelectableFlags_.span_all_columns)[0]
        tooltip(_told(name, row))
        imgui.same_line(0, 0)
        text(fitted(columns[0][3](row), imgui.get_content_region_avail().x))
        for _heading, _width, _value, shown in columns[1:]:
            imgui.table_next_column()
            with mono(ui):
                text(shown(row), theme.DIM)
        if not clicked:
            return
        document = ui.session.document
        assert document is not None
        if name == "textures":
            ui.operations.run("texture.show", ui.session, path=Path(row.path))
        else:
            which = {"mesh": row.mesh} if name == "meshes" else {"material": row.material}
            ui.operations.run("select.nodes", ui.session, nodes=nodes_of(document, **which))

    @staticmethod
    def _findings(report: AssetReport) -> None:
        if not report.findings:
            text("No warnings", theme.GOOD)
        for found in report.findings:
            icon, tint, _name = LOOKS[found.severity]
            text(icon, theme.named(tint))
            imgui.same_line(0, em(0.5))
            place = f"{found.where}: " if str(found.where) else ""
            wrapped_text(f"{place}{found.message}")
            if found.hint:
                wrapped_text(f"→ {found.hint}", theme.INFO)


def _sorted(rows: Sequence[Any], columns: Sequence[Column]) -> list[Any]:
    """In the order that the heading says; as it came where none does."""
    specs = imgui.table_get_sort_specs()
    if specs is None or not specs.specs_count:
        return list(rows)
    spec = specs.get_specs(0)
    value = columns[spec.column_index][2]
    return sorted(rows, key=value, reverse=spec.get_sort_direction() == imgui.SortDirection.descending)


def _told(name: str, row: Any) -> str:
    if name == "meshes":
        return f"{row.name}\n{row.parts} parts; {', '.join(row.streams)}\nA click selects what shows it"
    if name == "textures":
        return f"{row.path}\n" + "\n".join(row.users) + "\nA click shows it"
    return f"{row.name}\nA click selects what wears it"


PANEL = AssetReportPanel
