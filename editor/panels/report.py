"""Report: error against run time on the open scene. What each setting costs and buys, and what to change."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from imgui_bundle import imgui, implot

from editor import icons, report, theme
from editor.flowing import button_width, flow_button
from editor.panels.base import Panel
from editor.report import ReportRun
from editor.ui import Ui
from editor.widgets import bold, em, empty_state, fitted, flow, flow_text, mono, text, tooltip
from editor.work_precision import Diagram, diagram, nearest, ticks
from engine.report.advice import Advice, advise
from engine.report.records import Result

LIST_WIDTH = 15.0
#: in a panel narrower than this, em, the list of experiments is behind a button
NARROW_REPORT = 30.0
#: how a kind of advice is said and coloured
KINDS = {
    "take": ("take it", "GOOD"), "cheaper": ("cheaper", "INFO"), "better": ("better", "INFO"),
    "dominated": ("dominated", "FAINT"), "same": ("no difference", "FAINT"),
}  # fmt: skip


class ReportPanel(Panel):
    title: ClassVar[str] = "Report"
    icon: ClassVar[str] = icons.REPORT
    dock: ClassVar[str] = "MainDockSpace"

    def __init__(self) -> None:
        self.chosen = report.OWN
        self.quick = True
        self.diagram = Diagram()
        self.advice: list[Advice] = []
        self._offers: list[Any] = []
        self._answers: list[report.Answer] = []
        self._offered_for: object = None
        self._made_for: tuple[object, ...] = ()
        self._fit = True

    def draw(self, ui: Ui) -> None:
        session = ui.session
        if session.document is None:
            empty_state(icons.REPORT, "Nothing to measure", "Open a scene: what its settings cost and buy shows here")
            return
        if self._offered_for is not session.document:
            self._offered_for, self._offers = session.document, report.offers(session)
            names = [o.name for o in self._offers if not o.why_not]
            self.chosen = self.chosen if self.chosen in names else next(iter(names), "")
        if not self._offers:
            empty_state(icons.REPORT, "Nothing to measure", "This device makes no pictures")
            return
        room = imgui.get_content_region_avail()
        if room.x < em(NARROW_REPORT):  # no room for a list beside the result
            self._choice(ui)
        else:
            width = min(em(LIST_WIDTH), 0.36 * room.x)
            if imgui.begin_child("offers", (width, 0), imgui.ChildFlags_.borders):
                self._list(ui)
            imgui.end_child()
            imgui.same_line()
        if imgui.begin_child("result"):
            self._result(ui)
        imgui.end_child()

    # --- the list ---

    def _choice(self, ui: Ui) -> None:
        """The list behind a button, over the whole width."""
        now = next((o.title for o in self._offers if o.name == self.chosen), "")
        imgui.set_next_item_width(-1)
        if imgui.begin_combo("##offers", now, imgui.ComboFlags_.height_large):
            self._list(ui)
            imgui.end_combo()

    def _list(self, ui: Ui) -> None:
        for own, heading in ((True, "This scene"), (False, "Methods")):
            offers = [o for o in self._offers if o.own_scene == own]
            if offers:
                imgui.separator_text(heading)
            for offer in offers:
                done = offer.name in ui.session.reports
                label = f"{icons.REPORT}  {offer.title}" if done else offer.title
                shown = fitted(label, imgui.get_content_region_avail().x)
                imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(theme.FAINT if offer.why_not else theme.TEXT)))
                if imgui.selectable(f"{shown}###offer-{offer.name}", offer.name == self.chosen)[0]:
                    self.chosen = offer.name
                imgui.pop_style_color()
                why = f"\nNot here: {offer.why_not}" if offer.why_not else ""
                tooltip(f"{offer.title}\n{offer.method}\nTruth: {offer.truth}{why}")

    # --- one experiment ---

    def _result(self, ui: Ui) -> None:
        session = ui.session
        offer = next((o for o in self._offers if o.name == self.chosen), None)
        if offer is None:
            return
        with bold(ui):
            text(offer.title)
        self._bar(ui, offer)
        running = (
            session.work if isinstance(session.work, ReportRun) and session.work.offer.name == offer.name else None
        )
        result: Result | None = session.reports.get(offer.name)
        if running is not None:
            self._judged(ui, running)
            return
        if result is None:
            empty_state(icons.REPORT, "Not measured yet", offer.why_not or f"Truth: {offer.truth}")
            return
        self._prepare(ui, result)
        height = max(em(13), imgui.get_content_region_avail().y * 0.5)
        self._plot(ui, result, height)
        self._answer_rows(ui)
        self._table(ui, result)

    def _bar(self, ui: Ui, offer: Any) -> None:
        session = ui.session
        if session.work is not None:
            imgui.progress_bar(session.work.progress, (em(14), 0), f"{session.work.progress:.0%}")
            flow(em(4), 0.5)
            if imgui.small_button("Cancel##report"):
                ui.operations.run("view.cancel-work", session)
            flow_text(fitted(session.work.text, em(24)), theme.DIM, gap=0.5)
            return
        hint = offer.why_not or "Runs in small steps; the window stays usable, and it can be called off"
        if flow_button(f"{icons.PLAY}  Measure##measure", hint, first=True, enabled=not offer.why_not):
            report.start(session, offer.name, quick=self.quick)
        flow(button_width("Quick") + em(1.5), 0.8)
        _changed, self.quick = imgui.checkbox("Quick", self.quick)
        tooltip("Fewer and smaller pictures: seconds instead of minutes, wider intervals")
        hint = "Everything measured so far as report.html and report.json, as `lucarna report` writes them"
        if flow_button(f"{icons.SAVE}  Write page##write", hint, gap=0.8, enabled=bool(session.reports)):
            ui.operations.run("report.write", session)

    def _judged(self, ui: Ui, running: ReportRun) -> None:
        """While it runs: what is judged so far."""
        imgui.spacing()
        points = running.points
        if not points:
            text("The truth is being made…", theme.DIM)
        for point in points[-12:]:
            metric, error = next(iter(point.error.items()), ("", 0.0))
            with mono(ui):
                text(f"{error:10.3g} {metric}", theme.DIM)
            imgui.same_line(0, em(0.8))
            text(fitted(report.changed(point.knobs, {}), imgui.get_content_region_avail().x))

    def _prepare(self, ui: Ui, result: Result) -> None:
        name, key = self.chosen, (result, ui.session.settings.key())
        if len(self._made_for) == 2 and self._made_for[0] is result and self._made_for[1] == key[1]:
            return
        if not self._made_for or self._made_for[0] is not result:
            self._fit = True
            self.advice, self._answers = advise(result), report.answers(result)
        self._made_for = key
        floors = [f.value for f in (result.noise_floor, result.format_floor) if f is not None]
        session = ui.session
        own = session.report_settings.get(name) is not None and result.default.keys() == {"setting", "value"}
        default = report.default_point(result)
        self.diagram = diagram(
            result.points, result.metric,
            (lambda p: report.is_current(session, name, p)) if own else (lambda p: p is default), floors,
        )  # fmt: skip

    # --- the plot ---

    def _plot(self, ui: Ui, result: Result, height: float) -> None:
        shown = self.diagram
        if shown.empty:
            text("Nothing here has a time: see the table", theme.DIM)
            return
        ensure_context()
        if not implot.begin_plot(
            "##work-precision", (-1, height), implot.Flags_.no_menus | implot.Flags_.no_box_select
        ):
            return
        implot.setup_axes("ms", f"{result.metric} [{result.unit}]" if result.unit else result.metric)
        implot.setup_axis_scale(implot.ImAxis_.x1, implot.Scale_.log10)
        implot.setup_axis_scale(implot.ImAxis_.y1, implot.Scale_.log10)
        cond = implot.Cond_.always if self._fit else implot.Cond_.once
        implot.setup_axes_limits(*shown.limits, cond)
        self._fit = False
        for axis, low, high in ((implot.ImAxis_.x1, *shown.limits[:2]), (implot.ImAxis_.y1, *shown.limits[2:])):
            values = ticks(low, high)
            implot.setup_axis_ticks(axis, values, [f"{v:g}" for v in values], False)
        implot.setup_legend(implot.Location_.north_east, implot.LegendFlags_.outside)
        self._floors(result)
        x, y = shown.front
        if len(x) > 1:
            implot.plot_stairs("front", x, y, spec=_spec(theme.DIM, 2.0))
        for i, series in enumerate(shown.series):
            color = theme.SERIES[i % len(theme.SERIES)]
            alone = len(series.points) == 1 and len(shown.series) > 1
            name = f"##{series.name}" if alone else series.name.replace("_", " ") or result.method
            implot.plot_error_bars(f"##bars{i}", series.x, series.y, series.low, series.high, spec=_bars(color))
            implot.plot_line(
                name, series.x, series.y, spec=_spec(color, 1.0, marker=implot.Marker_.circle, size=em(0.24))
            )
        if len(x):
            implot.plot_scatter("##front", x, y, spec=_ring(theme.TEXT, em(0.42)))
        if shown.current is not None:
            now = (np.array([shown.current[0]]), np.array([shown.current[1]]))
            implot.plot_scatter("now", *now, spec=_spec(theme.ACCENT, 2.0, marker=implot.Marker_.diamond, size=em(0.5)))
        self._hover(ui, result)
        implot.end_plot()

    def _floors(self, result: Result) -> None:
        for name, floor in (("noise floor", result.noise_floor), ("format floor", result.format_floor)):
            if floor is not None and floor.value > 0.0:
                lines = _spec(theme.FAINT, 1.0)
                lines.flags = implot.InfLinesFlags_.horizontal
                implot.plot_inf_lines(name, np.array([floor.value]), spec=lines)

    def _hover(self, ui: Ui, result: Result) -> None:
        if not implot.is_plot_hovered():
            return
        mouse = imgui.get_io().mouse_pos

        def place(x: float, y: float) -> tuple[float, float]:
            pixel = implot.plot_to_pixels(x, y)
            return float(pixel.x), float(pixel.y)

        point = nearest(self.diagram, place, (mouse.x, mouse.y), em(0.9))
        if point is None or point.ms is None:
            return
        error = point.error[result.metric]
        lines = [report.changed(point.knobs, {}), f"{point.ms.median:.3g} ms (quartiles {point.ms.low:.3g} to "
                 f"{point.ms.high:.3g}, {point.ms.n} runs)", f"{error:.3g} {result.unit} {result.metric}"]  # fmt: skip
        lines.append("on the front" if point.front else "dominated")
        if report.settable(ui.session, self.chosen, point.knobs):
            lines.append("Click to set it")
            if imgui.is_mouse_clicked(imgui.MouseButton_.left):
                report.apply(ui.session, self.chosen, point.knobs)
        imgui.set_tooltip("\n".join(lines))

    # --- words and rows ---

    def _answer_rows(self, ui: Ui) -> None:
        imgui.spacing()
        for index, answer in enumerate(self._answers):
            text(answer.question, theme.DIM)
            imgui.push_text_wrap_pos(0.0)
            text(answer.text, theme.GOOD if answer.good else theme.TEXT)
            imgui.pop_text_wrap_pos()
            values = report.settable(ui.session, self.chosen, answer.knobs)
            if values:
                flow(em(4), 0.5)
                if imgui.small_button(f"Apply##answer{index}"):
                    report.apply(ui.session, self.chosen, answer.knobs)
                tooltip(f"Sets {report.changed(values, {})}; undo takes it back")

    def _table(self, ui: Ui, result: Result) -> None:
        rows = [(a.kind, a.knobs, a) for a in self.advice]
        flags = imgui.TableFlags_.row_bg | imgui.TableFlags_.no_saved_settings
        if rows and imgui.begin_table("advice", 5, flags):
            fixed = imgui.TableColumnFlags_.width_fixed
            imgui.table_setup_column("Setting", imgui.TableColumnFlags_.width_stretch)
            for name, width in (("ms", 4.6), (result.unit or "error", 5.4), ("against now", 6.4), ("##apply", 3.4)):
                imgui.table_setup_column(name, fixed, em(width))
            imgui.table_headers_row()
            for index, (kind, knobs, advice) in enumerate(rows):
                self._advice_row(ui, result, index, kind, knobs, advice)
            imgui.end_table()
        for omission in result.omitted:
            text(fitted(f"Left out: {omission.what}: {omission.why}", imgui.get_content_region_avail().x), theme.FAINT)
            tooltip(omission.why)

    def _advice_row(self, ui: Ui, result: Result, index: int, kind: str, knobs: Any, advice: Advice) -> None:
        word, tint = KINDS[kind]
        color = theme.named(tint)
        imgui.table_next_row()
        imgui.table_next_column()
        text(fitted(report.changed(knobs, result.default), imgui.get_content_region_avail().x), color)
        tooltip(f"{report.changed(knobs, {})}\n{advice.text}")
        with mono(ui):
            imgui.table_next_column()
            text(_signed(-advice.ms_saved), theme.DIM if advice.sure else theme.FAINT)
            tooltip("" if advice.sure else "Not to be told from noise")
            imgui.table_next_column()
            text(_signed(-advice.error_removed), theme.DIM)
        imgui.table_next_column()
        text(word, color)
        imgui.table_next_column()
        if report.settable(ui.session, self.chosen, knobs) and imgui.small_button(f"Apply##{index}"):
            report.apply(ui.session, self.chosen, knobs)


def _signed(value: float) -> str:
    return f"{value:+.2g}" if value else "0"


def ensure_context() -> None:
    """The plots' own state, made when the first one is drawn."""
    if implot.get_current_context() is None:
        implot.create_context()


def drop_context() -> None:
    """Free it, before the window goes."""
    if implot.get_current_context() is not None:
        implot.destroy_context()


def _spec(color: theme.Rgba, weight: float, *, marker: int | None = None, size: float = 4.0) -> Any:
    spec = implot.Spec()
    spec.line_color = imgui.ImVec4(*color)
    spec.line_weight = weight
    if marker is not None:
        spec.marker = marker
        spec.marker_size = size
        spec.marker_fill_color = spec.marker_line_color = imgui.ImVec4(*color)
    return spec


def _ring(color: theme.Rgba, size: float) -> Any:
    spec = _spec(color, 2.0, marker=implot.Marker_.circle, size=size)
    spec.marker_fill_color = imgui.ImVec4(0, 0, 0, 0)
    return spec


def _bars(color: theme.Rgba) -> Any:
    spec = _spec((*color[:3], 0.5), 1.0)
    spec.flags = implot.ErrorBarsFlags_.horizontal
    return spec


PANEL = ReportPanel
