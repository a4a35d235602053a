"""What the colours of a debug view mean, drawn over the picture: the legend that `lucarna render` writes, too."""

from __future__ import annotations

import itertools

from imgui_bundle import imgui

from editor import theme
from editor.strings import tr
from editor.widgets import em
from engine.render.legends import Legend

#: pieces of the ramp
PIECES = 64


def draw(legend: Legend, left: float, bottom: float, room: float) -> float:
    """With its lower left corner there, at most `room` imgui units wide; returns its height, 0 without room."""
    pad, bar = em(0.6), em(0.9)
    wide = min(em(24.0), room - 2.0 * pad)
    if wide < em(12.0):
        return 0.0
    line = imgui.get_text_line_height()
    height = 2.0 * pad + line + em(0.3) + bar + em(0.3) + line
    top, x = bottom - height, left + pad
    lines = imgui.get_window_draw_list()
    lines.add_rect_filled((left, top), (left + wide + 2.0 * pad, bottom), theme.u32((0.05, 0.055, 0.065, 0.86)), 4)
    y = top + pad
    heading = tr(legend.heading)
    lines.add_text((x, y), theme.u32(theme.TEXT), heading)
    said = tr(legend.note)
    note = imgui.calc_text_size(said).x
    if said and imgui.calc_text_size(heading).x + note + em(1.0) < wide:
        lines.add_text((x + wide - note, y), theme.u32(theme.DIM), said)
    y += line + em(0.3)
    colors = [theme.u32((*legend.color(i / PIECES), 1.0)) for i in range(PIECES + 1)]
    for i, (start, end) in enumerate(itertools.pairwise(colors)):
        ends = (x + i / PIECES * wide, y), (x + (i + 1) / PIECES * wide, y + bar)
        lines.add_rect_filled_multi_color(*ends, start, end, end, start)
    y += bar
    ticks = legend.ticks()
    for i, (place, label) in enumerate(ticks):
        across, size = x + place * wide, imgui.calc_text_size(label).x
        lines.add_line((across, y), (across, y + em(0.2)), theme.u32(theme.DIM))
        shift = 0.0 if i == 0 else size if i == len(ticks) - 1 else 0.5 * size
        lines.add_text((across - shift, y + em(0.25)), theme.u32(theme.TEXT), label)
    return height
