"""Moment: a state of the view that can be shown again: render settings and a place in the undo history. No imgui."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from editor.commands.command import VIEW_TABLE, Edit
from engine.core.errors import InputError

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session

#: times of so many pictures are kept: their median is what a picture costs
TIMES = 9


@dataclass(slots=True)
class Moment:
    """`entry`: the last edit that was done then, None: none was. `pixels` u1[h,w,4], row 0 at the top; `revision` grows
    with every picture; `times`: milliseconds of the last ones."""

    label: str
    settings: dict[str, Any]
    entry: Edit | None
    pixels: NDArray[np.uint8] | None = None
    revision: int = 0
    times: list[float] = field(default_factory=list)
    #: its place in the history is gone: the picture is the last one there is
    frozen: bool = False
    _key: Hashable = None

    def place(self, document: Document) -> int:
        """How many edits were done then, or -1 where that state cannot be reached any more."""
        if self.entry is None:
            return 0
        entries = (*document.history.entries, *document.history.undone)
        return next((i + 1 for i, entry in enumerate(entries) if entry is self.entry), -1)

    def key(self, session: Session, width: int, height: int) -> Hashable:
        time = session.playback.time if session.playback.available else 0.0
        return session.camera, width, height, time, id(self.entry), tuple(sorted(self.settings.items()))

    def update(self, session: Session, width: int, height: int) -> bool:
        """Render it for the present camera, where that makes another picture; True when it was rendered.

        Afterwards the scene is as before, but the renderer's textures hold this picture. Raises LucarnaError."""
        document = session.document
        assert document is not None
        key = self.key(session, width, height)
        if key == self._key or width < 1 or height < 1 or document.history.in_gesture:
            return False
        place = self.place(document)
        self.frozen = place < 0
        if self.frozen:
            return False
        self._key = key
        self.render(session, width, height)
        return True

    def render(self, session: Session, width: int, height: int) -> None:
        """As `update`, whether the picture would be another or not."""
        document = session.document
        assert document is not None
        place = self.place(document)
        if place < 0:
            raise InputError(f"{self.label}: later edits have cut that branch of the history off", hint="take A anew")
        settings = type(session.settings)(**self.settings)
        view = session.host.view(session.camera, width, height, settings)
        with _visiting(session, document, place), session.device_frame():
            document.runtime.scene.update()
            frame = document.runtime.render(view)
            self.pixels = np.array(frame.color.read(), np.uint8)
        self.revision += 1
        self.times = [*self.times, float(frame.stats.total_ms)][-TIMES:]


@contextmanager
def _visiting(session: Session, document: Document, place: int) -> Iterator[None]:
    """The document as it was with `place` edits done; what is no part of the history comes back as it was, too."""
    if place == len(document.history.entries):
        yield
        return
    values = session.settings.values()
    selection, overrides = document.selection, dict(document.overrides)
    try:
        with document.history.visiting(place):
            yield
    finally:
        for name, value in values.items():
            setattr(session.settings, name, value)
        document.selection, document.overrides = selection, overrides


def now(session: Session, label: str) -> Moment:
    """The state of the view at present."""
    assert session.document is not None
    entries = session.document.history.entries
    return Moment(label, dict(session.settings.values()), entries[-1] if entries else None)


def before_last_edit(session: Session) -> Moment | None:
    """The state before the last entry of the history, or None where there is none; with the present render settings,
    unless that entry changed those."""
    assert session.document is not None
    entries = session.document.history.entries
    if not entries:
        return None
    settings = dict(session.settings.values())
    last = entries[-1]
    if last.target[0] == VIEW_TABLE:
        settings |= dict(zip(last.target[1].split(","), getattr(last, "before", ((),))[0], strict=True))
    return Moment(f"Before: {last.describe()}", settings, entries[-2] if len(entries) > 1 else None)
