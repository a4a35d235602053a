"""Timeline: tracks with clips as blocks, markers, in and out points; the dope sheet and curves of a clip beside it.

Drag a block to move it, its ends to trim, its upper corners to fade; overlapping blocks cross-fade. Each drag is one
undo entry. The wheel zooms, Shift and the wheel or the middle button move along, a drag in the ruler scrubs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.animating.editing import AnimationEditor
from editor.animating.following import animation_of, drive_of, runtime_of
from editor.panels.base import Panel
from editor.panels.timeline_canvas import GRIP, Canvas, begin_canvas, draw_playhead, draw_ruler, snapped
from editor.panels.timeline_pages import draw_curves, draw_dope, shown_clip
from editor.ui import Ui
from editor.widgets import cut, em, empty_state, flow, icon_button, search_field, text, tooltip
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
    """What is being dragged: `kind` move | left | right | fade_in | fade_out | marker | scrub; `offset`: seconds from
    the pointer to what it holds; `token` makes the drag one undo entry."""

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
        self._first_row = 0.0
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
            clip = shown_clip(session)
            if page == "dope" and clip is not None:
                count = draw_dope(ui, canvas, clip, self._first_row)
                io = imgui.get_io()
                if imgui.is_item_hovered() and io.mouse_wheel and io.mouse_pos.x < canvas.left:
                    self._first_row = min(max(self._first_row - 3 * io.mouse_wheel, 0.0), max(count - 3.0, 0.0))
            elif clip is not None:
                draw_curves(ui, canvas, clip)
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
        flow(em(9), 0.4)
        self._clips(ui, editor)
        if view.page == "tracks":
            flow(em(4), 0.4)
            if icon_button(f"{icons.ADD} Track", "Add a track over the others"):
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
        if animation_of(session) is not None and animation_of(session).model.root:
            flow(em(2), 0.2)
            on = runtime_of(session).deck.root_motion
            if icon_button(f"{icons.PATH}##root", "Root motion", active=on):
                ui.operations.run("animation.root-motion", session)
        if view.page != "tracks":
            flow(em(12), 0.4)
            imgui.begin_group()
            imgui.set_next_item_width(em(12))
            view.search = search_field("##search", view.search, "Filter channels")
            imgui.end_group()

    def _clips(self, ui: Ui, editor: AnimationEditor) -> None:
        """A list of the scene's clips: to play one, or to add it to the chosen track."""
        session = ui.session
        runtime = runtime_of(session)
        active = [runtime.clips[i].name for i in runtime.deck.active]
        tracks = drive_of(session) == "timeline"
        imgui.set_next_item_width(em(9))
        if imgui.begin_combo("##clips", "Add a clip…" if tracks else (", ".join(active) or "No clip")):
            for i, clip in enumerate(runtime.clips):
                if imgui.selectable(f"{clip.name}   {clip.duration:.2f} s##{i}", clip.name in active)[0]:
                    if tracks:
                        at = max(session.animating.track, 0)
                        self._try(ui, lambda at=at, name=clip.name: editor.add_block(name, at))
                    elif imgui.get_io().key_ctrl and clip.name not in active:
                        runtime.play(*active, clip.name)
                    else:
                        runtime.play(clip.name)
            imgui.end_combo()
        tooltip("Adds to the selected track" if tracks else "Ctrl: play it over those that play already")

    # -- tracks -------------------------------------------------------------------------------------------------------

    def _tracks(self, ui: Ui, editor: AnimationEditor, canvas: Canvas) -> None:
        session = ui.session
        animation = animation_of(session)
        model = animation.model if animation is not None else None
        if model is None or not model.tracks:
            text_at(canvas, 0, "No animation yet: add a track, or choose “Play timeline”")
            self._drag(ui, editor, canvas)
            return
        lines = imgui.get_window_draw_list()
        keys = list(model.clips)
        for i, track in enumerate(model.tracks):
            y = self._row_y(canvas, len(model.tracks), i)
            self._track_row(ui, canvas, track, i, y)
            lines.push_clip_rect((canvas.left, y), (canvas.x + canvas.width, y + em(ROW)), True)
            for j, block in enumerate(track.blocks):
                chosen = (i, j) == (session.animating.track, session.animating.block)
                draw_block(canvas, block, y, PALETTE[keys.index(block.clip) % len(PALETTE)], chosen, track.muted)
            lines.pop_clip_rect()
        self._markers(ui, canvas, model)
        self._drag(ui, editor, canvas)
        self._menu(ui, editor)

    def _row_y(self, canvas: Canvas, count: int, track: int) -> float:
        """The last track lies on top, as it does in the picture."""
        return canvas.y + canvas.ruler + (count - 1 - track) * em(ROW)

    def _track_row(self, ui: Ui, canvas: Canvas, track: Any, number: int, y: float) -> None:
        lines, view = imgui.get_window_draw_list(), ui.session.animating
        chosen = number == view.track
        fill = (*theme.ACCENT[:3], 0.10) if chosen else (1, 1, 1, 0.02 + 0.02 * (number % 2))
        lines.add_rect_filled((canvas.x, y), (canvas.x + canvas.width, y + em(ROW) - 1), theme.u32(fill))
        lines.push_clip_rect((canvas.x, y), (canvas.left - 4, y + em(ROW)), True)
        color = theme.FAINT if track.muted else theme.TEXT
        lines.add_text((canvas.x + em(0.4), y + em(0.1)), theme.u32(color), track.name)
        parts = [track.mode if track.mode != "override" else "", f"mask {track.mask}" if track.mask else ""]
        parts += [f"{track.weight:.0%}" if track.weight != 1.0 else "", "muted" if track.muted else ""]
        about = " · ".join(part for part in parts if part)
        lines.add_text((canvas.x + em(0.4), y + em(1.15)), theme.u32(theme.DIM), about or "override")
        lines.pop_clip_rect()

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
        if y < canvas.y + canvas.ruler or model is None or not canvas.holds(x, y):
            return Grab("scrub" if x >= canvas.left else "name", track=self._track_at(canvas, model, y))
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
        row = len(model.tracks) - 1 - int((y - canvas.y - canvas.ruler) // em(ROW))
        return row if 0 <= row < len(model.tracks) else -1

    def _drag(self, ui: Ui, editor: AnimationEditor, canvas: Canvas) -> None:
        session, io = ui.session, imgui.get_io()
        view = session.animating
        model = editor.model if view.page == "tracks" else None
        if imgui.is_item_hovered() and self.grab is None:
            here = self._at(canvas, model, io.mouse_pos.x, io.mouse_pos.y)
            if here.kind in ("left", "right", "fade_in", "fade_out"):
                imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
            if imgui.is_mouse_clicked(0) or imgui.is_mouse_clicked(1):
                if here.track >= 0:
                    view.track, view.block = here.track, here.block
                view.marker = here.block if here.kind == "marker" else -1
                if imgui.is_mouse_clicked(0) and here.kind not in ("name", "empty"):
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

    # -- menus --------------------------------------------------------------------------------------------------------

    def _menu(self, ui: Ui, editor: AnimationEditor) -> None:
        if not imgui.begin_popup("##what"):
            return
        view, model = ui.session.animating, editor.model
        if view.marker >= 0 and view.marker < len(model.markers):
            marker = model.markers[view.marker]
            changed, name = imgui.input_text("Name", marker.name)
            if changed and name:
                self._try(ui, lambda: editor.set_marker(view.marker, name=name, gesture=("marker name", view.marker)))
            if imgui.menu_item_simple("Delete marker"):
                self._try(ui, lambda: editor.remove_marker(view.marker))
                view.marker = -1
        elif 0 <= view.track < len(model.tracks):
            track = model.tracks[view.track]
            if 0 <= view.block < len(track.blocks):
                self._block_menu(ui, editor, track.blocks[view.block])
                imgui.separator()
            self._track_menu(ui, editor, track)
        imgui.end_popup()

    def _block_menu(self, ui: Ui, editor: AnimationEditor, block: Any) -> None:
        view = ui.session.animating
        at = (view.track, view.block)
        text(block.clip, theme.DIM)
        for name, low, high in (
            ("speed", -4.0, 4.0),
            ("offset", -10.0, 10.0),
            ("fade_in", 0.0, block.length),
            ("fade_out", 0.0, block.length),
        ):
            imgui.set_next_item_width(em(8))
            changed, value = imgui.drag_float(name.replace("_", " "), getattr(block, name), 0.01, low, high, "%.3f")
            if changed:
                self._try(
                    ui,
                    lambda name=name, value=value: set_field(
                        editor, at, name, float(value), gesture=("block", *at, name)
                    ),
                )
        for name, choices in (
            ("play", ("loop", "once", "ping-pong")),
            ("curve", ("linear", "smooth", "smoother", "ease_in", "ease_out")),
        ):
            imgui.set_next_item_width(em(8))
            changed, chosen = imgui.combo(name, choices.index(getattr(block, name)), list(choices))
            if changed:
                self._try(ui, lambda name=name, value=choices[chosen]: set_field(editor, at, name, value))
        changed, sync = imgui.checkbox("in step with its neighbours", block.sync)
        if changed:
            self._try(ui, lambda: editor.set_block(*at, sync=sync or None))
        if imgui.menu_item_simple("Split here", "Shift+S"):
            ui.operations.run("animation.split", ui.session)
        if imgui.menu_item_simple("Delete block"):
            ui.operations.run("animation.delete-block", ui.session)

    def _track_menu(self, ui: Ui, editor: AnimationEditor, track: Any) -> None:
        number = ui.session.animating.track
        text(f"Track {track.name}", theme.DIM)
        changed, value = imgui.slider_float("weight", track.weight, 0.0, 1.0)
        if changed:
            self._try(ui, lambda: editor.set_track(number, weight=float(value), gesture=("track weight", number)))
        masks = ["", *editor.model.masks]
        changed, chosen = imgui.combo("mask", masks.index(track.mask), ["everything", *editor.model.masks])
        if changed:
            self._try(ui, lambda: editor.set_track(number, mask=masks[chosen] or None))
        if imgui.menu_item("additive", "", track.mode == "additive")[0]:
            self._try(ui, lambda: editor.set_track(number, mode="override" if track.mode == "additive" else "additive"))
        if imgui.menu_item("muted", "", track.muted)[0]:
            self._try(ui, lambda: editor.set_track(number, muted=None if track.muted else True))
        if imgui.menu_item_simple("Move up"):
            self._try(ui, lambda: editor.move_track(number, 1))
        if imgui.menu_item_simple("Move down"):
            self._try(ui, lambda: editor.move_track(number, -1))
        if imgui.menu_item_simple("Delete track"):
            self._try(ui, lambda: editor.remove_track(number))

    def _try(self, ui: Ui, change: Any) -> None:
        try:
            change()
        except LucarnaError as error:
            self.grab = None
            ui.session.fail(error)


def set_field(editor: AnimationEditor, at: tuple[int, int], name: str, value: Any, gesture: Any = None) -> None:
    editor.set_block(*at, gesture=gesture, **{name: value})


def draw_block(canvas: Canvas, block: Any, y: float, color: theme.Rgba, chosen: bool, muted: bool) -> None:
    """A block with its fades as slopes."""
    lines = imgui.get_window_draw_list()
    left, right = canvas.px(block.start), canvas.px(block.start + block.length)
    top, bottom = y + 2, y + em(ROW) - 3
    fill = (*color[:3], 0.3 if muted else 0.78)
    up, down = canvas.scale.scale * block.fade_in, canvas.scale.scale * block.fade_out
    up, down = min(up, right - left), min(down, right - left)
    shape = [(left, bottom), (left + up, top), (max(right - down, left + up), top), (right, bottom)]
    lines.add_convex_poly_filled([imgui.ImVec2(*p) for p in shape], theme.u32(fill))
    border = theme.u32(theme.ACCENT if chosen else (1, 1, 1, 0.25))
    lines.add_rect((left, top), (right, bottom), border, 2.0, 2.0 if chosen else 1.0)
    for x in (left + up, right - down):
        lines.add_circle_filled((x, top + 3), 3.0, theme.u32((1, 1, 1, 0.8 if chosen else 0.4)))
    lines.push_clip_rect((max(left, canvas.left), top), (right - 2, bottom), True)
    speed = f"  × {block.speed:g}" if block.speed != 1.0 else ""
    lines.add_text(
        (max(left, canvas.left) + em(0.4) + min(up, em(3)) * 0.5, top + em(0.35)),
        theme.u32(theme.TEXT),
        f"{block.clip}{speed}",
    )
    lines.pop_clip_rect()


def _marker_y(canvas: Canvas) -> float:
    return canvas.y + canvas.ruler - em(0.45)


def text_at(canvas: Canvas, row: int, value: str) -> None:
    lines = imgui.get_window_draw_list()
    lines.add_text((canvas.left + em(1), canvas.y + canvas.ruler + em(0.8 + row * 1.4)), theme.u32(theme.DIM), value)


PANEL = TimelinePanel
