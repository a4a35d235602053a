"""ShaderWatch: edited effects, shaders and materials -> the open document's runtime, and what is wrong with them.

A thread looks at the files four times a second and wakes the window, which sleeps while nothing happens; all else is
done on the window's thread. No imgui.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from editor.code.problems import PREVIOUS, Problem, all_problems
from engine.core.errors import LucarnaError
from engine.core.findings import Severity

if TYPE_CHECKING:
    from editor.session import Session

#: seconds between two looks of the thread
LOOK = 0.25
#: seconds between two looks at the files that are open as text
LOOK_AT_TEXTS = 0.25


class ShaderWatch:
    """`problems`: all that stands, for badge, markers and "next error". `wake`: makes a sleeping window draw."""

    def __init__(self) -> None:
        self.problems: tuple[Problem, ...] = ()
        self.wake: Callable[[], None] = lambda: None
        #: what the last change took, ms
        self.last_ms = 0.0
        #: grows with every change that was taken over
        self.taken = 0
        self._due = threading.Event()
        self._thread: threading.Thread | None = None
        self._reload: Any = None
        self._texts_at = 0.0
        self._next = -1
        self._proofs = 0

    @property
    def badge(self) -> str:
        """What to write over the picture, or ''."""
        if not self.problems:
            return ""
        more = f"   (+{len(self.problems) - 1})" if len(self.problems) > 1 else ""
        return self.problems[0].badge + more

    def poll(self, session: Session) -> None:
        """Once a frame."""
        now = time.monotonic()
        if now - self._texts_at > LOOK_AT_TEXTS:
            self._texts_at = now
            session.code.look()
        reload = getattr(session.document.runtime, "hot_reload", None) if session.document is not None else None
        if reload is not self._reload:
            self._reload = reload
            self._proofs = getattr(reload, "proofs", 0)
            self._report(session)
        if reload is None:
            return
        self._start_thread()
        if self._due.is_set() or reload.changed(now):
            self.reload(session, force=False)
        elif getattr(reload, "proofs", 0) != self._proofs:  # the first picture by new shaders was looked into
            self._proofs = reload.proofs
            self._report(session)

    def reload(self, session: Session, *, force: bool) -> None:
        """Look at the files now; `force` compiles everything again."""
        self._due.clear()
        reload = self._reload
        if reload is None:
            return
        with session.device_frame():
            if force:
                reload.invalidate()
            result = reload.apply()
        if result.names:
            self.taken += 1
            self.last_ms = result.ms
            names = ", ".join(result.names[:4]) + (
                f" and {len(result.names) - 4} more" if len(result.names) > 4 else ""
            )
            session.messages.info(f"Reloaded {names} in {result.ms:.0f} ms")
            self.wake()  # the frame after this one tells what `HotReload.prove` found
        self._report(session)

    @property
    def refused(self) -> bool:
        """Whether new shaders compile but were sent back, for they write NaN."""
        return bool(getattr(self._reload, "refused", ()))

    def draw_anyway(self, session: Session) -> None:
        """Show what was sent back all the same."""
        with session.device_frame():
            taken = self._reload.draw_anyway()
        if taken:
            session.messages.info(f"Drawn all the same: {', '.join(taken)}")
        session.image.invalidate()
        self._report(session)

    def next_problem(self, session: Session, step: int = 1) -> Problem | None:
        """Go to the next problem that has a place (-1: the one before), round and round."""
        placed = [p for p in self.problems if p.file and p.line]
        if not placed:
            session.ui.notice = "No errors" if not self.problems else self.problems[0].message
            return None
        self._next = (self._next + step) % len(placed) if self._next >= 0 else 0 if step > 0 else len(placed) - 1
        problem = placed[self._next]
        session.open_code(Path(problem.file), problem.line, problem.column)
        return problem

    def stop(self) -> None:
        """End the thread."""
        self._reload = None

    def _report(self, session: Session) -> None:
        """Take over what stands, and log what is new or gone."""
        standing: list[tuple[str, LucarnaError]] = list(self._reload.standing()) if self._reload is not None else []
        problems = all_problems(standing)
        if problems == self.problems:
            return
        known = set(self.problems)
        for problem in problems:
            if problem not in known:
                place = ":".join([problem.file, *(str(n) for n in (problem.line, problem.column) if n)])
                severity = Severity.ERROR if problem.state == PREVIOUS else Severity.WARNING
                session.messages.add(severity, problem.message, where=place, hint=problem.hint, code="shader")
        if not problems and known:
            session.messages.info("All shader errors are gone")
        self.problems, self._next = problems, -1

    def _start_thread(self) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="shader watch", daemon=True)
            self._thread.start()

    def _run(self) -> None:
        while (reload := self._reload) is not None:
            if not self._due.is_set() and reload.stale():
                self._due.set()
                self.wake()
            time.sleep(LOOK)
        self._thread = None
