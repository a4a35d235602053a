"""Variants: which shader programs there are, who wants each and why, what it cost, and what it is made of."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.code.feature_work import MeasureFeatures, told, verdict_of
from editor.code.variant_rows import VariantRow, source_lines, stages_of, variant_rows
from editor.flowing import flow_button
from editor.panels.base import Panel
from editor.ui import Ui
from editor.widgets import em, empty_state, mono, pages, text, tooltip

#: what is shown of the chosen variant, beside its stages
WHY, GENERATED = "Why", "Generated"
COLUMNS = (("Effect", 1.5), ("Features", 2.0), ("Used by", 1.6), ("Time", 0.8))


class VariantsPanel(Panel):
    title: ClassVar[str] = "Variants"
    icon: ClassVar[str] = icons.VARIANTS
    dock: ClassVar[str] = "BottomRight"

    def __init__(self) -> None:
        self.chosen = 0
        self._key: object = None
        self._rows: list[VariantRow] = []
        self._source_key: object = None
        self._source: list[tuple[str, int, str]] = []
        self._views_key: object = None
        self._views: tuple[str, ...] = ()

    def draw(self, ui: Ui) -> None:
        session = ui.session
        runtime = session.document.runtime if session.document is not None else None
        library = getattr(getattr(runtime, "residency", None), "effects", None)
        if runtime is None or library is None:
            empty_state(icons.VARIANTS, "No shaders", "Open a scene to see its shader variants")
            return
        key = (id(runtime), session.image.renders, len(library.variants()), library.revision, session.shaders.problems)
        if key != self._key:
            self._key, self._rows = key, variant_rows(runtime)
        rows = self._rows
        used = sum(row.used for row in rows)
        total = sum(row.ms for row in rows)
        text(f"{len(rows)} compiled, {used} in use, {total:.0f} ms", theme.DIM)
        tooltip(f"{len(rows)} of {possible(rows)} that their effects could have")
        _measuring(ui)
        self.chosen = min(self.chosen, max(len(rows) - 1, 0))
        height = max(imgui.get_content_region_avail().y * 0.42, em(4))
        self._table(rows, height)
        if rows:
            self._details(ui, library, rows[self.chosen])

    def _table(self, rows: list[VariantRow], height: float) -> None:
        flags = imgui.TableFlags_.row_bg | imgui.TableFlags_.scroll_y | imgui.TableFlags_.resizable
        if not imgui.begin_table("variants", len(COLUMNS), flags, (0, height)):
            return
        for name, weight in COLUMNS:
            imgui.table_setup_column(name, imgui.TableColumnFlags_.width_stretch, weight)
        imgui.table_setup_scroll_freeze(0, 1)
        imgui.table_headers_row()
        for index, row in enumerate(rows):
            imgui.table_next_row()
            imgui.table_next_column()
            if imgui.selectable(f"##variant{index}", index == self.chosen, imgui.SelectableFlags_.span_all_columns)[0]:
                self.chosen = index
            imgui.same_line(0, 0)
            color = theme.ERROR if row.error else theme.TEXT if row.used else theme.FAINT
            text(f"{icons.ERROR} {row.label}" if row.error else row.label, color)
            imgui.table_next_column()
            text(", ".join(row.features) or "none", color)
            tooltip("\n".join(row.features))
            imgui.table_next_column()
            text(", ".join(row.materials) or "not in use", theme.DIM if row.used else theme.FAINT)
            tooltip("\n".join(row.materials))
            imgui.table_next_column()
            text(f"{row.ms:.0f} ms{' *' if row.loaded else ''}" if row.ms else "", theme.DIM)
            if row.loaded:
                tooltip("Taken from the program cache, not compiled")
        imgui.end_table()

    def _details(self, ui: Ui, library: Any, row: VariantRow) -> None:
        with pages("details") as shown:
            if shown:
                self._views_of(ui, library, row)

    def _views_of(self, ui: Ui, library: Any, row: VariantRow) -> None:
        if self._views_key != (self._key, row.variant):
            stages = [stage.replace("_", " ").capitalize() for stage in stages_of(library, row.variant)]
            self._views_key, self._views = (self._key, row.variant), (WHY, *reversed(stages), GENERATED)
        for view in self._views:
            if imgui.begin_tab_item(view)[0]:
                imgui.begin_child("detail", (0, 0), 0, imgui.WindowFlags_.horizontal_scrollbar)
                if view == WHY:
                    _why(ui, row)
                else:
                    self._lines(ui, library, row, view.lower().replace(" ", "_"))
                imgui.end_child()
                imgui.end_tab_item()

    def _lines(self, ui: Ui, library: Any, row: VariantRow, stage: str) -> None:
        """The flattened source; a click on a line opens the file it came from."""
        key = (self._key, row.variant, stage)
        if key != self._source_key:
            self._source_key, self._source = key, source_lines(library, row.variant, stage)
        with mono(ui):
            clipper = imgui.ListClipper()
            clipper.begin(len(self._source))
            while clipper.step():
                for index in range(clipper.display_start, clipper.display_end):
                    file, line, code = self._source[index]
                    place = f"{Path(file).name}:{line}"
                    if imgui.selectable(f"{place:>22}##line{index}", False)[0] and Path(file).is_file():
                        ui.session.open_code(Path(file), line)
                    tooltip(file)
                    imgui.same_line(em(12))
                    text(code, theme.DIM if file.startswith("<") else theme.TEXT)


def _measuring(ui: Ui) -> None:
    """The line about what features change: the button, the progress, the outcome."""
    session = ui.session
    if isinstance(session.work, MeasureFeatures):
        imgui.progress_bar(session.work.progress, (em(10), 0), "")
        imgui.same_line(0, em(0.6))
        text(session.work.text, theme.DIM)
        imgui.same_line(0, em(0.6))
        if imgui.small_button("Cancel##features"):
            ui.operations.run("view.cancel-work", session)
        return
    hint = "Switches each feature of the scene's variants off and compares the pictures, bit for bit, from three sides"
    label = f"{icons.TIMER}  Measure what features change"
    if flow_button(label, hint, first=True, enabled=session.work is None):
        ui.operations.run("view.measure-features", session)
    if session.feature_effects is not None:
        text(told(session.feature_effects), theme.DIM)
        tooltip(told(session.feature_effects))


def _why(ui: Ui, row: VariantRow) -> None:
    if row.error:
        text(row.error.split("\n")[0], theme.ERROR)
        tooltip(row.error)
    for name, reason in row.reasons:
        text(name, theme.GOOD)
        imgui.same_line(em(9))
        features = frozenset(row.features)
        found = verdict_of(ui.session.feature_effects or [], row.variant.request.effect, features, name)
        if found is not None:
            text(f"{found.verdict}:", theme.WARNING if found.covered and not found.changed else theme.FAINT)
            tooltip(f"{found.changed:,} of {found.covered:,} pixels, by {found.largest:.3g} at most")
            imgui.same_line(0, em(0.5))
        text(reason, theme.DIM)
    for name, reason in row.absent:
        text(name, theme.FAINT)
        imgui.same_line(em(9))
        text(reason, theme.FAINT)


def possible(rows: list[VariantRow]) -> int:
    """How many sets of features the effects of `rows` allow."""
    counts = {row.label: len(row.reasons) + len(row.absent) for row in rows}
    return int(sum(2**count for count in counts.values()))


PANEL = VariantsPanel
