"""Looks: the render settings under which a picture can be held against another program's. No imgui.

Each sets the curve to the display and takes away what those programs would not have done: exposure of its own, bloom,
a scaled environment. Surroundings, their rotation and lights stay as they are: load the same panorama there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from editor.operations import Operation, Operations
from editor.session import Session

#: nothing between the scene's light and the curve
PLAIN: dict[str, Any] = {
    "auto_exposure": False, "bloom": 0.0, "environment_intensity": 1.0, "sun_intensity": 1.0,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Look:
    """`own`: the scene's own curve and exposure; else 0 EV in all, whatever the scene says."""

    id: str
    label: str
    tone_map: str
    doc: str
    own: bool = False


LOOKS = (
    Look("scene", "Scene's own", "scene", "Curve and exposure as the scene file says", own=True),
    Look("blender", "Match Blender (AgX)", "agx", "Blender's default view transform, at 0 EV"),
    Look("khronos", "Match Khronos (PBR Neutral)", "neutral", "As the glTF viewers of Khronos show it, at 0 EV"),
    Look("aces", "ACES", "aces", "The film curve many game engines use, at 0 EV"),
    Look("raw", "Raw", "none", "No curve: 18 % grey stays 18 % grey, what is brighter than white is cut"),
)


def settings_of(look: Look, scene_exposure: float) -> dict[str, Any]:
    """The render settings of a look in a scene whose own exposure is that many EV."""
    return {**PLAIN, "tone_map": look.tone_map, "exposure": 0.0 if look.own else 0.0 - scene_exposure}


def current(session: Session) -> Look | None:
    """The look that the settings are in, or None: somebody's own."""
    values = session.settings.values()
    for look in LOOKS:
        wanted = settings_of(look, _scene_exposure(session))
        if all(values[name] == value for name, value in wanted.items() if name in values):
            return look
    return None


def add_look_operations(ops: Operations) -> None:
    """One for each look."""
    for i, look in enumerate(LOOKS):
        ops.add(
            Operation(
                f"look.{look.id}", f"Look: {look.label}", _setter(look), "View", (), lambda s: s.document is not None,
                _is(look), i == 0, look.doc,
            )
        )  # fmt: skip


def _setter(look: Look) -> Callable[[Session], None]:
    return lambda s: s.apply_settings(settings_of(look, _scene_exposure(s)), label=f"Look: {look.label}")


def _is(look: Look) -> Callable[[Session], bool]:
    return lambda session: session.document is not None and current(session) is look


def _scene_exposure(session: Session) -> float:
    return 0.0 if session.document is None else float(session.document.runtime.scene.look.exposure)
