"""Over the picture: skeletons with their names and axes, ghosts of poses before and after, the path of root motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from editor import theme
from editor.animating.following import animation_of, drive_of, runtime_of
from editor.camera_controls import OrbitCamera, project
from editor.session import Session
from editor.widgets import em
from engine.animation import poses
from engine.core.errors import LucarnaError
from engine.math.color import linear_to_srgb
from engine.math.transform import compose

F8 = NDArray[np.float64]
GHOST_BEFORE, GHOST_AFTER = (0.38, 0.62, 0.95), (0.95, 0.55, 0.35)
AXES = ((0.93, 0.30, 0.30, 1.0), (0.56, 0.88, 0.39, 1.0), (0.30, 0.50, 0.95, 1.0))
#: scene-linear, by the number of bones that move a vertex, as shaders/lib/skin_views.glsl
INFLUENCES = (
    (0.0, 0.168, 0.445), (0.0, 0.342, 0.171), (0.871, 0.775, 0.054), (0.665, 0.112, 0.0), (0.604, 0.191, 0.386),
)  # fmt: skip
#: above so many bones names are left out, but for those near the pointer
MANY_NAMES = 80


def bones(scene: Any) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(joint rows, the nearest joint above each or -1) of all skins."""
    joints = np.unique(scene.skins.joint)
    parent = np.full(len(joints), -1, np.int64)
    place = {int(row): i for i, row in enumerate(joints)}
    above = scene.nodes.parent
    for i, row in enumerate(joints.tolist()):
        up = int(above[row])
        while up >= 0 and up not in place:
            up = int(above[up])
        parent[i] = place.get(up, -1)
    return joints, parent


def draw(session: Session, origin: tuple[float, float], width: float, height: float, hoverable: bool) -> int:
    """Draw what is switched on; the row of the bone under the pointer, or -1."""
    document, view = session.document, session.animating
    if document is None:
        return -1
    scene = document.runtime.scene
    if view.ghosts and drive_of(session) != "states":
        _ghosts(session, origin, width, height)
    if view.root_path:
        _root_path(session, origin, width, height)
    if str(getattr(session.settings, "view", "")) == "influences" and len(scene.skins):
        _influence_legend(origin, height)
    if not view.skeleton or not len(scene.skins):
        return -1
    joints, parent = bones(scene)
    places = scene.nodes.world[joints, :, 3]
    pixels, depth = project(session.camera, places, width, height)
    pixels = pixels + np.array(origin)
    seen = depth > session.camera.znear
    lines = imgui.get_window_draw_list()
    weights = _mask_of(session, joints)
    selected = set(document.selection)
    own = _weight_colors(scene, joints) if str(getattr(session.settings, "view", "")) == "weights" else None
    colors = [(0.85, 0.9, 1.0, 0.9)] * len(joints) if own is None else [(*c, 1.0) for c in own.tolist()]
    if weights is not None:
        colors = [mask_color(w) for w in weights.tolist()]
    colors = [theme.ACCENT if int(j) in selected else c for j, c in zip(joints, colors, strict=True)]
    for i in range(len(joints)):
        up = int(parent[i])
        if up >= 0 and seen[i] and seen[up]:  # what lies between two joints follows the upper one
            _bone(lines, pixels[up], pixels[i], colors[up])
    for i in np.flatnonzero(seen).tolist():
        lines.add_circle_filled(
            tuple(pixels[i].tolist()), 4.0 if int(joints[i]) in selected else 3.0, theme.u32(colors[i])
        )
    mouse = imgui.get_io().mouse_pos
    distance = np.where(seen, np.hypot(pixels[:, 0] - mouse.x, pixels[:, 1] - mouse.y), np.inf)
    near = int(np.argmin(distance)) if len(distance) else -1
    under = int(joints[near]) if hoverable and near >= 0 and distance[near] < em(0.7) else -1
    if view.axes:
        _axes(session.camera, scene.nodes.world[joints], pixels, seen, origin, width, height)
    _names(scene, joints, pixels, seen, selected, under, every=view.names and len(joints) <= MANY_NAMES)
    return under


def _names(scene: Any, joints: Any, pixels: F8, seen: Any, selected: Any, under: int, *, every: bool) -> None:
    """Names beside the joints; of those that would lie on one another, one: the pointed at, then selected, then upper
    ones in the tree first."""
    lines = imgui.get_window_draw_list()
    taken: list[tuple[float, float, float, float]] = []
    order = sorted(range(len(joints)), key=lambda i: (joints[i] != under, int(joints[i]) not in selected, i))
    for i in order:
        if not seen[i] or not (every or int(joints[i]) in selected or int(joints[i]) == under):
            continue
        name = str(scene.nodes.name[joints[i]])
        at = (float(pixels[i, 0]) + em(0.5), float(pixels[i, 1]) - em(0.6))
        size = imgui.calc_text_size(name)
        box = (at[0], at[1], at[0] + size.x, at[1] + size.y)
        if any(box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in taken):
            continue
        taken.append(box)
        lines.add_text((at[0] + 1, at[1] + 1), theme.u32((0, 0, 0, 0.8)), name)
        lines.add_text(at, theme.u32(theme.TEXT), name)


