"""What every page of the timeline shares: the ruler, the playhead, in and out points, zooming and scrubbing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from imgui_bundle import imgui

from editor import theme
from editor.animating.time_scale import TimeScale, label
from editor.session import Session
from editor.ui import Ui
from editor.widgets import em

#: how near, in em, the pointer must be to an edge to take it
GRIP = 0.45


@dataclass(slots=True)
class Canvas:
    """The area of rows in the window, imgui units; `names`: width of the column of names at its left."""

    x: float
    y: float
    width: float
    height: float
    names: float
    ruler: float
    scale: TimeScale

    @property
    def left(self) -> float:
        """Where time begins."""
        return self.x + self.names

    def px(self, time: float) -> float:
        return self.left + self.scale.x(time)

    def time(self, x: float) -> float:
        return self.scale.time(x - self.left)

    @property
    def span(self) -> float:
        return max(self.width - self.names, 1.0)

    def holds(self, x: float, y: float) -> bool:
        return self.left <= x <= self.x + self.width and self.y + self.ruler <= y <= self.y + self.height


def begin_canvas(ui: Ui, duration: float, *, markers: bool = False) -> Canvas:
    """Take what is left of the window as one item that reacts to the pointer; `markers`: with room for their names."""
    view = ui.session.animating
    avail = imgui.get_content_region_avail()
    at = imgui.get_cursor_screen_pos()
    names = min(em(11), 0.3 * avail.x)
    canvas = Canvas(at.x, at.y, max(avail.x, 50.0), max(avail.y, 40.0), names, em(2.3 if markers else 1.5), view.scale)
    if not view.fitted or (not view.zoomed and abs(view.fitted_width - canvas.span) > 1.0):
        view.scale.fit(duration, canvas.span)
        view.fitted, view.zoomed, view.fitted_width = True, False, canvas.span
    imgui.invisible_button("##canvas", (canvas.width, canvas.height))
    imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
    if imgui.is_item_hovered():
        io = imgui.get_io()
        if io.mouse_wheel and io.mouse_pos.x >= canvas.left:
            if io.key_shift:
                view.scale.pan(io.mouse_wheel * em(3))
                view.zoomed = True
            else:
                view.zoomed = True
                view.scale.zoom(1.2**io.mouse_wheel, io.mouse_pos.x - canvas.left)
        if imgui.is_mouse_down(imgui.MouseButton_.middle):
            view.scale.pan(io.mouse_delta.x)
            view.zoomed = view.zoomed or io.mouse_delta.x != 0.0
    return canvas


def draw_ruler(session: Session, canvas: Canvas) -> None:
    """Ticks with their times, and the stretch between the in and out points."""
    lines, playback = imgui.get_window_draw_list(), session.playback
    top, bottom = canvas.y, canvas.y + canvas.height
    right = canvas.x + canvas.width
    lines.add_rect_filled((canvas.left, top), (right, top + canvas.ruler), theme.u32(theme.RAISED))
    lines.push_clip_rect((canvas.left, top), (right, bottom), True)
    step = canvas.scale.step()
    for tick in canvas.scale.ticks(canvas.span):
        x = canvas.px(tick)
        lines.add_line((x, top + em(0.8)), (x, bottom), theme.u32((1, 1, 1, 0.07)))
        lines.add_text((x + em(0.2), top + em(0.1)), theme.u32(theme.DIM), label(tick, step))
    low, high = canvas.px(playback.start), canvas.px(playback.stop)
    dark = theme.u32((0, 0, 0, 0.35))
    lines.add_rect_filled((canvas.left, top), (max(low, canvas.left), bottom), dark)
    lines.add_rect_filled((max(high, canvas.left), top), (right, bottom), dark)
    foot = top + canvas.ruler
    lines.add_rect_filled((low, foot - 3), (high, foot), theme.u32((*theme.ACCENT[:3], 0.5)))
    for x, way in ((low, 1.0), (high, -1.0)):  # brackets to be dragged
        for wide, deep in ((2.5, em(0.5)), (em(0.3), 2.5)):
            edges = sorted((x, x + way * wide))
            lines.add_rect_filled(
                (edges[0], foot - em(0.5)), (edges[1], foot - em(0.5) + deep), theme.u32(theme.ACCENT)
            )
    lines.pop_clip_rect()


def draw_playhead(session: Session, canvas: Canvas) -> None:
    lines = imgui.get_window_draw_list()
    x = canvas.px(session.playback.time)
    if x < canvas.left - 1 or x > canvas.x + canvas.width:
        return
    color, top = theme.u32(theme.ACCENT), canvas.y
    lines.add_line((x, top), (x, canvas.y + canvas.height), color, 1.5)
    half = em(0.35)
    lines.add_triangle_filled((x - half, top), (x + half, top), (x, top + 1.6 * half), color)


def snapped(session: Session, canvas: Canvas, time: float, places: Iterable[float]) -> float:
    """`time`, on a place or a frame where snapping is on (Alt: off for now)."""
    view = session.animating
    if not view.snap or imgui.get_io().key_alt:
        return time
    return canvas.scale.snap(time, places, session.playback.frame_rate, reach=em(0.6))
