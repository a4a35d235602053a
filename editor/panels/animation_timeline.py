"""Timeline: tracks with clips as blocks, markers, in and out points; the dope sheet and curves of a clip beside it.

Drag a block to move it, its ends to trim, its upper corners to fade; overlapping blocks cross-fade. Each drag is one
undo entry. The wheel zooms (over the names: scrolls), Shift and the wheel or the middle button move along, a drag in
the ruler scrubs, the brackets at its lower edge are the in and out points.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from imgui_bundle import imgui

from editor import icons, theme
from editor.animating.editing import AnimationEditor
from editor.animating.following import animation_of, drive_of
from editor.panels.base import Panel
from editor.panels.timeline_canvas import GRIP, Canvas, begin_canvas, draw_playhead, draw_ruler, snapped
from editor.panels.timeline_menus import draw_clips, draw_menu, draw_rate, draw_root
from editor.panels.timeline_pages import draw_curves, draw_dope, shown_clip
from editor.ui import Ui
from editor.widgets import cut, em, empty_state, flow, icon_button, search_field, tooltip
from engine.animation.blend import fade
from engine.core.errors import LucarnaError

PAGES = (("tracks", "Tracks"), ("dope", "Dope sheet"), ("curves", "Curves"))
DRIVES = (("clips", "Clips"), ("timeline", "Timeline"), ("states", "States"))
ROW = 2.3
#: of blocks, by clip
PALETTE = (
    (0.27, 0.47, 0.66, 1.0), (0.33, 0.55, 0.40, 1.0), (0.62, 0.42, 0.36, 1.0), (0.52, 0.42, 0.63, 1.0),
    (0.58, 0.52, 0.30, 1.0), (0.30, 0.55, 0.58, 1.0),
)  # fmt: skip


@dataclass(slots=True)
class Grab:
    """What is being dragged: `kind` move | left | right | fade_in | fade_out | marker | scrub | in | out; `offset`:
    seconds from the pointer to what it holds; `token` makes the drag one undo entry."""

    kind: str
    track: int = -1
    block: int = -1
    offset: float = 0.0
    token: int = 0


class TimelinePanel(Panel):
    title: ClassVar[str] = "Timeline"
    icon: ClassVar[str] = icons.FILM
    dock: ClassVar[str] = "Bottom"

    def __init__(self) -> None:
        self.grab: Grab | None = None
        self._count = 0
        #: in and out points, seconds
        self._range = (0.0, 0.0)
        self._first_row = 0.0
        #: imgui units by which the tracks are scrolled
        self._scrolled = 0.0
        #: the last canvas: where tests find blocks
        self.canvas: Canvas | None = None

    def draw(self, ui: Ui) -> None:
        session = ui.session
        document = session.document
        if document is None or not getattr(document.runtime, "clips", None):
            empty_state(icons.FILM, "Nothing moves here", "Open a file with animation")
            return
        editor = AnimationEditor(session)
        self._bar(ui, editor)
        page, animation = session.animating.page, animation_of(session)
        marked = page == "tracks" and animation is not None and bool(animation.model.markers)
        canvas = self.canvas = begin_canvas(ui, max(session.playback.duration, 1e-3), markers=marked)
        draw_ruler(session, canvas)
        if page == "tracks":
            self._tracks(ui, editor, canvas)
        else:
            shown = shown_clip(session)
            if page == "dope" and shown is not None:
                count = draw_dope(ui, canvas, shown, self._first_row)
                self._first_row = min(max(self._first_row - 3 * _wheel_over_names(canvas), 0.0), max(count - 3.0, 0.0))
            elif shown is not None:
                draw_curves(ui, canvas, shown)
            self._drag(ui, editor, canvas)
        draw_playhead(session, canvas)

    # -- the bar ------------------------------------------------------------------------------------------------------

    def _bar(self, ui: Ui, editor: AnimationEditor) -> None:
        session, view = ui.session, ui.session.animating
        for page, name in PAGES:
            if icon_button(f"{name}##{page}", "", active=view.page == page):
                view.page = page
            imgui.same_line(0, em(0.2))
        flow(em(7), 0.6)
        drive = drive_of(session)
        imgui.set_next_item_width(em(7))
        if imgui.begin_combo("##drive", f"Play {dict(DRIVES)[drive].lower()}"):
            for key, name in DRIVES:
                if imgui.selectable(name, key == drive)[0]:
                    self._try(ui, lambda key=key: editor.drive(key))
            imgui.end_combo()
        tooltip("What poses the scene: its clips, the tracks below, or the state graph")
        flow(em(4.6), 0.4)
        draw_rate(ui)
        flow(em(9), 0.4)
        draw_clips(ui, editor)
        if view.page == "tracks":
            flow(em(4), 0.4)
            if icon_button(f"{icons.ADD} Track", "Add a track over the others: its blocks lie over theirs"):
                self._try(ui, lambda: editor.add_track())
            flow(em(2), 0.2)
            if icon_button(f"{icons.MARK}##marker", "Add a marker here  Shift+M"):
                ui.operations.run("animation.add-marker", session)
        flow(em(2), 0.2)
        if icon_button(
            f"{icons.MAGNET}##snap", "Snap to blocks, keys and frames; Alt while dragging: not", active=view.snap
        ):
            view.snap = not view.snap
        flow(em(2), 0.2)
        if icon_button(f"{icons.EXPAND}##fit", "Show all"):
            view.fitted = False
        flow(em(2), 0.2)
        if icon_button(f"{icons.GHOST}##ghosts", "Onion skin  Shift+G", active=view.ghosts > 0):
            ui.operations.run("animation.ghosts", session)
        flow(em(2), 0.2)
        draw_root(ui, editor)
        if view.page != "tracks":
            flow(em(12), 0.4)
            imgui.begin_group()
            imgui.set_next_item_width(em(12))
            view.search = search_field("##search", view.search, "Filter channels")
            imgui.end_group()

    # -- tracks -------------------------------------------------------------------------------------------------------

    def _tracks(self, ui: Ui, editor: AnimationEditor, canvas: Canvas) -> None:
        session = ui.session
        animation = animation_of(session)
        model = animation.model if animation is not None else None
        if model is None or not model.tracks:
            text_at(canvas, 0, "No tracks yet: add one, or choose “Play timeline”")
            self._drag(ui, editor, canvas)
            draw_menu(ui, editor)
            return
        lines = imgui.get_window_draw_list()
        keys = list(model.clips)
        hidden = max(len(model.tracks) * em(ROW) - (canvas.height - canvas.ruler), 0.0)
        self._scrolled = min(max(self._scrolled - em(ROW) * _wheel_over_names(canvas), 0.0), hidden)
        top = canvas.y + canvas.ruler
        lines.push_clip_rect((canvas.x, top), (canvas.x + canvas.width, canvas.y + canvas.height), True)
        for i, track in enumerate(model.tracks):
            y = self._row_y(canvas, len(model.tracks), i)
            self._track_row(ui, canvas, track, i, y)
            lines.push_clip_rect((canvas.left, y), (canvas.x + canvas.width, y + em(ROW)), True)
            for j, block in enumerate(track.blocks):
                chosen = (i, j) == (session.animating.track, session.animating.block)
                draw_block(canvas, block, y, PALETTE[keys.index(block.clip) % len(PALETTE)], chosen, track.muted)
            lines.pop_clip_rect()
        lines.pop_clip_rect()
        self._markers(ui, canvas, model)
        self._drag(ui, editor, canvas)
        draw_menu(ui, editor)

    def _row_y(self, canvas: Canvas, count: int, track: int) -> float:
        """The last track lies on top, as it does in the picture."""
        return canvas.y + canvas.ruler - self._scrolled + (count - 1 - track) * em(ROW)

    def _track_row(self, ui: Ui, canvas: Canvas, track: Any, number: int, y: float) -> None:
        lines, view = imgui.get_window_draw_list(), ui.session.animating
        chosen = number == view.track
        fill = (*theme.ACCENT[:3], 0.10) if chosen else (1, 1, 1, 0.02 + 0.02 * (number % 2))
        lines.add_rect_filled((canvas.x, y), (canvas.x + canvas.width, y + em(ROW) - 1), theme.u32(fill))
        color, room = theme.FAINT if track.muted else theme.TEXT, canvas.names - em(2.2)
        parts = [track.mode if track.mode != "override" else "", f"mask {track.mask}" if track.mask else ""]
        parts += [f"{track.weight:.0%}" if track.weight != 1.0 else "", "muted" if track.muted else ""]
        about = " · ".join(part for part in parts if part) or "override"
        lines.add_text((canvas.x + em(0.4), y + em(0.1)), theme.u32(color), cut(track.name, room))
        lines.add_text((canvas.x + em(0.4), y + em(1.15)), theme.u32(theme.DIM), cut(about, room + em(1.4)))
        eye = icons.HIDDEN if track.muted else icons.VISIBLE
        lines.add_text((canvas.left - em(1.6), y + em(0.15)), theme.u32(theme.DIM if not track.muted else color), eye)
        mouse = imgui.get_io().mouse_pos
        if imgui.is_item_hovered() and mouse.x < canvas.left and y <= mouse.y < y + em(ROW):
            over_eye = mouse.x >= canvas.left - em(1.8)
            imgui.set_tooltip("Play or mute this track" if over_eye else f"{track.name}\n{about}\nRight click for more")

    def _markers(self, ui: Ui, canvas: Canvas, model: Any) -> None:
        lines = imgui.get_window_draw_list()
        lines.push_clip_rect((canvas.left, canvas.y), (canvas.x + canvas.width, canvas.y + canvas.height), True)
        times, names = animation_of(ui.session).sequence.occurrences()
        own = {(m.time, m.name) for m in model.markers}
        places = [*(canvas.px(t) for t, n in zip(times.tolist(), names, strict=True) if (t, n) in own), math.inf]
        middle, mouse, number = _marker_y(canvas), imgui.get_io().mouse_pos, 0
        for time, name in zip(times.tolist(), names, strict=True):
            x = canvas.px(time)
            mine = (time, name) in own
            color = theme.u32(theme.WARNING if mine else (*theme.WARNING[:3], 0.45))
            lines.add_line((x, middle), (x, canvas.y + canvas.height), theme.u32((*theme.WARNING[:3], 0.25)))
            lines.add_circle_filled((x, middle), em(0.26), color)
            if mine:  # as much of its name as fits before the next one
                number += 1
                room = places[number] - x - em(0.8)
                if room > em(1.5):
                    lines.add_text((x + em(0.4), middle - em(0.5)), color, cut(name, room))
            if imgui.is_item_hovered() and math.hypot(mouse.x - x, mouse.y - middle) < em(0.5):
                imgui.set_tooltip(f"{name}  {time:.2f} s")
        lines.pop_clip_rect()

    # -- the pointer --------------------------------------------------------------------------------------------------

    def _at(self, canvas: Canvas, model: Any, x: float, y: float) -> Grab:
        """What lies under the pointer."""
        if model is not None and abs(y - _marker_y(canvas)) < em(GRIP):
            for k, marker in enumerate(model.markers):
                if abs(canvas.px(marker.time) - x) < em(GRIP):
                    return Grab("marker", -1, k, marker.time - canvas.time(x))
        if abs(y - canvas.y - canvas.ruler + em(0.25)) < em(0.25):
            for kind, at in (("in", self._range[0]), ("out", self._range[1])):
                if abs(canvas.px(at) - x) < em(GRIP):
                    return Grab(kind, offset=at - canvas.time(x))
        if y < canvas.y + canvas.ruler or model is None or not canvas.holds(x, y):
            eye = canvas.left - em(1.8) <= x < canvas.left - 2 and y >= canvas.y + canvas.ruler
            kind = "mute" if eye else "scrub" if x >= canvas.left else "name"
            return Grab(kind, track=self._track_at(canvas, model, y))
        track = self._track_at(canvas, model, y)
        if track >= 0:
            top = self._row_y(canvas, len(model.tracks), track)
            for j in reversed(range(len(model.tracks[track].blocks))):
                block = model.tracks[track].blocks[j]
                left, right, edge = canvas.px(block.start), canvas.px(block.start + block.length), em(GRIP)
                if not left - edge / 2 <= x <= right + edge / 2:
                    continue
                upper = y < top + em(0.75)
                if upper and abs(x - canvas.px(block.start + block.fade_in)) < edge:
                    return Grab("fade_in", track, j, block.start + block.fade_in - canvas.time(x))
                if upper and abs(x - canvas.px(block.start + block.length - block.fade_out)) < edge:
                    return Grab("fade_out", track, j, block.start + block.length - block.fade_out - canvas.time(x))
                if abs(x - left) < edge:
                    return Grab("left", track, j, block.start - canvas.time(x))
                if abs(x - right) < edge:
                    return Grab("right", track, j, block.start + block.length - canvas.time(x))
                return Grab("move", track, j, block.start - canvas.time(x))
        return Grab("empty", track)

    def _track_at(self, canvas: Canvas, model: Any, y: float) -> int:
        if model is None or y < canvas.y + canvas.ruler:
            return -1
        row = len(model.tracks) - 1 - int((y - canvas.y - canvas.ruler + self._scrolled) // em(ROW))
        return row if 0 <= row < len(model.tracks) else -1

    def _drag(self, ui: Ui, editor: AnimationEditor, canvas: Canvas) -> None:
        session, io = ui.session, imgui.get_io()
        view = session.animating
        model = editor.model if view.page == "tracks" else None
        self._range = (session.playback.start, session.playback.stop)
        if imgui.is_item_hovered() and self.grab is None:
            here = self._at(canvas, model, io.mouse_pos.x, io.mouse_pos.y)
            if here.kind in ("left", "right", "fade_in", "fade_out", "in", "out"):
                imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
            if imgui.is_mouse_clicked(0) or imgui.is_mouse_clicked(1):
                if here.track >= 0:
                    view.track, view.block = here.track, here.block if here.kind != "empty" else -1
                elif here.kind == "empty":
                    view.track = view.block = -1
                view.marker = here.block if here.kind == "marker" else -1
                if imgui.is_mouse_clicked(0) and here.kind == "mute" and here.track >= 0 and model:
                    muted = model.tracks[here.track].muted
                    self._try(ui, lambda: editor.set_track(here.track, muted=None if muted else True))
                elif imgui.is_mouse_clicked(0) and here.kind not in ("name", "empty", "mute"):
                    self._count += 1
                    here.token = self._count
                    self.grab = here
                elif imgui.is_mouse_clicked(1):
                    imgui.open_popup("##what")
        if self.grab is not None:
            if imgui.is_mouse_down(0):
                moved = abs(io.mouse_delta.x) > 0 or self.grab.kind == "scrub"
                if moved:
                    self._try(ui, lambda: self._move(ui, editor, canvas, self.grab))
            else:
                self.grab = None
                session.end_gesture()

    def _move(self, ui: Ui, editor: AnimationEditor, canvas: Canvas, grab: Grab) -> None:
        session = ui.session
        wanted = canvas.time(imgui.get_io().mouse_pos.x) + grab.offset
        if grab.kind == "scrub":
            session.playback.playing = False
            session.seek(snapped(session, canvas, wanted, self._edges(editor, -1, -1)))
            return
        if grab.kind in ("in", "out"):
            time = snapped(session, canvas, wanted, self._edges(editor, -1, -1))
            low, high = session.playback.start, session.playback.stop
            least = 1.0 / session.playback.frame_rate
            low, high = (min(time, high - least), high) if grab.kind == "in" else (low, max(time, low + least))
            session.playback.set_range(low, high)
            session.seek(session.playback.time)
            return
        places = [*self._edges(editor, grab.track, grab.block), session.playback.time]
        time = max(snapped(session, canvas, wanted, places), 0.0)
        token = ("timeline", grab.token)
        if grab.kind == "marker":
            editor.set_marker(grab.block, time=time, gesture=token)
            return
        block = editor.model.tracks[grab.track].blocks[grab.block]
        end = block.start + block.length
        if grab.kind == "move":
            tail = snapped(session, canvas, wanted + block.length, places) - block.length
            if time == wanted or abs(tail - wanted) < abs(time - wanted):
                time = max(tail, 0.0)
            editor.move_block(grab.track, grab.block, time, gesture=token)
        elif grab.kind == "left":
            editor.trim_block(grab.track, grab.block, min(time, end - 1e-3), end, gesture=token)
        elif grab.kind == "right":
            editor.trim_block(grab.track, grab.block, block.start, time, gesture=token)
        elif grab.kind == "fade_in":
            editor.set_block(
                grab.track, grab.block, fade_in=min(max(time - block.start, 0.0), block.length) or None, gesture=token
            )
        else:
            editor.set_block(
                grab.track, grab.block, fade_out=min(max(end - time, 0.0), block.length) or None, gesture=token
            )

    def _edges(self, editor: AnimationEditor, track: int, block: int) -> list[float]:
        """Where other blocks begin and end, markers stand, and the range ends."""
        model = editor.model
        found = [0.0, editor.session.playback.start, editor.session.playback.stop]
        if model is not None:
            for i, t in enumerate(model.tracks):
                for j, b in enumerate(t.blocks):
                    if (i, j) != (track, block):
                        found += [b.start, b.start + b.length]
            found += [m.time for k, m in enumerate(model.markers) if (track, block) != (-1, k)]
        return found

    def _try(self, ui: Ui, change: Any) -> None:
        try:
            change()
        except LucarnaError as error:
            self.grab = None
            ui.session.fail(error)


def draw_block(canvas: Canvas, block: Any, y: float, color: theme.Rgba, chosen: bool, muted: bool) -> None:
    """A block with its fades as slopes."""
    lines = imgui.get_window_draw_list()
    left, right = canvas.px(block.start), canvas.px(block.start + block.length)
    top, bottom = y + 2, y + em(ROW) - 3
    fill = (*color[:3], 0.3 if muted else 0.78)
    up, down = canvas.scale.scale * block.fade_in, canvas.scale.scale * block.fade_out
    up, down = min(up, right - left), min(down, right - left)
    steps = np.linspace(0.0, 1.0, 9)
    levels = fade(steps, block.curve)
    rise = [(left + up * u, bottom - (bottom - top) * v) for u, v in zip(steps.tolist(), levels.tolist(), strict=True)]
    fall = [(right - down * (1.0 - u), top + (bottom - top) * v)
            for u, v in zip(steps.tolist(), levels.tolist(), strict=True)]  # fmt: skip
    rise, fall = rise if up > 0.0 else [rise[0], (left, top)], fall if down > 0.0 else [(right, top), fall[-1]]
    lines.add_concave_poly_filled([imgui.ImVec2(*p) for p in (*rise, *fall)], theme.u32(fill))
    border = theme.u32(theme.ACCENT if chosen else (1, 1, 1, 0.25))
    lines.add_rect((left, top), (right, bottom), border, 2.0, 2.0 if chosen else 1.0)
    for x in (left + up, right - down):
        lines.add_circle_filled((x, top + 3), 3.0, theme.u32((1, 1, 1, 0.8 if chosen else 0.4)))
    lines.push_clip_rect((max(left, canvas.left), top), (right - 2, bottom), True)
    speed = f"  × {block.speed:g}" if block.speed != 1.0 else ""
    speed += f"  {block.weight:.0%}" if block.weight != 1.0 else ""
    lines.add_text(
        (max(left, canvas.left) + em(0.4) + min(up, em(3)) * 0.5, top + em(0.35)),
        theme.u32(theme.TEXT),
        f"{block.clip}{speed}",
    )
    lines.pop_clip_rect()


def _wheel_over_names(canvas: Canvas) -> float:
    io = imgui.get_io()
    return float(io.mouse_wheel) if imgui.is_item_hovered() and io.mouse_pos.x < canvas.left else 0.0


def _marker_y(canvas: Canvas) -> float:
    return canvas.y + canvas.ruler - em(0.45)


def text_at(canvas: Canvas, row: int, value: str) -> None:
    lines = imgui.get_window_draw_list()
    lines.add_text((canvas.left + em(1), canvas.y + canvas.ruler + em(0.8 + row * 1.4)), theme.u32(theme.DIM), value)


PANEL = TimelinePanel
