"""The first start: an animated sample on the stage, so that nobody looks at an empty window. No imgui."""

from __future__ import annotations

from pathlib import Path

from editor.operations import Operation, Operations
from editor.session import Session
from engine.core.errors import LucarnaError
from engine.core.paths import user_config_dir


def sample_project() -> Path:
    """The folder of the user's own copy of the sample, made where there is none. Raises UsageError, OutputError."""
    from engine.app.project import PROJECT_FILE, new_project

    folder = user_config_dir() / "Orrery"
    if not (folder / PROJECT_FILE).is_file():
        new_project(folder)
    return folder


def open_sample(session: Session) -> None:
    """Open it; where it cannot be made, say why."""
    try:
        session.open(sample_project())
    except LucarnaError as error:
        session.fail(error)


def greet(session: Session) -> None:
    """The first start without a file: the sample, and the card with the three choices over it."""
    open_sample(session)
    session.show_off = session.ui.welcome = True


def add_welcome_operations(ops: Operations) -> None:
    ops.add(Operation("file.open-sample", "Open the sample", open_sample, "Help", doc="An orrery, yours to take apart"))