def _influence_legend(origin: tuple[float, float], height: float) -> None:
    """What the colours of the view of influences mean; the same as in shaders/lib/skin_views.glsl."""
    lines, x, y = imgui.get_window_draw_list(), origin[0] + em(0.6), origin[1] + height - em(4.4)
    words = ("1", "2", "3", "4", "5 or more bones")
    width = em(7.0) + sum(imgui.calc_text_size(w).x for w in words) + em(1.4)
    lines.add_rect_filled((x, y), (x + width, y + em(1.6)), theme.u32((0, 0, 0, 0.55)), 4.0)
    x += em(0.5)
    for word, color in zip(words, linear_to_srgb(np.array(INFLUENCES)).tolist(), strict=True):
        lines.add_rect_filled((x, y + em(0.45)), (x + em(0.7), y + em(1.15)), theme.u32((*color, 1.0)), 2.0)
        lines.add_text((x + em(0.9), y + em(0.25)), theme.u32(theme.TEXT), word)
        x += em(1.4) + imgui.calc_text_size(word).x


def mask_color(weight: float) -> theme.Rgba:
    """Of a bone that a mask takes with that weight: blue 0 to a lighter orange 1."""
    return 0.35 + 0.6 * weight, 0.45 + 0.2 * weight, 0.75 - 0.5 * weight, 1.0


