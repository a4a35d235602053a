"""What A and B cost: both rendered in turn, so that a machine that warms up or slows down does it to both."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from editor.comparing.moment import now
from editor.work import TIMED, WARM_UP

if TYPE_CHECKING:
    from editor.session import Session


@dataclass(slots=True)
class MeasureBoth:
    """See editor.work.Work: one picture a step."""

    title: str = "Measuring A and B"
    progress: float = 0.0
    text: str = ""
    _times: tuple[list[float], list[float]] = field(default_factory=lambda: ([], []))

    def step(self, session: Session) -> bool:
        comparing = session.comparing
        a = comparing.moment(session)
        if a is None or session.document is None:
            return False
        done = len(self._times[0]) + len(self._times[1])
        total = 2 * (WARM_UP + TIMED)
        which = done % 2
        moment = now(session, "B") if which else a
        moment.render(session, session.image.width, session.image.height)
        self._times[which].append(moment.times[-1])
        session.image.invalidate()
        self.progress, self.text = (done + 1) / total, f"{'AB'[which]}: picture {done // 2 + 1} of {total // 2}"
        if done + 1 < total:
            return True
        comparing.measured = (self._times[0][WARM_UP:], self._times[1][WARM_UP:])
        return False

    def close(self) -> None:
        pass
