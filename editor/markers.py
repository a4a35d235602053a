"""Signs in the viewport for what has no surface: lights and cameras, and selected nodes that carry nothing."""

from __future__ import annotations

import numpy as np
from imgui_bundle import imgui

from editor import icons, theme
from editor.camera_controls import OrbitCamera, project
from editor.document import Document
from editor.widgets import em

#: no more signs than these: a thousand lamps are a fog of signs
LIMIT = 200
REACH = 0.8


def draw(
    document: Document, camera: OrbitCamera, origin: tuple[float, float], width: float, height: float,
    *, hoverable: bool,
) -> int:  # fmt: skip
    """Over a picture at `origin`; returns the node row whose sign is under the pointer, or -1."""
    rows, signs = _signs(document)
    if not rows:
        return -1
    scene = document.runtime.scene
    pixels, depth = project(camera, scene.nodes.world[rows, :, 3], width, height)
    lines, mouse = imgui.get_window_draw_list(), imgui.get_io().mouse_pos
    found, nearest = -1, em(REACH)
    for row, sign, (x, y), away in zip(rows, signs, pixels.tolist(), depth.tolist(), strict=True):
        if away <= camera.znear or not (0.0 <= x <= width and 0.0 <= y <= height):
            continue
        at = (origin[0] + x, origin[1] + y)
        distance = float(np.hypot(mouse.x - at[0], mouse.y - at[1]))
        if hoverable and distance < nearest and row not in document.locked:
            found, nearest = row, distance
        color = theme.ACCENT if row in document.selected else theme.TEXT
        size = imgui.calc_text_size(sign)
        lines.add_circle_filled(at, em(0.78), theme.u32((0.05, 0.055, 0.065, 0.6)))
        lines.add_text((at[0] - 0.5 * size.x, at[1] - 0.5 * size.y), theme.u32(color), sign)
    if found >= 0:
        imgui.set_tooltip(scene.nodes.name[found] or f"node {found}")
    return found


def _signs(document: Document) -> tuple[list[int], list[str]]:
    """Node rows, and their icons."""
    scene = document.runtime.scene
    visible = scene.nodes.visible_world
    found: dict[int, str] = {}
    for table, icon in ((scene.lights, icons.LIGHT), (scene.cameras, icons.CAMERA)):
        for row in table.node[table.alive][:LIMIT].tolist():
            if visible[row]:
                found[row] = icon
    chosen = np.array(document.selection[-64:], np.int64)
    for row in chosen[~np.isin(chosen, scene.instances.node)].tolist():
        found.setdefault(row, icons.EMPTY)
    return list(found), list(found.values())
