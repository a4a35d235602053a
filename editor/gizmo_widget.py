"""The gizmo in the viewport: ImGuizmo's handles round the selection, one undo entry per drag. Ctrl snaps to a grid,
Shift to the surface under the pointer."""

from __future__ import annotations

from typing import Any

import numpy as np
from imgui_bundle import imgui, imguizmo
from numpy.typing import NDArray

from editor import gizmo, surface
from editor.document import Document
from editor.gizmo import Grip
from editor.ui import Ui
from engine.math import quat, transform

_g = imguizmo.im_guizmo
OPERATIONS = {"move": _g.OPERATION.translate, "rotate": _g.OPERATION.rotate, "scale": _g.OPERATION.scale}
#: seen exactly along an axis the widget finds no handle of scale: its planes go through the eye. This turns them by
#: too little to be seen
TILT = transform.compose((0.0, 0.0, 0.0), quat.from_axis_angle((0.6, 0.64, 0.48), 2e-3), (1.0, 1.0, 1.0))
VERBS = {"move": "Move", "rotate": "Turn", "scale": "Scale"}


class GizmoWidget:
    """`busy`: the pointer is on a handle or drags one, so the viewport must leave the left button alone."""

    def __init__(self) -> None:
        self.busy = False
        self.using = False
        self._grip: Grip | None = None
        self._start: NDArray[np.float64] = np.eye(4)
        self._held: NDArray[np.float64] = np.eye(4)
        self._serial = 0
        #: where the middle of what is held touches the ground when the drag begins, world
        self._foot: NDArray[np.float64] = np.zeros(3)
        #: the picture in the window: x, y, width, height
        self._area = (0.0, 0.0, 1.0, 1.0)
        self._rows_key: object = None
        self._rows: tuple[int, ...] = ()

    def draw(self, ui: Ui, x: float, y: float, width: float, height: float, *, blocked: bool) -> None:
        """Over a picture at (x, y), inside its window. `blocked`: another gesture has the pointer."""
        session, document = ui.session, ui.session.document
        mode = session.tools.mode
        if document is None or mode not in OPERATIONS or not document.selection:
            self._let_go(ui)
            return
        pivot = self._grip.pivot if self.using and self._grip is not None else self._pivot(ui, document)
        if pivot is None or not np.isfinite(pivot).all():
            self._let_go(ui)
            return
        self._area = (x, y, width, height)
        camera = session.camera
        view, clip = gizmo.camera_matrices(camera, width / max(height, 1.0))
        held = self._held if self.using else pivot @ TILT if mode == "scale" else pivot
        relative = held.copy()
        relative[:3, 3] -= camera.eye()
        matrix = _to_widget(relative)
        _g.begin_frame()  # forgets the handle that was under the pointer in the frame before
        _style()
        _g.set_orthographic(camera.orthographic)
        _g.set_drawlist(imgui.get_window_draw_list())
        _g.set_rect(x, y, width, height)
        _g.set_gizmo_size_clip_space(0.14)
        _g.allow_axis_flip(False)  # an arrow always points the positive way
        _g.enable(not blocked)
        space = _g.MODE.local if _local(ui) else _g.MODE.world
        changed = bool(
            _g.manipulate(_to_widget(view), _to_widget(clip), OPERATIONS[mode], space, matrix, None, _snap(ui, mode))
        )
        using = bool(_g.is_using())
        if using and not self.using:
            self._grip = gizmo.begin(document, local=_local(ui))
            self._start = _from_widget(_to_widget(relative))
            self._serial += 1
            if self._grip is not None:
                self._foot = surface.foot_of(document, self._grip)
        self.busy = using or (bool(_g.is_over()) and not blocked)
        self.using = using
        now = _from_widget(matrix)
        self._held = now.copy()
        self._held[:3, 3] += camera.eye()
        if using and changed and self._grip is not None:
            self._apply(ui, self._grip, now, mode)
        if not using and self._grip is not None:
            self._grip = None
            session.end_gesture()

    def _pivot(self, ui: Ui, document: Document) -> NDArray[np.float64] | None:
        """Where the handles stand; which rows they hold is found again only when the selection or the tree changed."""
        key = (document.selection, frozenset(document.locked), int(document.runtime.scene.structure_rev))
        if key != self._rows_key:
            self._rows_key, self._rows = key, gizmo.held_rows(document)
        return gizmo.pivot_of(document, self._rows, local=_local(ui)) if self._rows else None

    def _apply(self, ui: Ui, grip: Grip, now: NDArray[np.float64], mode: str) -> None:
        """`now`, `_start`: the pivot relative to the eye, both as the widget rounds them."""
        session = ui.session
        if mode == "scale":
            lengths = np.linalg.norm(now[:3, :3], axis=0) / np.linalg.norm(self._start[:3, :3], axis=0)
            # within float32 of 1 an axis was not touched
            x, y, z = (1.0 if abs(f - 1.0) < 1e-5 else float(f) for f in lengths)
            factors = (x, y, z)
            if len(grip.rows) == 1:
                values = gizmo.scaled_alone(grip, factors)
            else:
                values = gizmo.moved(grip, gizmo.scaling(grip, factors), mode)
        else:
            delta = np.eye(4)
            if mode == "rotate":
                turn = now[:3, :3] @ self._start[:3, :3].T
                u, _s, vt = np.linalg.svd(turn)  # the nearest rotation: the widget works in float32
                delta[:3, :3] = u @ vt
                at = grip.pivot[:3, 3]
                delta[:3, 3] = at - delta[:3, :3] @ at
            else:
                delta[:3, 3] = now[:3, 3] - self._start[:3, 3]
                on = self._surface(ui, grip) if imgui.get_io().key_shift else None
                if on is not None:
                    delta[:3, 3] = on - self._foot
            values = gizmo.moved(grip, delta, mode)
        count = len(grip.rows)
        what = session.node_name(grip.rows[0]) if count == 1 else f"{count} nodes"
        label = f"{VERBS[mode]} {what}"
        session.edit("nodes", "local", grip.rows, values, gesture=("gizmo", self._serial), label=label)

    def _surface(self, ui: Ui, grip: Grip) -> NDArray[np.float64] | None:
        """The point of the scene under the pointer that is not what is dragged; None beside everything."""
        x, y, width, height = self._area
        pointer = imgui.get_io().mouse_pos
        return surface.under(ui.session, grip.rows, (pointer.x - x) / width, (pointer.y - y) / height)

    def _let_go(self, ui: Ui) -> None:
        if self._grip is not None:
            ui.session.end_gesture()
        self._grip, self.busy, self.using = None, False, False


def _style() -> None:
    """Lines that can be seen and hit."""
    style = _g.get_style()
    style.translation_line_thickness, style.rotation_line_thickness, style.scale_line_thickness = 3.5, 3.0, 3.5
    style.rotation_outer_line_thickness, style.center_circle_size = 2.0, 5.0


def _local(ui: Ui) -> bool:
    """Whether the handles are turned as the node; those of scaling always are, since scale has no other axes."""
    return bool(ui.session.tools.local) or ui.session.tools.mode == "scale"


def _snap(ui: Ui, mode: str) -> Any:
    """While Ctrl is held."""
    if not imgui.get_io().key_ctrl:
        return None
    step = {"move": gizmo.snap_step(ui.session.camera), "rotate": gizmo.SNAP_DEGREES, "scale": gizmo.SNAP_FACTOR}[mode]
    return _g.Matrix3([step] * 3)


def _to_widget(matrix: NDArray[np.float64]) -> Any:
    """Column-major floats."""
    return _g.Matrix16(matrix.T.reshape(16).tolist())


def _from_widget(matrix: Any) -> NDArray[np.float64]:
    result: NDArray[np.float64] = np.array(matrix.values, np.float64).reshape(4, 4).T
    return result
