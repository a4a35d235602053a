"""Files dragged from the assets panel into the picture: models and scenes are placed where they are let go, panoramas
light the scene."""

from __future__ import annotations

import numpy as np
from imgui_bundle import imgui

from editor import dropping, prefabs
from editor.panels.base import ASSET
from editor.thumbnail_maker import ENVIRONMENTS, MODELS, sort_of
from editor.ui import Ui


def accept(ui: Ui, x: float, y: float, width: float, height: float) -> None:
    """Make the item before, the picture at (x, y), take what is let go over it."""
    session = ui.session
    path = session.ui.dragged
    if path is None or session.document is None or not imgui.begin_drag_drop_target():
        return
    taken = sort_of(path.name) in (MODELS, ENVIRONMENTS) and imgui.accept_drag_drop_payload_py_id(ASSET) is not None
    imgui.end_drag_drop_target()
    if not taken:
        return
    if sort_of(path.name) == ENVIRONMENTS:
        dropping.light_with(session, path)
        return
    pointer = imgui.get_io().mouse_pos
    matrix = np.eye(4)
    hits = session.hits((pointer.x - x) / width, (pointer.y - y) / height)
    matrix[:3, 3] = hits[0][1] if hits else session.camera.target
    prefabs.place(session, path, matrix)
