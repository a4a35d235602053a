"""What lights are and how far they reach, as lines over the picture: spheres, cones, frames, arrows.

`outline` makes world segments of one light; nothing is drawn of more than LIMIT lights, the selected ones first.
"""

from __future__ import annotations

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from editor import theme
from editor.camera_controls import OrbitCamera, project
from editor.document import Document
from editor.session import Session

F8 = NDArray[np.float64]

LIMIT = 100
#: so many are drawn as clearly as one
FEW = 8
_TURN = np.linspace(0.0, 2.0 * np.pi, 49)
_CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN)], axis=1)


def draw(session: Session, origin: tuple[float, float], width: float, height: float) -> None:
    """The outlines of the selected lights, of all visible ones where the user wants that."""
    document = session.document
    if document is None:
        return
    rows, chosen = _rows(document, everything=session.preferences.show_lights)
    lines = imgui.get_window_draw_list()
    # the more there are, the fainter: the picture stays to be seen
    faint = 0.45 * min(1.0, (FEW / max(len(rows), 1)) ** 0.5)
    for row, selected in zip(rows, chosen, strict=True):
        ends = pixels_of(outline(document, row, session.camera), session.camera, width, height)
        color = theme.u32(theme.ACCENT if selected else (*theme.TEXT[:3], faint))
        shadow = theme.u32((0.0, 0.0, 0.0, 0.35))
        for (ax, ay), (bx, by) in (ends + np.asarray(origin)).tolist():
            if selected:
                lines.add_line((ax, ay), (bx, by), shadow, 3.0)
            lines.add_line((ax, ay), (bx, by), color, 1.3)


def outline(document: Document, row: int, camera: OrbitCamera) -> F8:
    """Segments f8[k,2,3] in the world of light `row`. What has no size of its own is drawn relative to its distance."""
    scene = document.runtime.scene
    light = scene.lights.asset(row)
    matrix = scene.nodes.world_matrix(int(scene.lights.node[row]))
    frame, place = _frame(matrix[:3, :3]), matrix[:3, 3]
    hint = 0.12 * max(float(np.linalg.norm(place - camera.eye())), 1e-6)
    if light.type == "directional":
        local = _sun(hint)
    elif light.type == "point":
        local = _sphere(light.range or 0.35 * hint)
    elif light.type == "spot":
        local = _cone(light.range or 3.0 * hint, light.outer_angle, light.inner_angle)
    else:
        local = _area(light.type, light.width / 2.0, light.height / 2.0, 0.5 * hint, two_sided=light.two_sided)
    result: F8 = local @ frame.T + place
    return result


def pixels_of(segments: F8, camera: OrbitCamera, width: float, height: float) -> F8:
    """The parts f8[n,2,2] in pixels of world segments that lie before the camera."""
    if len(segments) == 0:
        return np.zeros((0, 2, 2))
    near = camera.znear * 1.001
    depth = (segments - camera.eye()) @ -camera.rotation()[:, 2]
    kept = (depth > near).any(axis=1)
    ends, depth = segments[kept].copy(), depth[kept]
    for i in (0, 1):  # an end behind the camera moves up to the near plane
        behind = depth[:, i] <= near
        span = depth[behind, i] - depth[behind, 1 - i]
        share = (near - depth[behind, 1 - i]) / np.where(span == 0.0, 1.0, span)
        ends[behind, i] = ends[behind, 1 - i] + (ends[behind, i] - ends[behind, 1 - i]) * share[:, None]
    pixels, _depth = project(camera, ends.reshape(-1, 3), width, height)
    return np.clip(pixels, -1e6, 1e6).reshape(-1, 2, 2)


def _rows(document: Document, *, everything: bool) -> tuple[list[int], list[bool]]:
    table, nodes = document.runtime.scene.lights, document.runtime.scene.nodes
    if len(table) == 0:
        return [], []
    shown = table.alive & nodes.visible_world[table.node]
    selected = shown & np.isin(table.node, document.selection)
    rows = np.flatnonzero(selected)[:LIMIT].tolist()
    chosen = [True] * len(rows)
    if everything:
        others = np.flatnonzero(shown & ~selected)[: LIMIT - len(rows)].tolist()
        rows, chosen = rows + others, chosen + [False] * len(others)
    return rows, chosen


def _frame(linear: F8) -> F8:
    """The node's axes as a rotation: lights have no scale. Columns right, up, back."""
    length = float(np.linalg.norm(linear[:, 2]))
    back = linear[:, 2] / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    right = linear[:, 0] - back * float(linear[:, 0] @ back)
    size = float(np.linalg.norm(right))
    if size < 1e-12:
        right, size = np.cross([0.0, 1.0, 0.0] if abs(back[1]) < 0.9 else [1.0, 0.0, 0.0], back), 1.0
    right = right / max(float(np.linalg.norm(right)), 1e-30)
    return np.stack([right, np.cross(back, right), back], axis=1)


def _loop(points: F8) -> F8:
    """Points f8[n,3] one after the other as segments."""
    return np.stack([points[:-1], points[1:]], axis=1)


def _ring(radius_x: float, radius_y: float, z: float) -> F8:
    circle = _CIRCLE * [radius_x, radius_y]
    return _loop(np.concatenate([circle, np.full((len(circle), 1), z)], axis=1))


def _sphere(radius: float) -> F8:
    """Three great circles."""
    flat = _ring(radius, radius, 0.0)
    return np.concatenate([flat, flat[..., [2, 0, 1]], flat[..., [1, 2, 0]]])


def _cone(length: float, outer: float, inner: float) -> F8:
    """The end of the light as a cap on a sphere: its rim, the inner one, four edges, two arcs."""
    radius, depth = length * np.sin(outer), -length * np.cos(outer)
    parts = [_ring(radius, radius, depth)]
    if inner > 0.0:
        parts.append(_ring(length * np.sin(inner), length * np.sin(inner), -length * np.cos(inner)))
    rim = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]]) * radius
    edges = np.concatenate([rim, np.full((4, 1), depth)], axis=1)
    parts.append(np.stack([np.zeros((4, 3)), edges], axis=1))
    angle = np.linspace(-outer, outer, 17)
    arc = np.stack([np.sin(angle), np.zeros(17), -np.cos(angle)], axis=1) * length
    parts += [_loop(arc), _loop(arc[:, [1, 0, 2]])]
    return np.concatenate(parts)


def _area(kind: str, x: float, y: float, arrow: float, *, two_sided: bool) -> F8:
    corners = np.array([[x, y, 0.0], [-x, y, 0.0], [-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0]])
    parts = [_loop(corners) if kind == "rectangle" else _ring(x, y, 0.0), _arrow(arrow)]
    if two_sided:
        parts.append(_arrow(arrow) * [1.0, 1.0, -1.0])
    return np.concatenate(parts)


def _sun(size: float) -> F8:
    """A ring with five arrows."""
    places = np.array([[0, 0], [0.5, 0], [-0.5, 0], [0, 0.5], [0, -0.5]]) * size
    arrows = [_arrow(size) + np.array([x, y, 0.0]) for x, y in places.tolist()]
    return np.concatenate([_ring(0.5 * size, 0.5 * size, 0.0), *arrows])


def _arrow(length: float) -> F8:
    """Along -Z."""
    tip, wing = [0.0, 0.0, -length], 0.15 * length
    barbs = [[wing, 0, wing - length], [-wing, 0, wing - length], [0, wing, wing - length], [0, -wing, wing - length]]
    return np.array([[[0.0, 0.0, 0.0], tip], *[[tip, barb] for barb in barbs]])
