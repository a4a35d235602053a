"""The dope sheet and the curves of the clip that plays: its channels' keys, and their values over time."""

from __future__ import annotations

from typing import Any

import numpy as np
from imgui_bundle import imgui

from editor import theme
from editor.animating import rows
from editor.animating.following import animation_of, drive_of, runtime_of
from editor.animating.rows import Shown
from editor.panels.timeline_canvas import Canvas
from editor.session import Session
from editor.ui import Ui
from editor.widgets import cut, em

#: x, y, z, then others
COLORS = ((0.93, 0.36, 0.36, 1.0), (0.45, 0.80, 0.36, 1.0), (0.36, 0.56, 0.95, 1.0), (0.85, 0.72, 0.30, 1.0))
_SAMPLES = 400


def shown_clip(session: Session) -> Shown | None:
    """The clip whose channels are shown, as it plays: of the selected block, else the one that is heard now."""
    document = session.document
    if document is None or not getattr(document.runtime, "clips", None):
        return None
    runtime, animation, view = runtime_of(session), animation_of(session), session.animating
    if drive_of(session) == "timeline" and animation is not None and animation.sequence is not None:
        tracks, at = animation.model.tracks, (view.track, view.block)
        if not (0 <= at[0] < len(tracks) and 0 <= at[1] < len(tracks[at[0]].blocks)):
            heard = animation.sequence.audible([session.playback.time])
            every = [(i, j) for i, track in enumerate(tracks) for j in range(len(track.blocks))]
            if not heard and not every:
                return None
            at = heard[0][:2] if heard else every[0]
        key = tracks[at[0]].blocks[at[1]].clip
        clip = runtime.clips[runtime.deck.find(animation.model.clips[key].source or key)]
        return Shown(clip, animation.sequence, *at)
    active = runtime.deck.active
    return Shown(runtime.clips[active[0] if active else 0])


def _shade_outside(canvas: Canvas, shown: Shown) -> None:
    """Where the clip does not play, it is darker."""
    lines, (start, end) = imgui.get_window_draw_list(), shown.span
    top, bottom = canvas.y + canvas.ruler, canvas.y + canvas.height
    low, high = max(canvas.px(start), canvas.left), min(canvas.px(end), canvas.x + canvas.width)
    dark = theme.u32((0, 0, 0, 0.25))
    if low > canvas.left:
        lines.add_rect_filled((canvas.left, top), (low, bottom), dark)
    if high < canvas.x + canvas.width:
        lines.add_rect_filled((max(high, canvas.left), top), (canvas.x + canvas.width, bottom), dark)


def draw_dope(ui: Ui, canvas: Canvas, shown: Shown, first_row: float) -> int:
    """Keys as diamonds, a row a channel; the number of rows. A click on a row shows its curve."""
    session, lines = ui.session, imgui.get_window_draw_list()
    found = rows.dope_rows(shown.clip, session.animating.search)
    height, top = em(1.3), canvas.y + canvas.ruler
    view = session.animating
    _shade_outside(canvas, shown)
    lines.push_clip_rect((canvas.x, top), (canvas.x + canvas.width, canvas.y + canvas.height), True)
    io = imgui.get_io()
    for i, row in enumerate(found):
        y = top + (i - first_row) * height
        if y + height < top or y > canvas.y + canvas.height:
            continue
        chosen = row.channel == view.channel
        if i % 2:
            lines.add_rect_filled((canvas.x, y), (canvas.x + canvas.width, y + height), theme.u32((1, 1, 1, 0.025)))
        if chosen:
            lines.add_rect_filled(
                (canvas.x, y), (canvas.x + canvas.width, y + height), theme.u32((*theme.ACCENT[:3], 0.15))
            )
        name, room = f"{row.node} · {row.path}", canvas.names - em(0.6)
        lines.add_text(
            (canvas.x + em(0.4), y + em(0.1)), theme.u32(theme.TEXT if chosen else theme.DIM), cut(name, room)
        )
        lines.push_clip_rect((canvas.left, y), (canvas.x + canvas.width, y + height), True)
        color = theme.u32(theme.ACCENT if chosen else (0.75, 0.77, 0.8, 1.0))
        half, middle = em(0.28), y + height / 2
        places, number = shown.places(row.keys)
        inside = y <= io.mouse_pos.y < y + height and io.mouse_pos.y > top
        for x, key in _apart([canvas.px(p) for p in places.tolist()], number.tolist(), canvas.left - half):
            lines.add_quad_filled((x, middle - half), (x + half, middle), (x, middle + half), (x - half, middle), color)
            if inside and imgui.is_item_hovered() and abs(io.mouse_pos.x - x) < half:
                imgui.set_tooltip(f"{name}\nkey at {row.keys[key]:.3f} s")
        lines.pop_clip_rect()
        if imgui.is_item_hovered() and inside and io.mouse_pos.x < canvas.left:
            if imgui.is_mouse_clicked(0):
                view.channel = row.channel
            imgui.set_tooltip(f"{name}\nClick, then Curves: its values over time")
    lines.pop_clip_rect()
    return len(found)


