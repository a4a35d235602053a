"""The shadow floor's switch: on, the scene throws its shadows on a floor that is not seen itself. No imgui."""

from __future__ import annotations

from typing import TYPE_CHECKING

from editor.operations import Operation

if TYPE_CHECKING:
    from editor.operations import Operations
    from editor.session import Session

#: how dark the shadows are when it is switched on; the render settings have the slider
STRENGTH = 0.8


def toggle(session: Session) -> None:
    """One entry of the history."""
    value = 0.0 if is_on(session) else STRENGTH
    session.edit("settings", "shadow_floor", (0,), ((value,),), label="Shadow floor" if value else "No shadow floor")


def is_on(session: Session) -> bool:
    return float(getattr(session.settings, "shadow_floor", 0.0)) > 0.0


def add_shadow_floor_operations(ops: Operations) -> None:
    ops.add(
        Operation(
            "view.shadow-floor", "Shadow floor", toggle, "View", (), lambda s: s.document is not None, is_on, False,
            "The scene's shadows on a floor below it that is not seen itself",
        )
    )  # fmt: skip
