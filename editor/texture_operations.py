"""Operations on the texture viewer: what it looks at. No imgui."""

from __future__ import annotations

from pathlib import Path

from editor.arguments import Argument
from editor.operations import Operation, Operations
from editor.session import Session
from engine.core.errors import UsageError
from engine.framegraph.builder import did_you_mean


def add_texture_operations(ops: Operations) -> None:
    """Add them all to the registry."""
    ops.add(
        Operation(
            "texture.show", "Look at an image file", _file, arguments=(Argument("path", "path", doc="an image file"),),
            doc="In the texture viewer: channels, mips, values",
        )
    )  # fmt: skip
    ops.add(
        Operation(
            "texture.show-target", "Look at a target of the frame", _target,
            arguments=(Argument("name", "text", doc="as the frame graph names it"),),
            doc="In the texture viewer, as the last pass that uses it leaves it",
        )
    )  # fmt: skip


def _file(session: Session, path: Path) -> None:
    path = Path(path)
    if not path.is_file():
        raise UsageError(f"there is no file {path}")
    session.ui.show_texture, session.ui.focus_panel = path.resolve(), "Textures"


def _target(session: Session, name: str) -> None:
    plan = getattr(getattr(session.image.frame, "graph", None), "plan", None)
    if plan is None or name not in plan.descs:
        known = plan.descs if plan is not None else {}
        raise UsageError(f"the last frame has no target {name!r}", hint=did_you_mean(name, known))
    session.ui.show_texture, session.ui.focus_panel = name, "Textures"
