"""Work: something long that the window does in small steps between its frames: measuring, experiments. No imgui.

One at a time. A step runs on the window's thread, where the device is; while there is work the window does not sleep.
"""

from __future__ import annotations

import statistics
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from editor.session import Session

#: frames before times count: programs are compiled, and a GPU's times come three frames late
WARM_UP = 4
TIMED = 5


class Work(Protocol):
    """`progress` 0..1, `text`: what is being done."""

    title: str
    progress: float
    text: str

    def step(self, session: Session) -> bool:
        """Do a part; True while there is more. LucarnaError ends it."""

    def close(self) -> None:
        """Over: done, called off, failed, or the document goes."""


@dataclass(frozen=True, slots=True)
class ForcedCost:
    """What a frame costs as it is and with nothing left out: medians of milliseconds, `passes` in the forced frame.

    `plan`: the plan that ran when it was measured; for another one these are old numbers."""

    plan: Any
    pruned_ms: float
    forced_ms: float
    passes: dict[str, float]
    frames: int
    #: half the range of the single frames, whichever way it is larger: differences below it mean nothing
    noise_ms: float = 0.0


@dataclass(slots=True)
class MeasureLeftOut:
    """Renders the viewport's frame as it is and with everything forced, one picture a step."""

    title: str = "Measuring what is left out"
    progress: float = 0.0
    text: str = ""
    result: ForcedCost | None = None
    _frames: list[tuple[bool, Any]] = field(default_factory=list)

    def step(self, session: Session) -> bool:
        total = 2 * (WARM_UP + TIMED)
        document = session.document
        if document is None or session.image.frame is None:
            return False
        number = len(self._frames)
        forced = number < WARM_UP + TIMED
        values = {**session.settings.values(), "force_all": forced}
        settings = type(session.settings)(**values)
        view = session.host.view(session.camera, session.width, session.height, settings)
        with session.device_frame():
            frame = document.runtime.render(view)
        self._frames.append((forced, frame.stats))
        self.progress = (number + 1) / total
        self.text = f"{'Everything forced' if forced else 'As it is'}: frame {number + 1} of {total}"
        if number + 1 < total:
            return True
        self.result = self._summary(session)
        session.forced_cost = self.result
        session.image.invalidate()
        return False

    def close(self) -> None:
        self._frames.clear()

    def _summary(self, session: Session) -> ForcedCost:
        forced = [stats for on, stats in self._frames if on][WARM_UP:]
        pruned = [stats for on, stats in self._frames if not on][WARM_UP:]
        names = dict.fromkeys(p.name for stats in forced for p in stats.passes)
        return ForcedCost(
            session.image.frame.graph.plan,
            statistics.median(s.total_ms for s in pruned),
            statistics.median(s.total_ms for s in forced),
            {name: statistics.median(s.ms(name) for s in forced) for name in names},
            TIMED,
            max((max(s.total_ms for s in run) - min(s.total_ms for s in run)) / 2 for run in (forced, pruned)),
        )


def start(session: Session, work: Work) -> bool:
    """Begin; False, with a word to the user, while something else is being done."""
    if session.work is not None:
        session.ui.notice = f"{session.work.title} is not done yet"
        return False
    session.work = work
    return True


def cancel(session: Session) -> None:
    if session.work is not None:
        session.work.close()
        session.ui.notice = f"{session.work.title}: called off"
        session.work = None


def step(session: Session) -> None:
    """Once a frame: do a part of the work, if there is any. What fails is logged and ends it."""
    from engine.core.errors import LucarnaError

    work = session.work
    if work is None:
        return
    try:
        more = work.step(session)
    except LucarnaError as error:
        session.fail(error)
        more = False
    if not more:
        work.close()
        session.work = None
