"""What goes on in the background, as one list: opening, importing, measuring, shaders, thumbnails. No imgui."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from editor import work
from editor.baking import surroundings_waiting
from editor.session import Session


@dataclass(frozen=True, slots=True)
class Task:
    """`progress` 0..1, or -1 where unknown; `cancel` None: it cannot be called off."""

    title: str
    text: str = ""
    progress: float = -1.0
    cancel: Callable[[], None] | None = None


def running(session: Session) -> list[Task]:
    """The present ones, what the user waits for first."""
    found = []
    job, importing, working = session.job, session.importing, session.work
    if job is not None:
        found.append(Task(f"Opening {job.path.name}", job.text, job.fraction, job.cancel))
    if importing is not None:
        cancel = getattr(importing, "cancel", None)
        found.append(Task("Importing", importing.text, float(getattr(importing, "fraction", -1.0)), cancel))
    if working is not None:
        found.append(Task(working.title, working.text, working.progress, lambda: work.cancel(session)))
    if session.image.compiling is not None:
        found.append(_counted("Compiling shaders", *session.image.compiling))
    if session.image.rehearsing is not None:
        found.append(_counted("Preparing other views", *session.image.rehearsing))
    if surroundings_waiting(session):
        found.append(Task("Baking the surroundings", "The picture keeps those of before until then"))
    waiting = session.asset_pictures.waiting
    if waiting:
        found.append(Task("Thumbnails", f"{waiting} to go"))
    return found


def _counted(title: str, done: int, total: int) -> Task:
    return Task(title, f"{done} of {total}", done / max(total, 1))
