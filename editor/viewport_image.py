"""The viewport's picture: rendered only when something that shows in it has changed. No imgui."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any

from engine.core.errors import LucarnaError

if TYPE_CHECKING:
    from editor.session import Session

#: larger targets are refused by many drivers and never shown
MAX_SIZE = 8192
#: (milliseconds of a frame, the scale to render at while something moves if it takes longer)
COARSER = ((250.0, 0.25), (45.0, 0.5))

#: pictures after a change before a renderer can say that its exposure has settled: it reads what it did some frames ago
UNSURE = 4

#: seconds without a change before programs of other paths and views are made
REST = 1.0

#: seconds that a frame of the window spends on new shader programs: it stays under 50 ms where a program takes less
PATIENCE = 0.02
#: so many times that before there is any picture, while nobody does anything: fewer frames of an empty window
LONGER_AT_FIRST = 5.0


class ViewportImage:
    """`frame` is the last good picture; `renders` counts the pictures made, so that a test can see the editor sleep.

    `patience`: seconds that a frame of the window may spend on new shader programs, while the last picture stays; None
    waits for them all. `compiling`: (done, of how many) meanwhile."""

    def __init__(self) -> None:
        self.patience: float | None = None
        self.compiling: tuple[int, int] | None = None
        self.frame: Any = None
        self.renders = 0
        #: how often `update` was called: the picture is shown somewhere
        self.updates = 0
        self.error = ""
        self.width = 0
        self.height = 0
        #: the exposure is getting used to the picture, or frames are gathered: the same state gives another picture yet
        self.settling = False
        self.clock: Callable[[], float] = time.perf_counter
        self._shown_at: float | None = None
        self._unsure = 0
        self._key: Hashable = None
        self._moving = False
        self._scale = 1.0
        self._rested = 0.0
        #: (done, of how many) other paths and views, while their programs are made
        self.rehearsing: tuple[int, int] | None = None

    def update(self, session: Session, width: int, height: int) -> Any:
        """The frame for `session` at `width` x `height` pixels; renders if it differs from the one at hand.

        A failing render is logged once, and the last good picture stays."""
        document = session.document
        self.updates += 1
        if document is None or width < 1 or height < 1:
            return self.frame if document is not None else None
        width, height = min(width, MAX_SIZE), min(height, MAX_SIZE)
        session.width, session.height = width, height
        runtime = document.runtime
        runtime.scene.update()
        key = (id(runtime), width, height, *session.visible_state())
        if key == self._key and not self.settling:
            session.history_pictures.take(session, self.frame, resting=not session.interacting)
            self._rehearse(session)
            return self.frame
        self._rested, self.rehearsing = self.clock(), None
        try:
            with session.device_frame():
                frame = self._made(runtime, self._timed(session.view()), busy=session.handling)
            if frame is None:
                return self.frame
            self._settle(frame, changed=key != self._key)
            self.frame = frame
            self.renders += 1
            self.width, self.height, self.error = width, height, ""
            session.history_pictures.take(session, frame, resting=False)
        except LucarnaError as error:
            self.error, self.settling = str(error), False
            session.messages.error(error)
        # taken after the render: streaming may have moved a revision, and that is shown by the next one
        self._key = key
        return self.frame

    @property
    def rests_for(self) -> float:
        """Seconds of rest that `rehearsing` waits for yet."""
        return max(REST - (self.clock() - self._rested), 0.0)

    def disturb(self) -> None:
        """The user does something: what can wait does."""
        self._rested = self.clock()

    def _rehearse(self, session: Session) -> None:
        """Make programs of other paths and views, where the window is at rest and may."""
        self.rehearsing = None
        rehearsal = getattr(session.document.runtime, "rehearsal", None) if session.document is not None else None
        if self.patience is None or rehearsal is None or not session.preferences.prepare_views:
            return
        if session.software:  # its programs are made as they draw: each would hold the window up
            return
        if session.interacting or session.playback.playing or self.compiling is not None:
            return
        if self.clock() - self._rested < REST:
            self.rehearsing = (rehearsal.done, rehearsal.total)  # so that the window does not fall asleep before
            return
        with session.device_frame():
            if rehearsal.step(session.view(), self.patience):
                self.rehearsing = (rehearsal.done, rehearsal.total)

    def _timed(self, view: Any) -> Any:
        """The view with the time since the last picture, where pictures depend on those before; without, where there is
        none that an eye has got used to."""
        if getattr(view.settings, "takes_time", False):
            view.seconds = None if self._shown_at is None else self.clock() - self._shown_at
            if view.seconds is None and not view.settings.auto_exposure:
                view.seconds = 0.0
        return view

    def _settle(self, frame: Any, *, changed: bool) -> None:
        """Whether one more picture is wanted, although nothing else has changed."""
        facts = getattr(frame, "facts", None)
        if not (getattr(facts, "auto_exposure", False) or getattr(facts, "motion", False)):
            self._shown_at, self.settling = None, False
            return
        first, self._shown_at = self._shown_at is None, self.clock()
        self._unsure = 0 if first else UNSURE if changed else max(self._unsure - 1, 0)
        self.settling = self._unsure > 0 or not frame.settled

    def _made(self, runtime: Any, view: Any, *, busy: bool) -> Any:
        """A picture, or None while its programs are made. `busy`: the user does something meanwhile."""
        self.compiling = None
        if self.patience is None or not hasattr(runtime, "follow"):
            return runtime.render(view)
        longer = LONGER_AT_FIRST if self.frame is None and not busy else 1.0
        frame = runtime.follow(view, longer * self.patience)
        if frame is None:
            ahead = runtime.renderer.programs.ahead
            self.compiling = (ahead.done, ahead.total)
        return frame

    def resolution(self, session: Session) -> float:
        """1, or less while something moves and frames at full resolution take too long to follow it.

        Decided when the movement begins and kept to its end, so that the picture does not flicker between sizes."""
        if not session.interacting or not session.preferences.adaptive_resolution:
            self._scale, self._moving = 1.0, session.interacting
        elif not self._moving:
            self._moving = self.frame is not None  # what plays from the first picture on: that one tells
            ms = self.frame.stats.total_ms if self.frame is not None else 0.0
            self._scale = next((scale for limit, scale in COARSER if ms > limit), 1.0)
        return self._scale

    def invalidate(self) -> None:
        """Render again at the next update, whatever the state."""
        self._key = None

    def forget(self) -> None:
        """Drop the picture: its runtime is being closed."""
        self.frame, self._key, self.error, self.compiling = None, None, "", None
        self._shown_at, self.settling = None, False

    def pixels(self) -> Any:
        """The picture as u1[h,w,4], row 0 at the top, or None."""
        return None if self.frame is None else self.frame.color.read()
