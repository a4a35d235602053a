"""What is drawn over the picture: the corners of the selection's box, labels."""

from __future__ import annotations

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from editor import theme
from editor.camera_controls import OrbitCamera, project
from editor.host import box_corners
from editor.strings import tr
from editor.tools import Tools

#: the 12 edges of a box by corner index (see box_corners)
EDGES = tuple((a, a | bit) for a in range(8) for bit in (1, 2, 4) if not a & bit)
#: how much of each edge is drawn from each end: brackets show the box without hiding what is in it
BRACKET = 0.22


def box_segments(
    camera: OrbitCamera, low: NDArray[np.float64], high: NDArray[np.float64], width: float, height: float
) -> NDArray[np.float64]:
    """Bracket lines f8[n,2,2] in pixels of the part of a world box in front of the camera."""
    corners = box_corners(low, high)
    segments = []
    for a, b in EDGES:
        pa, pb = corners[a], corners[b]
        segments.append((pa, pa + (pb - pa) * BRACKET))
        segments.append((pb, pb + (pa - pb) * BRACKET))
    ends = np.asarray(segments)
    forward = -camera.rotation()[:, 2]
    depth = (ends - camera.eye()) @ forward
    near = camera.znear
    ends, depth = ends[(depth > near).any(axis=1)], depth[(depth > near).any(axis=1)]
    for i in (0, 1):  # move ends behind the camera up to the near plane
        behind = depth[:, i] <= near
        if behind.any():
            other = 1 - i
            t = (near * 1.001 - depth[behind, other]) / (depth[behind, i] - depth[behind, other])
            ends[behind, i] = ends[behind, other] + (ends[behind, i] - ends[behind, other]) * t[:, None]
    pixels, _depth = project(camera, ends.reshape(-1, 3), width, height)
    return pixels.reshape(-1, 2, 2)


def draw_box(
    camera: OrbitCamera, low: NDArray[np.float64], high: NDArray[np.float64],
    origin: tuple[float, float], width: float, height: float,
) -> None:  # fmt: skip
    """Brackets of a world box, over a picture at `origin`, `width` x `height` imgui units."""
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        return
    lines = imgui.get_window_draw_list()
    shadow, color = theme.u32((0, 0, 0, 0.55)), theme.u32(theme.ACCENT)
    segments = box_segments(camera, low, high, width, height) + np.asarray(origin)
    for thickness, tint in ((3.5, shadow), (1.6, color)):
        for (ax, ay), (bx, by) in segments.tolist():
            lines.add_line((ax, ay), (bx, by), tint, thickness)


def draw_rectangle(a: tuple[float, float], b: tuple[float, float]) -> None:
    """The frame of a box selection between two corners."""
    low, high = (min(a[0], b[0]), min(a[1], b[1])), (max(a[0], b[0]), max(a[1], b[1]))
    lines = imgui.get_window_draw_list()
    lines.add_rect_filled(low, high, theme.u32((*theme.ACCENT[:3], 0.12)))
    lines.add_rect(low, high, theme.u32(theme.ACCENT))


def draw_measure(
    camera: OrbitCamera, tools: Tools, origin: tuple[float, float], width: float, height: float
) -> None:  # fmt: skip
    """The measured points, the line between them and its length."""
    if not tools.points:
        if tools.measuring:
            chip(origin[0] + 10.0, origin[1] + 10.0, "Measure: click two points", theme.ACCENT)
        return
    pixels, depth = project(camera, np.asarray(tools.points), width, height)
    if (depth <= camera.znear).any():
        return
    lines = imgui.get_window_draw_list()
    ends = [(origin[0] + float(p[0]), origin[1] + float(p[1])) for p in pixels]
    color = theme.u32(theme.ACCENT)
    if len(ends) == 2:
        lines.add_line(ends[0], ends[1], theme.u32((0, 0, 0, 0.6)), 4.0)
        lines.add_line(ends[0], ends[1], color, 2.0)
    for end in ends:
        lines.add_circle_filled(end, 5.0, theme.u32((0, 0, 0, 0.6)))
        lines.add_circle_filled(end, 3.5, color)
    if tools.distance is not None:
        x, y = 0.5 * (ends[0][0] + ends[1][0]), 0.5 * (ends[0][1] + ends[1][1])
        chip(x + 8.0, y + 8.0, metres(tools.distance), theme.TEXT)


def metres(length: float) -> str:
    """A length as a person says it: `1.25 m`, `3.40 cm`, `2.1 km`."""
    for limit, factor, unit in ((1000.0, 1e-3, "km"), (1.0, 1.0, "m"), (0.01, 100.0, "cm"), (0.0, 1000.0, "mm")):
        if length >= limit:
            return f"{length * factor:.4g} {unit}"
    return f"{length:g} m"


def chip(x: float, y: float, value: str, color: theme.Rgba | None = None) -> tuple[float, float]:
    """A line of text on a rounded dark ground at (x, y), in the language of the interface; returns its size."""
    value = tr(value)
    size = imgui.calc_text_size(value)
    pad = imgui.get_style().frame_padding
    lines = imgui.get_window_draw_list()
    w, h = size.x + 2 * pad.x, size.y + 2 * pad.y
    lines.add_rect_filled((x, y), (x + w, y + h), theme.u32((0.05, 0.055, 0.065, 0.72)), 4)
    lines.add_text((x + pad.x, y + pad.y), theme.u32(color or theme.TEXT), value)
    return w, h
