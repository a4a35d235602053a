"""Operations that edit the scene's structure, choose the tool, select, isolate, measure, and go through the history."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from editor import scripting, surface
from editor.bookmarks import add_bookmark_operations
from editor.commands import structure
from editor.document import Document
from editor.operations import Operation, Operations, always
from editor.selecting import hidden_by_isolating
from editor.session import Session
from engine.assets.scene import CameraAsset, LightAsset
from engine.core.errors import LucarnaError

Run = Callable[[Session], None]
Test = Callable[[Session], bool]
AREA_KINDS = ("rectangle", "disk")
#: kind -> lux that a fresh light gives at what is looked at
LIGHTS = {"point": 3.0, "spot": 6.0, "directional": 1.2, "rectangle": 4.0, "disk": 4.0}


def add_editing_operations(ops: Operations) -> None:
    """Add them all to the registry."""

    def add(
        id: str, label: str, run: Run, *keys: str, menu: str = "", enabled: Test = _has_document,
        checked: Test | None = None, separator: bool = False, about: str = "",
    ) -> None:  # fmt: skip
        ops.add(Operation(id, label, run, menu, keys, enabled, checked, separator, about))

    sel = _has_selection
    add("edit.rename", "Rename", _rename, "F2", menu="Edit", enabled=sel, separator=True)
    add("edit.duplicate", "Duplicate", structural(structure.duplicate), "Ctrl+D", menu="Edit", enabled=sel)
    add("edit.delete", "Delete", structural(structure.delete), "Delete", menu="Edit", enabled=sel)
    add("edit.group", "Group", structural(structure.group), "Ctrl+G", menu="Edit", enabled=sel)
    add("edit.unparent", "Move to the top of the tree", unparent, "Shift+P", menu="Edit", enabled=sel,
        about="Keeps its place in the world")  # fmt: skip
    add("edit.select-all", "Select all", _select_all, "Ctrl+A", menu="Edit", separator=True)
    add("edit.select-children", "Select children", _select_children, "Shift+C", menu="Edit", enabled=sel)
    add("edit.isolate", "Isolate selection", isolate, "Shift+H", menu="Edit", checked=_isolated,
        about="Hide all other meshes; again to bring them back")  # fmt: skip
    add("edit.drop", "Drop onto what is below", surface.drop, "End", menu="Edit", enabled=sel,
        about="Straight down to the next surface, else the ground; Shift while dragging stands it on any")  # fmt: skip
    add("edit.lock", "Lock or unlock selection", _lock, "L", menu="Edit", enabled=sel,
        about="A locked node is not selected in the viewport and not moved by the gizmo")  # fmt: skip
    add("edit.unlock-all", "Unlock all", _unlock_all, menu="Edit", enabled=_has_locked)

    add("add.empty", "Empty", add_empty, menu="Add", about="A node that carries nothing")
    for kind in LIGHTS:
        add(f"add.{kind}-light", f"{kind.capitalize()} light", _add_light(kind), menu="Add", separator=kind == "point")
    add("add.scatter-lights", "Scatter lights…", _show("Lights"), menu="Add",
        about="Many lights over the selection, the scene or a box, still or drifting")  # fmt: skip
    add("add.array", "Array of the selection…", _show("Lights"), menu="Add", enabled=sel,
        about="Repeat what is selected in a line, a grid or a ring")  # fmt: skip
    add("add.camera", "Camera from view", add_camera, menu="Add", separator=True, about="Sees what the viewport shows")

    for mode, label, key in (
        ("select", "Select", "Q"), ("move", "Move", "W"), ("rotate", "Rotate", "E"), ("scale", "Scale", "R"),
    ):  # fmt: skip
        run, checked = _tool(mode)
        add(f"tool.{mode}", f"{label} tool", run, key, menu="Edit", enabled=always, checked=checked,
            separator=mode == "select", about="Hold Ctrl to snap, Shift to stand on surfaces" if mode == "move"
            else "Hold Ctrl to snap" if mode != "select" else "")  # fmt: skip
    add("tool.local", "Local axes", _toggle_local, "X", menu="Edit", enabled=always, checked=lambda s: s.tools.local)
    add("tool.measure", "Measure", _toggle_measure, "M", menu="View", separator=True,
        checked=lambda s: s.tools.measuring, about="Click two points: their distance in metres")  # fmt: skip

    add_bookmark_operations(ops)
    for title in ("History", "Frame graph", "Textures", "Asset report", "Console"):
        add(f"view.panel-{title.lower().replace(' ', '-')}", f"Show {title.lower()}", _show(title), enabled=always)
    add("file.copy-command", "Copy as command", _copy_command, "Ctrl+Shift+C", menu="File", separator=True,
        about="The command line that renders what the viewport shows")  # fmt: skip
    add("file.copy-script", "Copy history as script", _copy_script, menu="File",
        about="The edits so far, for `lucarna run`")  # fmt: skip


def structural(change: Callable[[Document, Sequence[int]], None]) -> Run:
    """An operation that makes `change` to the selection; what it refuses is logged and shown."""

    def run(session: Session) -> None:
        if session.document is not None and session.document.selection:
            _try(session, lambda document: change(document, document.selection))

    return run


def reparent(session: Session, rows: Sequence[int], parent: int) -> None:
    """Hang nodes below another (-1: the top), where they are."""
    document = session.document
    if document is None:
        return
    below = scripting.nodes(document, [parent])[0] if parent >= 0 else "-1"
    line = f"select({', '.join(scripting.nodes(document, rows))}); run('edit.reparent', parent={below})"
    with scripting.doing(session, line):
        _try(session, lambda document: structure.reparent(document, rows, parent))


def unparent(session: Session) -> None:
    if session.document is not None:
        reparent(session, session.document.selection, -1)


def add_empty(session: Session) -> None:
    _try(session, lambda document: structure.add_empty(document, _at_target(session)))


def add_camera(session: Session) -> None:
    camera = CameraAsset(yfov=session.camera.yfov, znear=session.camera.znear)
    if session.camera.orthographic:
        camera = CameraAsset("orthographic", ymag=session.camera.ymag, znear=session.camera.znear)
    matrix = session.camera.world_from_camera()
    _try(session, lambda document: structure.add_camera(document, matrix, camera))


def isolate(session: Session) -> None:
    """Hide every mesh but the selected ones; again brings back what showed before."""
    document = session.document
    if document is None:
        return
    if document.isolated is not None:
        alive = document.runtime.scene.nodes.alive
        rows = [r for r in document.isolated if r < len(alive) and alive[r]]
        document.isolated = None
        if rows:
            session.edit("nodes", "visible", rows, [True] * len(rows), label="Show all again")
    elif document.selection:
        rows = hidden_by_isolating(document, document.selection)
        if rows:
            document.isolated = dict.fromkeys(rows, True)
            label = f"Isolate {session.node_name(document.primary)}"
            session.edit("nodes", "visible", rows, [False] * len(rows), label=label)


def _try(session: Session, change: Callable[[Document], None]) -> None:
    if session.document is None:
        return
    try:
        change(session.document)
    except LucarnaError as error:
        session.fail(error)


def _at_target(session: Session) -> NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[:3, 3] = session.camera.target
    return matrix


def _add_light(kind: str) -> Run:
    def run(session: Session) -> None:
        matrix = _at_target(session)
        matrix[1, 3] += 0.25 * session.camera.distance  # above what is looked at
        if kind != "point":  # shining down, from the side for the sun
            angle = -math.pi / 4 if kind == "directional" else -math.pi / 2
            cos, sin = math.cos(angle), math.sin(angle)
            matrix[:3, :3] = [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]
        away = 0.25 * session.camera.distance
        size = 0.5 * away if kind in AREA_KINDS else 1.0
        # what it gives straight ahead: lux is candela over distance squared; candela is nit times area
        scale = 1.0 if kind == "directional" else away**2 / (size * size if kind in AREA_KINDS else 1.0)
        light = LightAsset(kind, intensity=LIGHTS[kind] * max(min(scale, 1e6), 1e-6), width=size, height=size)
        _try(session, lambda document: structure.add_light(document, matrix, light))

    return run


def _rename(session: Session) -> None:
    if session.document is not None:
        session.ui.rename = session.document.primary


def _select_all(session: Session) -> None:
    if session.document is not None:
        alive = np.flatnonzero(session.document.runtime.scene.nodes.alive)
        session.document.selection = tuple(int(r) for r in alive)


def _select_children(session: Session) -> None:
    document = session.document
    if document is not None:
        children = [c for row in document.selection for c in document.children_of(row)]
        if children:
            document.selection = tuple(dict.fromkeys(children))


def _lock(session: Session) -> None:
    document = session.document
    if document is None:
        return
    if document.locked.issuperset(document.selection):
        document.locked.difference_update(document.selection)
    else:
        document.locked.update(document.selection)


def _unlock_all(session: Session) -> None:
    if session.document is not None:
        session.document.locked.clear()


def _tool(mode: str) -> tuple[Run, Test]:
    def run(session: Session) -> None:
        session.tools.mode = mode

    return run, lambda session: session.tools.mode == mode


def _toggle_local(session: Session) -> None:
    session.tools.local = not session.tools.local


def _toggle_measure(session: Session) -> None:
    session.tools.measuring = not session.tools.measuring
    session.tools.points.clear()


def _copy_command(session: Session) -> None:
    from editor.as_command import render_command

    session.ui.copy_text = render_command(session)
    session.ui.notice = "Copied the command"


def _copy_script(session: Session) -> None:
    if session.document is not None:
        session.ui.copy_text = scripting.history_script(session.document)
        session.ui.notice = "Copied the history as a script"


def _show(title: str) -> Run:
    def run(session: Session) -> None:
        session.ui.focus_panel = title

    return run


def _has_document(session: Session) -> bool:
    return session.document is not None


def _has_selection(session: Session) -> bool:
    return session.document is not None and bool(session.document.selection)


def _has_locked(session: Session) -> bool:
    return session.document is not None and bool(session.document.locked)


def _isolated(session: Session) -> bool:
    return session.document is not None and session.document.isolated is not None
