"""The axes in the viewport's corner: which way X, Y and Z point; a click on an end looks along it. Own drawing."""

from __future__ import annotations

import math

from imgui_bundle import imgui

from editor import theme
from editor.camera_controls import OrbitCamera
from editor.widgets import em

#: end of an axis -> the view that faces it (see camera_controls.VIEWS)
ENDS = (
    ("X", 0, 1.0, "right"), ("Y", 1, 1.0, "top"), ("Z", 2, 1.0, "front"),
    ("-X", 0, -1.0, "left"), ("-Y", 1, -1.0, "bottom"), ("-Z", 2, -1.0, "back"),
)  # fmt: skip


def ends_on_screen(camera: OrbitCamera, radius: float) -> list[tuple[str, int, float, float, float, str]]:
    """(label, axis, x, y, depth, view) of each end, y down, far ones first."""
    rotation = camera.rotation()
    rows = []
    for label, axis, sign, view in ENDS:
        x, y, z = rotation[axis] * sign  # the world axis in camera coordinates: a row of world-from-camera
        rows.append((label, axis, float(x) * radius, float(-y) * radius, float(z), view))
    return sorted(rows, key=lambda row: row[4])


def draw(camera: OrbitCamera, right: float, top: float, *, hoverable: bool) -> tuple[bool, str]:
    """Draw with its top right corner at (`right`, `top`). Returns (pointer is over it, view clicked or '')."""
    radius, dot = em(2.3), em(0.55)
    cx, cy = right - radius - dot - em(0.6), top + radius + dot + em(0.6)
    mouse = imgui.get_mouse_pos()
    over = hoverable and math.hypot(mouse.x - cx, mouse.y - cy) < radius + dot * 1.6
    lines = imgui.get_window_draw_list()
    if over:
        lines.add_circle_filled((cx, cy), radius + dot * 1.6, theme.u32((1, 1, 1, 0.07)), 48)
    clicked = ""
    for label, axis, x, y, depth, view in ends_on_screen(camera, radius):
        color = theme.AXES[axis]
        alpha = 0.65 + 0.35 * (depth * 0.5 + 0.5)
        px, py = cx + x, cy + y
        hit = over and math.hypot(mouse.x - px, mouse.y - py) < dot * 1.3
        if label.startswith("-"):
            lines.add_circle_filled((px, py), dot * 0.72, theme.u32(theme.PANEL, 0.75), 20)
            lines.add_circle((px, py), dot * 0.72, theme.u32(color, 1.0 if hit else alpha * 0.8), 20, 1.5)
        else:
            lines.add_line((cx, cy), (px, py), theme.u32(color, alpha), 2.2)
            lines.add_circle_filled((px, py), dot * (1.12 if hit else 1.0), theme.u32(color, alpha), 24)
            size = imgui.calc_text_size(label)
            lines.add_text((px - size.x * 0.5, py - size.y * 0.5), theme.u32((0.05, 0.05, 0.06, 1.0)), label)
        if hit and imgui.is_mouse_clicked(imgui.MouseButton_.left):
            clicked = view
    return over, clicked
