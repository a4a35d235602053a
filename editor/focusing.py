"""Focus by a click: the distance of what shows there becomes the one that is sharp. No imgui, no GL."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from editor.operations import Operation, Operations
from engine.render.one_sample import along

if TYPE_CHECKING:
    from editor.session import Session


def add_focus_operation(ops: Operations) -> None:
    ops.add(Operation(
        "tool.pick-focus", "Pick focus", toggle, "View", (), lambda s: s.document is not None,
        lambda s: s.tools.focusing, False, "Click what should be sharp: depth of field goes on, focused there",
    ))  # fmt: skip


def toggle(session: Session) -> None:
    """The next click in the viewport focuses; asked for again, it does not."""
    tools = session.tools
    tools.focusing, tools.measuring = not tools.focusing, False
    session.ui.notice = "Click what should be sharp" if tools.focusing else ""


def focus_at(session: Session, u: float, v: float) -> None:
    """Focus on what shows at (u, v) of the viewport, 0..1 from its top left: one entry of the undo history."""
    session.tools.focusing = False
    found = session.hits(u, v)
    if not found:
        session.ui.notice = "Nothing there to focus on"
        return
    eye = np.asarray(session.view().camera.world_from_camera, np.float64)
    # what is sharp is a plane: its distance is along the view, not to the point
    distance = float((eye[:3, 3] - found[0][1]) @ eye[:3, 2])
    chosen = {"depth_of_field": True, "focus": distance}
    session.apply_settings({**chosen, **along(chosen, int(getattr(session.settings, "samples", 1)))}, "Focus")
    session.ui.notice = f"Focus at {distance:.3g} m"
