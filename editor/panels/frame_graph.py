"""Frame graph: the passes of the last frame as boxes, their textures as lines; in grey what was left out, why, and what
it would cost."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.flowing import flow_button
from editor.graph_layout import Box, Diagram, Edge, diagram
from editor.panels.base import Panel
from editor.panels.timings import UNACCOUNTED, time_rows
from editor.strings import tr
from editor.ui import Ui
from editor.widgets import em, empty_state, fitted, flow_text, pretty, text, tooltip, wrapped
from editor.work import ForcedCost, MeasureLeftOut
from engine.framegraph.dump import extent
from engine.framegraph.resources import human_bytes, texture_bytes

BOX, GAP = (11.0, 2.9), (4.6, 0.9)
#: a box of what is left out has two lines for the reason, and one for what it would cost
TALL = 5.1
CURVE = 0.45


class FrameGraphPanel(Panel):
    title: ClassVar[str] = "Frame graph"
    icon: ClassVar[str] = icons.GRAPH
    dock: ClassVar[str] = "MainDockSpace"

    def __init__(self) -> None:
        self._plan: object = None
        self.diagram = Diagram((), (), 0, 0)
        #: index of the box under the pointer in the frame before, or -1
        self.hovered = -1

    def draw(self, ui: Ui) -> None:
        ui.keep_live()
        frame = ui.session.image.frame
        plan = getattr(getattr(frame, "graph", None), "plan", None)
        if frame is None or plan is None:
            empty_state(icons.GRAPH, "No frame yet")
            return
        if plan is not self._plan:
            self._plan, self.diagram = plan, diagram(plan.declarations, plan.left_out)
        cost = ui.session.forced_cost
        self._summary(ui, frame)
        self._measured(ui, cost if cost is not None and cost.plan is plan else None)
        if imgui.begin_child("canvas", (0, 0), 0, imgui.WindowFlags_.horizontal_scrollbar):
            self._canvas(ui, frame, plan, cost.passes if cost is not None and cost.plan is plan else {})
        imgui.end_child()

    def _summary(self, ui: Ui, frame: Any) -> None:
        graph, plan, stats = frame.graph, frame.graph.plan, frame.stats
        saved = sum(b.saved for b in self.diagram.boxes)
        text(f"{len(plan.passes)} of {len(plan.passes) + len(plan.left_out)} passes run", theme.TEXT)
        tooltip("Grey below: what this scene does not need, why not, and what that saves")
        line = f"{human_bytes(graph.transient_bytes)} of shared textures"
        flow_text(line, theme.DIM, f"{human_bytes(graph.unaliased_bytes)} if each had memory of its own")
        if saved:
            flow_text(
                f"{human_bytes(saved)} not made", theme.GOOD, "Textures of the passes that this scene does not need"
            )
        rest = time_rows(stats)[-1]
        flow_text(
            f"{stats.total_ms:.2f} ms, {rest.ms:.2f} {UNACCOUNTED}", theme.DIM,
            "What no pass and no stage accounts for: submitting, waiting, reading back",
        )  # fmt: skip
        runtime = ui.session.document.runtime if ui.session.document is not None else None
        renderer = getattr(runtime, "renderer", None)
        choice, held = getattr(renderer, "path", None), getattr(renderer, "hysteresis", None)
        if choice is not None:
            flow_text(f"path {choice.path}", theme.DIM, f"How local lights reach the surfaces: {choice.reason}")
        if held is not None and held.held:
            flow_text(
                f"kept on: {', '.join(pretty(n).lower() for n in held.held)}", theme.WARNING,
                f"Not needed now, but it comes and goes: it stays until it was not needed for {held.hold} frames",
            )  # fmt: skip

    def _measured(self, ui: Ui, cost: ForcedCost | None) -> None:
        """The line about what is left out: the button, the progress, the outcome."""
        session = ui.session
        if isinstance(session.work, MeasureLeftOut):
            imgui.progress_bar(session.work.progress, (em(12), 0), "")
            imgui.same_line(0, em(0.6))
            text(session.work.text, theme.DIM)
            imgui.same_line(0, em(0.6))
            if imgui.small_button("Cancel##measure"):
                ui.operations.run("view.cancel-work", session)
            return
        if imgui.button(f"{icons.COPY}##copy-graph"):
            session.ui.copy_text = session.image.frame.graph.dump()
            session.ui.notice = "Copied the frame graph"
        tooltip("Copy as text")
        hint = "Draws some frames with nothing left out, and as many as it is, and compares"
        if flow_button(f"{icons.TIMER}  Measure what is left out", hint, enabled=session.work is None):
            ui.operations.run("view.measure-left-out", session)
        if cost is None:
            return
        gain = cost.forced_ms - cost.pruned_ms
        flow_text(
            f"{cost.pruned_ms:.2f} ms, with everything {cost.forced_ms:.2f} ms", theme.TEXT,
            f"Medians of {cost.frames} frames each", gap=0.8,
        )  # fmt: skip
        share = abs(gain) / max(cost.forced_ms, 1e-9)
        if gain > cost.noise_ms:
            flow_text(
                f"leaving out saves {gain:.2f} ms ({share:.0%})", theme.GOOD, f"± {cost.noise_ms:.2f} ms", gap=0.5
            )
        else:
            flow_text(
                "what it saves is within the noise", theme.DIM, f"{gain:+.2f} ms, ± {cost.noise_ms:.2f} ms", gap=0.5
            )

    def _canvas(self, ui: Ui, frame: Any, plan: Any, costs: Mapping[str, float]) -> None:
        origin = imgui.get_cursor_screen_pos()
        lines = imgui.get_window_draw_list()
        drawing = self.diagram
        times = {p.name: p.ms for p in frame.stats.passes}
        kinds = {p.name: p.kind for p in frame.stats.passes}
        longest = max([*times.values(), 1e-9])
        rects = [self._rect(origin, box) for box in drawing.boxes]
        lit = {e for e in drawing.edges if self.hovered in (e.start, e.end)}
        for edge in sorted(drawing.edges, key=lambda e: e in lit):
            self._edge(lines, edge, rects, plan, bright=edge in lit)
        hovered = -1
        for i, (box, rect) in enumerate(zip(drawing.boxes, rects, strict=True)):
            imgui.set_cursor_screen_pos(rect[:2])
            imgui.invisible_button(f"##pass-{box.name}", (rect[2] - rect[0], rect[3] - rect[1]))
            if imgui.is_item_hovered():
                hovered = i
                self._tooltip(box, plan, costs if box.reason else times)
            if imgui.is_item_clicked() and (shown := _readable(box, plan)):
                ui.operations.run("texture.show-target", ui.session, name=shown)
            told = ""
            if not box.reason:
                size = sum(texture_bytes(plan.descs[name]) for name in box.writes if name in plan.descs)
                kind = kinds.get(box.name, "")
                told = f"{times[box.name]:.2f} ms {kind}" if box.name in times else ""
                told = "   ".join(part for part in (told, human_bytes(size) if size else "") if part)
            self._box(
                lines, box, rect, times.get(box.name), longest, told=told, bright=i == self.hovered,
                cost=costs.get(box.name),
            )  # fmt: skip
        self.hovered = hovered
        imgui.set_cursor_screen_pos(origin)
        below = (drawing.rows - drawing.rows_running) * (TALL + GAP[1])
        height = drawing.rows_running * (BOX[1] + GAP[1]) + below + 1.4
        imgui.dummy((em(drawing.columns * (BOX[0] + GAP[0])), em(height)))

    def _rect(self, origin: Any, box: Box) -> tuple[float, float, float, float]:
        x = origin.x + em(0.4 + box.column * (BOX[0] + GAP[0]))
        top = self.diagram.rows_running * (BOX[1] + GAP[1])
        if box.reason:  # below all that run, and taller
            y = origin.y + em(1.2 + top + (box.row - self.diagram.rows_running) * (TALL + GAP[1]))
            return x, y, x + em(BOX[0]), y + em(TALL)
        y = origin.y + em(0.4 + box.row * (BOX[1] + GAP[1]))
        return x, y, x + em(BOX[0]), y + em(BOX[1])

    def _box(
        self, lines: Any, box: Box, rect: tuple[float, float, float, float], ms: float | None, longest: float,
        *, told: str = "", bright: bool, cost: float | None = None,
    ) -> None:  # fmt: skip
        x0, y0, x1, y1 = rect
        out = bool(box.reason)
        lines.add_rect_filled((x0, y0), (x1, y1), theme.u32(theme.FRAME if out else theme.RAISED), em(0.3))
        if ms is not None:  # its share of the longest pass, along the lower edge
            lines.add_rect_filled(
                (x0, y1 - em(0.22)), (x0 + (x1 - x0) * ms / longest, y1), theme.u32(theme.ACCENT), em(0.1)
            )
        border = theme.ACCENT if bright else theme.FAINT
        lines.add_rect((x0, y0), (x1, y1), theme.u32((*border[:3], 0.9 if bright else 0.45)), em(0.3))
        room = x1 - x0 - em(0.9)
        name = fitted(box.name, room)
        lines.add_text((x0 + em(0.45), y0 + em(0.3)), theme.u32(theme.FAINT if out else theme.TEXT), name)
        rows = _two_lines(tr(box.reason), room) if out else [fitted(told, room)]
        for i, row in enumerate(rows):
            at = (x0 + em(0.45), y0 + em(1.45 + 1.1 * i))
            lines.add_text(at, theme.u32(theme.FAINT if out else theme.DIM), row)
        if out:
            parts = [f"{cost:.2f} ms"] if cost is not None else []
            parts += [human_bytes(box.saved)] if box.saved else []
            line = f"saves {', '.join(parts)}" if parts else "saves no texture"
            line = line if imgui.calc_text_size(line).x <= room else line.removeprefix("saves ")
            lines.add_text(
                (x0 + em(0.45), y0 + em(3.7)), theme.u32(theme.GOOD if parts else theme.FAINT), fitted(line, room)
            )

    def _edge(self, lines: Any, edge: Edge, rects: list[Any], plan: Any, *, bright: bool) -> None:
        a, b = rects[edge.start], rects[edge.end]
        start, end = (a[2], 0.5 * (a[1] + a[3])), (b[0], 0.5 * (b[1] + b[3]))
        bend = max(em(2.0), abs(end[0] - start[0]) * CURVE)
        color = theme.ACCENT if bright else theme.WARNING if edge.history else theme.INFO
        tint = theme.u32((*color[:3], 1.0 if bright else 0.55))
        lines.add_bezier_cubic(start, (start[0] + bend, start[1]), (end[0] - bend, end[1]), end, tint, em(0.13))
        lines.add_circle_filled(end, em(0.18), tint)
        adjacent = abs(end[0] - start[0] - em(GAP[0])) < em(0.5)
        if bright or adjacent:
            label = fitted(", ".join(edge.resources), em(GAP[0] - 0.8) if adjacent else em(12))
            size = imgui.calc_text_size(label)
            x = 0.5 * (start[0] + end[0]) - 0.5 * size.x
            y = 0.5 * (start[1] + end[1]) - size.y - em(0.1)
            lines.add_text((x, y), theme.u32(theme.TEXT if bright else theme.DIM), label)

    def _tooltip(self, box: Box, plan: Any, times: Mapping[str, float]) -> None:
        imgui.begin_tooltip()
        imgui.text_unformatted(box.name)
        if box.reason:
            text(f"Left out: {box.reason}", theme.DIM)
            text(f"Saves {human_bytes(box.saved)} of textures", theme.GOOD)
            known = box.name in times
            text(
                f"It would cost {times[box.name]:.3f} ms, measured with everything forced" if known
                else "What it would cost in time is not measured yet", theme.GOOD if known else theme.FAINT,
            )  # fmt: skip
        else:
            declaration = next(d for d in plan.declarations if d.name == box.name)
            if box.name in times:
                text(f"{times[box.name]:.3f} ms", theme.ACCENT)
            for verb, names in (
                ("reads", declaration.reads), ("writes", declaration.writes), ("from the frame before",
                declaration.histories), ("shows", declaration.presents),
            ):  # fmt: skip
                for name in names:
                    desc = plan.descs.get(name)
                    what = (
                        "" if desc is None else f"  {desc.format}  {extent(desc)}  {human_bytes(texture_bytes(desc))}"
                    )
                    text(f"{verb} {name}{what}", theme.DIM)
            if _readable(box, plan):
                text("A click shows what it writes", theme.FAINT)
        imgui.end_tooltip()


def _readable(box: Box, plan: Any) -> str:
    """The first texture that the pass writes and that can be looked at, or ''."""
    return next((name for name in box.writes if name in plan.descs and plan.descs[name].samples == 1), "")


def _two_lines(value: str, width: float) -> list[str]:
    """`value` in one line or two, the second cut where it does not fit."""
    rows = wrapped(value, width)
    return rows if len(rows) < 2 else [fitted(rows[0], width), fitted(" ".join(rows[1:]), width)]


PANEL = FrameGraphPanel
