"""Tabs: several documents open at once, one of them in front. No imgui, no GL.

The session's own fields are those of the document in front; `Tab` holds what each of the others had when it left the
front, so nothing else in the editor knows of more than one. What is not in front draws nothing and plays nothing;
its journal stays open, so a session that dies loses no edit of any of them.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from editor.animating.view import AnimatingView
from editor.camera_controls import OrbitCamera
from editor.playback import Playback

if TYPE_CHECKING:
    from pathlib import Path

    from editor.document import Document
    from editor.journal import Journal
    from editor.session import Session

#: fields that a session hands to the tab and takes back
FIELDS = (
    "camera", "playback", "journal", "animating", "followed", "drawing_noted", "forced_cost", "feature_effects",
    "reports", "report_settings", "_settings",
)  # fmt: skip


@dataclass(slots=True, eq=False)
class Tab:
    """A document and what belongs to looking at it. Of the one in front only `document` is up to date here."""

    document: Document
    camera: OrbitCamera = field(default_factory=OrbitCamera)
    playback: Playback = field(default_factory=Playback)
    journal: Journal | None = None
    animating: AnimatingView = field(default_factory=AnimatingView)
    followed: Any = None
    drawing_noted: tuple[Any, Any] = (None, None)
    forced_cost: Any = None
    feature_effects: Any = None
    reports: dict[str, Any] = field(default_factory=dict)
    report_settings: dict[str, dict[str, Any]] = field(default_factory=dict)
    _settings: Any = None
    points: list[Any] = field(default_factory=list)


def front(session: Session) -> int:
    """The place of the document in front among the tabs, or -1."""
    return next((i for i, tab in enumerate(session.tabs) if tab.document is session.document), -1)


def find(session: Session, path: Path) -> int:
    """The tab whose document was opened from `path`, or whose scene it is; -1 without one."""
    path = path.resolve()
    for index, tab in enumerate(session.tabs):
        if path in {tab.document.source.resolve(), tab.document.scene_path.resolve(), tab.document.saved_to}:
            return index
    return -1


def documents(session: Session) -> list[Document]:
    """All that are open, in the order of their tabs."""
    return [tab.document for tab in session.tabs]


def journals(session: Session) -> Iterator[tuple[Journal, Tab | None]]:
    """Every journal that is written, with the tab it lies in; None for that of the document in front."""
    if session.journal is not None:
        yield session.journal, None
    for tab in session.tabs:
        if tab.document is not session.document and tab.journal is not None:
            yield tab.journal, tab


def show(session: Session, index: int) -> None:
    """Bring the tab at `index` to the front; one outside the tabs, or in front already, changes nothing."""
    if not 0 <= index < len(session.tabs) or index == front(session):
        return
    park(session)
    tab = session.tabs[index]
    session.document = tab.document
    for name in FIELDS:
        setattr(session, name, getattr(tab, name))
    session.tools.points[:] = tab.points
    tab.journal = None
    session.ui.rename, session.ui.pick_list = -1, ()


def step(session: Session, by: int) -> None:
    """Bring the next tab to the front (-1: the one before), round and round."""
    if session.tabs:
        show(session, (front(session) + by) % len(session.tabs))


def park(session: Session) -> None:
    """Take the document in front away from there without closing it; the session is empty until another comes."""
    index = front(session)
    if index < 0:
        return
    tab = session.tabs[index]
    session.end_gesture()
    keep_compared = session.comparing.parked(session)
    for name in FIELDS:
        setattr(tab, name, getattr(session, name))
    tab.points = list(session.tools.points)
    session._settings = copy.deepcopy(session._settings)  # what comes next begins with the same, and goes its own way
    clear(session)
    keep_compared()


def clear(session: Session) -> None:
    """Nothing is in front: what was shown of it is forgotten."""
    if session.work is not None:
        session.work.close()
        session.work = None
    session.tools.forget()
    session.image.forget()
    with session.device_frame():
        session.thumbnails.forget()
        session.preview.forget()
        session.look_card.forget()
    session.comparing.forget(session)
    session.document = session.journal = session.forced_cost = session.feature_effects = None
    session.playback = Playback()
    session.reports, session.report_settings = {}, {}
    session.animating, session.followed, session.drawing_noted = AnimatingView(), None, (None, None)
    session.ui.rename, session.ui.pick_list = -1, ()


def move(session: Session, index: int, to: int) -> None:
    """Put a tab in another place of the row."""
    if 0 <= index < len(session.tabs):
        session.tabs.insert(max(0, min(to, len(session.tabs) - 1)), session.tabs.pop(index))
