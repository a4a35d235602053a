"""Operations on habits: mouse or trackpad, what plays behind another window, pictures a second. No imgui."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from editor.arguments import Argument
from editor.navigation import POINTERS
from editor.operations import Operation, Operations
from editor.preferences import IN_BACKGROUND
from editor.session import Session

#: choice -> its label
BACKGROUNDS = {"slow": "plays slowly", "full": "plays on", "stop": "stops"}


def add_habit_operations(ops: Operations) -> None:
    """Add them all to the registry."""
    for i, pointer in enumerate(POINTERS):
        about = "Two fingers do what the keymap says; a pinch zooms" if pointer == "trackpad" else "The wheel zooms"
        run, checked = _choice("pointer", pointer)
        id, label = f"help.pointer-{pointer}", f"Pointer: {pointer}"
        ops.add(Operation(id, label, run, "Help", checked=checked, separator=i == 0, doc=about))
    run, checked = _toggle("reverse_scroll")
    ops.add(
        Operation(
            "help.reverse-scroll", "Reverse scrolling", run, "Help", checked=checked,
            doc="Two fingers and the wheel go the other way",
        )
    )  # fmt: skip
    ops.add(
        Operation(
            "view.fly", "Fly", _fly, "View", ("Shift+`",), lambda s: s.document is not None, lambda s: s.tools.flying,
            doc="W A S D Q E and the pointer steer the camera, no button held; a click or Escape ends it",
        )
    )  # fmt: skip
    for i, choice in enumerate(IN_BACKGROUND):
        run, checked = _choice("in_background", choice)
        ops.add(
            Operation(
                f"view.background-{choice}", f"Behind another window: {BACKGROUNDS[choice]}", run, "Window",
                checked=checked, separator=i == 0, doc="What animation does meanwhile; minimised, it always stops",
            )
        )  # fmt: skip
    ops.add(
        Operation(
            "view.fps-limit", "Limit pictures a second", _limit, "Window",
            arguments=(Argument("fps", "int", min=0, max=1000, doc="0: as many as the display shows"),),
            doc="Saves power while something plays",
        )
    )  # fmt: skip


def _choice(name: str, value: str) -> tuple[Callable[[Session], None], Callable[[Session], bool]]:
    def run(session: Session) -> None:
        setattr(session.preferences, name, value)
        session.remember()

    return run, lambda session: bool(getattr(session.preferences, name) == value)


def _toggle(name: str) -> tuple[Callable[[Session], None], Callable[[Session], bool]]:
    def run(session: Session) -> None:
        setattr(session.preferences, name, not getattr(session.preferences, name))
        session.remember()

    return run, lambda session: bool(getattr(session.preferences, name))


def _fly(session: Session) -> None:
    session.tools.flying = not session.tools.flying


def _limit(session: Session, fps: Any) -> None:
    session.preferences.fps_limit = 0 if int(fps) <= 0 else max(int(fps), 5)
    session.remember()
