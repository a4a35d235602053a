"""The dope sheet and the curves of the clip that plays: its channels' keys, and their values over time."""

from __future__ import annotations

from typing import Any

import numpy as np
from imgui_bundle import imgui

from editor import theme
from editor.animating import rows
from editor.animating.following import runtime_of
from editor.panels.timeline_canvas import Canvas
from editor.session import Session
from editor.ui import Ui
from editor.widgets import em

#: x, y, z, then others
COLORS = ((0.93, 0.36, 0.36, 1.0), (0.45, 0.80, 0.36, 1.0), (0.36, 0.56, 0.95, 1.0), (0.85, 0.72, 0.30, 1.0))
_SAMPLES = 400


def shown_clip(session: Session) -> Any:
    """The clip whose channels are shown: of the selected block, else the first that plays."""
    document = session.document
    if document is None or not getattr(document.runtime, "clips", None):
        return None
    animation, view = runtime_of(session).animation, session.animating
    if animation is not None and 0 <= view.track < len(animation.model.tracks):
        blocks = animation.model.tracks[view.track].blocks
        if 0 <= view.block < len(blocks):
            key = blocks[view.block].clip
            return runtime_of(session).clips[runtime_of(session).deck.find(animation.model.clips[key].source or key)]
    active = runtime_of(session).deck.active
    return runtime_of(session).clips[active[0] if active else 0]


def draw_dope(ui: Ui, canvas: Canvas, clip: Any, first_row: float) -> int:
    """Keys as diamonds, a row a channel; the number of rows. A click on a row shows its curve."""
    session, lines = ui.session, imgui.get_window_draw_list()
    found = rows.dope_rows(clip, session.animating.search)
    height, top = em(1.3), canvas.y + canvas.ruler
    view = session.animating
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
        lines.push_clip_rect((canvas.x, y), (canvas.left - 4, y + height), True)
        lines.add_text(
            (canvas.x + em(0.4), y + em(0.1)),
            theme.u32(theme.TEXT if chosen else theme.DIM),
            f"{row.node} · {row.path}",
        )
        lines.pop_clip_rect()
        lines.push_clip_rect((canvas.left, y), (canvas.x + canvas.width, y + height), True)
        color = theme.u32(theme.ACCENT if chosen else (0.75, 0.77, 0.8, 1.0))
        half, middle, last = em(0.28), y + height / 2, -1e9
        for key in row.keys.tolist():
            x = canvas.px(key)
            if x - last < 2.0 or x < canvas.left - half:
                continue
            last = x
            lines.add_quad_filled((x, middle - half), (x + half, middle), (x, middle + half), (x - half, middle), color)
        lines.pop_clip_rect()
        inside = y <= io.mouse_pos.y < y + height and io.mouse_pos.y > top
        if imgui.is_item_hovered() and inside and io.mouse_pos.x < canvas.left and imgui.is_mouse_clicked(0):
            view.channel = row.channel
    lines.pop_clip_rect()
    return len(found)


def draw_curves(ui: Ui, canvas: Canvas, clip: Any) -> None:
    """The chosen channel's components over the visible time, with its keys and the range of its values."""
    session, lines = ui.session, imgui.get_window_draw_list()
    view = session.animating
    if not 0 <= view.channel < len(clip.channels):
        found = rows.dope_rows(clip, view.search)
        view.channel = found[0].channel if found else -1
    if view.channel < 0:
        return
    channel = clip.channels[view.channel]
    top, bottom = canvas.y + canvas.ruler + em(0.6), canvas.y + canvas.height - em(0.6)
    start, end = max(canvas.time(canvas.left), 0.0), min(canvas.time(canvas.x + canvas.width), float(clip.duration))
    lines.add_text((canvas.x + em(0.4), top), theme.u32(theme.TEXT), channel.target or f"node {channel.node}")
    lines.add_text((canvas.x + em(0.4), top + em(1.3)), theme.u32(theme.DIM), channel.path)
    if end <= start:
        return
    times = np.linspace(start, end, _SAMPLES)
    names, values = rows.curve(channel, times)
    _, at_keys = rows.curve(channel, np.asarray(channel.times, np.float64))
    if values.size == 0:
        return
    low, high = float(min(values.min(), at_keys.min())), float(max(values.max(), at_keys.max()))
    room = max(0.08 * (high - low), 1e-6 * max(abs(high), 1.0), 1e-9)
    low, high = low - room, high + room

    def y(value: Any) -> Any:
        return bottom - (value - low) / (high - low) * (bottom - top)

    for value in (low + room, high - room):
        lines.add_line((canvas.left, y(value)), (canvas.x + canvas.width, y(value)), theme.u32((1, 1, 1, 0.08)))
        number = f"{value:.4g}"
        lines.add_text(
            (canvas.left - imgui.calc_text_size(number).x - 6, y(value) - em(0.6)), theme.u32(theme.DIM), number
        )
    lines.push_clip_rect((canvas.left, canvas.y), (canvas.x + canvas.width, canvas.y + canvas.height), True)
    for i, (name, line) in enumerate(zip(names, values, strict=True)):
        color = theme.u32(COLORS[min(i, len(COLORS) - 1)])
        points: Any = [imgui.ImVec2(canvas.px(float(t)), float(y(v))) for t, v in zip(times, line, strict=True)]
        lines.add_polyline(points, color, 1.6, 0)
        keys = np.asarray(channel.times, np.float64)
        if canvas.scale.x(float(keys[-1])) - canvas.scale.x(float(keys[0])) > 4.0 * len(keys):
            for t, v in zip(keys.tolist(), at_keys[i].tolist(), strict=True):
                lines.add_circle_filled((canvas.px(t), float(y(v))), 2.6, color)
        lines.add_text((canvas.left + em(0.5) + i * em(3), top - em(0.4)), color, name)
    lines.pop_clip_rect()