def _apart(xs: list[float], numbers: list[int], left: float) -> list[tuple[float, int]]:
    """Of places that lie on one another, one; none left of the rows."""
    kept: list[tuple[float, int]] = []
    for x, number in sorted(zip(xs, numbers, strict=True)):
        if x >= left and (not kept or x - kept[-1][0] >= 2.0):
            kept.append((x, number))
    return kept


def draw_curves(ui: Ui, canvas: Canvas, shown: Shown) -> None:
    """The chosen channel's components over the visible time, with its keys and the range of its values."""
    session, lines, clip = ui.session, imgui.get_window_draw_list(), shown.clip
    view = session.animating
    if not 0 <= view.channel < len(clip.channels):
        found = rows.dope_rows(clip, view.search)
        view.channel = found[0].channel if found else -1
    if view.channel < 0:
        return
    channel = clip.channels[view.channel]
    top, bottom = canvas.y + canvas.ruler + em(0.6), canvas.y + canvas.height - em(0.6)
    low_time, high_time = shown.span
    start, end = max(canvas.time(canvas.left), low_time), min(canvas.time(canvas.x + canvas.width), high_time)
    _shade_outside(canvas, shown)
    if end <= start:
        _legend(canvas, channel, (), np.zeros(0), top)
        return
    times = np.linspace(start, end, _SAMPLES)
    names, values = rows.curve(channel, shown.clip_times(times))
    keys = np.asarray(channel.times, np.float64)
    _, at_keys = rows.curve(channel, keys)
    if values.size == 0:
        return
    low, high = float(min(values.min(), at_keys.min())), float(max(values.max(), at_keys.max()))
    room = max(0.08 * (high - low), 1e-6 * max(abs(high), 1.0), 1e-9)
    low, high = low - room, high + room

    def y(value: Any) -> Any:
        return bottom - (value - low) / (high - low) * (bottom - top)

    unit = rows.UNITS.get(channel.path, "")
    for value, beside in ((low + room, -em(1.05)), (high - room, em(0.05))):
        lines.add_line((canvas.left, y(value)), (canvas.x + canvas.width, y(value)), theme.u32((1, 1, 1, 0.08)))
        number = f"{value:.4g}{unit if unit == '°' else ' ' + unit}"
        lines.add_text(
            (canvas.x + canvas.width - imgui.calc_text_size(number).x - 6, y(value) + beside),
            theme.u32(theme.DIM), number,
        )  # fmt: skip
    lines.push_clip_rect((canvas.left, canvas.y), (canvas.x + canvas.width, canvas.y + canvas.height), True)
    places, which = shown.places(keys)
    sparse = canvas.scale.x(end) - canvas.scale.x(start) > 4.0 * len(places)
    for i, line in enumerate(values):
        color = theme.u32(COLORS[min(i, len(COLORS) - 1)])
        points: Any = [imgui.ImVec2(canvas.px(float(t)), float(y(v))) for t, v in zip(times, line, strict=True)]
        lines.add_polyline(points, color, 1.6, 0)
        if sparse:
            for t, v in zip(places.tolist(), at_keys[i][which].tolist(), strict=True):
                lines.add_circle_filled((canvas.px(t), float(y(v))), 2.6, color)
    lines.pop_clip_rect()
    now = min(max(session.playback.time, start), end)
    at_now = np.array([np.interp(now, times, line) for line in values])
    _legend(canvas, channel, names, at_now, top)


def _legend(canvas: Canvas, channel: Any, names: tuple[str, ...], values: Any, top: float) -> None:
    """In the column of names: whose curve it is, and each component's colour and value now."""
    lines, room = imgui.get_window_draw_list(), canvas.names - em(0.6)
    x, y = canvas.x + em(0.4), top - em(0.4)
    lines.push_clip_rect((canvas.x, canvas.y), (canvas.left - 2, canvas.y + canvas.height), True)
    lines.add_text((x, y), theme.u32(theme.TEXT), cut(channel.target or f"node {channel.node}", room))
    lines.add_text((x, y + em(1.15)), theme.u32(theme.DIM), channel.path)
    unit = rows.UNITS.get(channel.path, "")
    for i, (name, value) in enumerate(zip(names, values, strict=False)):
        color = theme.u32(COLORS[min(i, len(COLORS) - 1)])
        shown = f"{name}  {value:.4g}{unit if unit == '°' else ' ' + unit}"
        lines.add_text((x, y + em(2.3 + 1.1 * i)), color, cut(shown, room))
    lines.pop_clip_rect()
