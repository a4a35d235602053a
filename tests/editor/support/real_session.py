"""A session over the real engine on the null device: files, runtimes and histories are real, pictures are not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from editor.host import EngineHost
from editor.preferences import Preferences
from editor.session import Session


def real_session(recovery: Path | None = None) -> Session:
    from engine.gpu import open_device

    session = Session(EngineHost(), Preferences())
    session.device = open_device("null")
    session.save_preferences = False
    session.recovery_folder = recovery
    return session


def opened(session: Session, path: Path) -> Any:
    """Open `path` and return its document. What kept it from opening is raised."""
    session.failure = None
    session.open(path)
    settle(session)
    if session.failure is not None:
        raise session.failure
    return session.document


def settle(session: Session) -> None:
    """Poll until nothing is being opened or imported."""
    for _ in range(50):
        for job in (session.job, getattr(session, "importing", None)):
            if job is not None:
                job.wait(60)
        session.poll()
        if session.job is None and not session.queue and getattr(session, "importing", None) is None:
            return
    raise AssertionError("it does not come to rest")