def _weight_colors(scene: Any, joints: Any) -> F8:
    """f8[joints,3], display-encoded: the colours that the view of weights gives them (shaders/lib/skin_views.glsl)."""
    number = np.zeros(len(joints), np.int64)
    place = {int(row): i for i, row in enumerate(joints.tolist())}
    for first, count in zip(scene.skins.first.tolist(), scene.skins.count.tolist(), strict=True):
        for k, row in enumerate(scene.skins.joint[first : first + count].tolist()):
            number[place[row]] = k
    hue = np.mod(number * 0.6180339887, 1.0)[:, None] + np.array([0.0, 2.0, 1.0]) / 3.0
    rgb = np.clip(np.abs(np.mod(hue, 1.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0)
    linear = (0.5 + (rgb - 0.5) * 0.85) * (0.55 + 0.2 * (number % 3))[:, None]
    return np.asarray(linear_to_srgb(np.clip(linear, 0.0, 1.0)), np.float64)


def _bone(lines: Any, a: F8, b: F8, color: Any) -> None:
    """A narrow kite from joint to joint, as skeletons are drawn."""
    way = b - a
    length = float(np.hypot(*way))
    if length < 1.0:
        return
    side = np.array([-way[1], way[0]]) / length * min(0.09 * length, 7.0)
    knee = a + 0.18 * way
    points = [imgui.ImVec2(*p.tolist()) for p in (a, knee + side, b, knee - side)]
    lines.add_convex_poly_filled(points, theme.u32((*color[:3], 0.35)))
    lines.add_polyline(points, theme.u32(color), 1.0, imgui.ImDrawFlags_.closed)


def _axes(camera: OrbitCamera, world: F8, pixels: F8, seen: Any, origin: Any, width: float, height: float) -> None:
    lines = imgui.get_window_draw_list()
    length = 0.03 * camera.distance
    for axis in range(3):
        way = world[:, :, axis]
        size = np.linalg.norm(way, axis=1, keepdims=True)
        ends, depth = project(camera, world[:, :, 3] + length * way / np.where(size > 0, size, 1.0), width, height)
        ends = ends + np.array(origin)
        for i in np.flatnonzero(seen & (depth > camera.znear)).tolist():
            lines.add_line(tuple(pixels[i].tolist()), tuple(ends[i].tolist()), theme.u32(AXES[axis]), 1.5)


def _mask_of(session: Session, joints: Any) -> F8 | None:
    """f8[joints]: the weights of the mask that is being picked."""
    view, animation = session.animating, animation_of(session)
    if not view.picking_bone or animation is None or view.mask not in animation.model.masks:
        return None
    from editor.panels.bone_masks import mask_weights

    rows = runtime_of(session).cast_rows[animation.rig.source]
    of_row = dict(zip(rows.tolist(), mask_weights(session, view.mask).tolist(), strict=True))
    return np.array([of_row.get(int(j), 0.0) for j in joints])


def pick(session: Session, bone: int) -> bool:
    """A click on a bone: toggles it in the mask while masks are picked, else selects it. True when it was taken."""
    document, view = session.document, session.animating
    if document is None or bone < 0:
        return False
    if not view.picking_bone:
        document.select(bone, toggle=bool(imgui.get_io().key_ctrl))
        return True
    from editor.animating.editing import AnimationEditor
    from editor.panels.bone_masks import toggle

    editor = AnimationEditor(session)
    if editor.model is not None and view.mask in editor.model.masks:
        try:
            toggle(editor, view.mask, str(document.runtime.scene.nodes.name[bone]), view.fall_off)
        except LucarnaError as error:
            session.fail(error)
    return True


def ghost_places(session: Session, times: F8) -> tuple[F8, NDArray[np.int64]]:
    """World places f8[times, joints, 3] of the joints at `times`, and the joint above each: of the clip or timeline."""
    document = session.document
    assert document is not None
    runtime = runtime_of(session)
    scene = runtime.scene
    joints, parent = bones(scene)
    sampled = _sampled(session, times)
    if sampled is None or not len(joints):
        return np.zeros((len(times), 0, 3)), parent
    rows, pose, carried = sampled
    chain = sorted({int(r) for j in joints for r in _above(scene.nodes.parent, int(j))} | {int(j) for j in joints})
    column = {int(r): i for i, r in enumerate(rows.tolist())}
    which, copied = runtime.deck.copies.moving.repeat(rows)
    column.update(zip(copied.tolist(), which.tolist(), strict=True))
    world: dict[int, F8] = {}
    order = sorted(chain, key=lambda r: len(_above(scene.nodes.parent, r)))
    for row in order:
        if row in column:
            c = column[row]
            local = compose(pose[poses.T, :, c].T, pose[poses.R, :, c].T, pose[poses.S, :, c].T)
        else:
            local = np.broadcast_to(scene.nodes.local_matrix(row), (len(times), 4, 4))
        if row == carried[0]:
            local = carried[1]
        up = int(scene.nodes.parent[row])
        world[row] = world[up] @ local if up in world else local
    return np.stack([world[int(j)][:, :3, 3] for j in joints], axis=1), parent


def _above(parent: Any, row: int) -> list[int]:
    found = []
    row = int(parent[row])
    while row >= 0:
        found.append(row)
        row = int(parent[row])
    return found


def _sampled(session: Session, times: F8) -> Any:
    """(node rows, poses f8[10,times,n], (row carried by root motion, its matrices)) of what plays."""
    from engine.animation.rig import moved_nodes, rig_of
    from engine.animation.sampler import ClipSampler
    from engine.math import quat

    runtime = runtime_of(session)
    animation = animation_of(session)
    if drive_of(session) == "timeline":
        rows = runtime.cast_rows[animation.rig.source]
        carried: Any = (-1, None)
        if animation.top >= 0 and runtime.deck.root_motion:
            way = animation.sequence.way(times)
            turn = quat.from_axis_angle(np.array([0.0, 1.0, 0.0]), way[:, 2])
            row = int(runtime.cast_rows[animation.top])
            node = runtime.cast[animation.top]
            place = quat.rotate(turn, np.array(node.translation)) + np.stack(
                [way[:, 0], 0 * way[:, 0], way[:, 1]], axis=1
            )
            carried = (
                row,
                compose(place, quat.multiply(turn, np.array(node.rotation)), np.tile(node.scale, (len(times), 1))),
            )
        return rows, animation.sequence.pose(times), carried
    active = [runtime.clips[i] for i in runtime.deck.active]
    if not active:
        return None
    rig = rig_of(runtime.cast, moved_nodes(active, len(runtime.cast)))
    pose = poses.resting(rig.rest, len(times))
    for clip in active:
        ClipSampler(clip, rig).sample(times, pose)
    return runtime.cast_rows[rig.source], pose, (-1, None)


def _ghosts(session: Session, origin: tuple[float, float], width: float, height: float) -> None:
    view, lines = session.animating, imgui.get_window_draw_list()
    steps = np.array([k for k in range(-view.ghosts, view.ghosts + 1) if k])
    times = session.playback.time + steps * view.ghost_step
    keep = (times >= 0.0) & (times <= session.playback.duration)
    steps, times = steps[keep], times[keep]
    if not len(times):
        return
    places, parent = ghost_places(session, times)
    for step, at in zip(steps.tolist(), places, strict=True):
        pixels, depth = project(session.camera, at, width, height)
        pixels = pixels + np.array(origin)
        fade = 0.75 * (1.0 - (abs(step) - 1) / max(view.ghosts, 1))
        color = theme.u32((*(GHOST_BEFORE if step < 0 else GHOST_AFTER), fade))
        for i, up in enumerate(parent.tolist()):
            if up >= 0 and depth[i] > session.camera.znear and depth[up] > session.camera.znear:
                lines.add_line(tuple(pixels[up].tolist()), tuple(pixels[i].tolist()), color, 2.0)


def _root_path(session: Session, origin: tuple[float, float], width: float, height: float) -> None:
    animation = animation_of(session)
    if animation is None or animation.top < 0 or drive_of(session) != "timeline" or animation.sequence is None:
        return
    times = np.linspace(0.0, animation.sequence.duration, 128)
    way = animation.sequence.way(times)
    start = np.asarray(runtime_of(session).cast[animation.top].translation)
    points = start + np.stack([way[:, 0], 0 * way[:, 0], way[:, 1]], axis=1)
    pixels, depth = project(session.camera, points, width, height)
    pixels = pixels + np.array(origin)
    lines = imgui.get_window_draw_list()
    for a, b in zip(range(127), range(1, 128), strict=True):
        if depth[a] > session.camera.znear and depth[b] > session.camera.znear:
            lines.add_line(tuple(pixels[a].tolist()), tuple(pixels[b].tolist()), theme.u32((0.4, 0.85, 0.6, 0.9)), 2.0)
