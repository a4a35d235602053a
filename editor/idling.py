"""How long the window may sleep after a frame: until something happens, where nothing is going on. No imgui.

a frame ends ──► pause(...) ──► 0: the next one at once       something moves, or is made step by step
                                seconds: a timer runs         an autosave, a notice that goes, a caret, a bar
                                NEVER: input, or waking.wake  a thread is done, a file changed, Ctrl+C
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from editor import tabs
from editor.window_state import Sight

if TYPE_CHECKING:
    from editor.session import Session

#: seconds at most between two pictures of what plays and is drawn by the processor
LONGEST_REST = 0.25
#: seconds; nothing is waited for
NEVER = 1e6
#: pictures a second of what plays behind another window, and of a bar that grows
BEHIND_FPS, BAR_FPS = 10.0, 15.0
#: seconds between two pictures of a caret that blinks (0.8 s on, 0.4 s off)
CARET = 0.4
#: seconds that the window stays awake after an event: buttons light up, tooltips come
AWAKE = 0.7
#: seconds by which a timer may run off too soon
EARLY = 0.004
#: frames at once after a thread's word, for what takes a frame to be laid out
SETTLE_FRAMES = 3
#: seconds after which it looks once more, for what is looked at now and then only
LOOK_AGAIN: tuple[float, ...] = (0.6, 2.2)


class Idling:
    """Of one window. Times are those of one steady clock, seconds."""

    def __init__(self) -> None:
        self.sight: Sight = "front"
        self._awake_until = 0.0
        self._frames = 0
        self._again: list[float] = []
        self._expected = 0.0
        self._updates = 0

    def began(self, now: float, *, woken: bool, waited: bool = True) -> None:
        """A frame begins; `woken`: a thread asked for one since the last; `waited`: the window slept before it."""
        if woken:
            self.look_again(now)
            self._frames = SETTLE_FRAMES
        elif waited and now < self._expected - EARLY:  # earlier than the window meant to wake: something happened to it
            self._awake_until = now + AWAKE
        self._frames = max(self._frames - 1, 0)
        self._again = [due for due in self._again if due > now]

    def look_again(self, now: float) -> None:
        """Let frames come a little later too: what they look at now and then may have changed."""
        self._again = [now + seconds for seconds in LOOK_AGAIN]

    def plays(self, session: Session) -> bool:
        """Whether what plays is to be seen: nobody looks at a window that is away."""
        if self.sight == "away":
            return False
        return self.sight == "front" or session.preferences.in_background != "stop"

    def pause(self, session: Session, now: float, *, moving: bool, caret: bool, asked: float = NEVER) -> float:
        """Seconds until the next frame, 0 for at once. `moving`: the user does something; `asked`: a panel wants a
        frame then."""
        if moving or self._frames or (now < self._awake_until and self.sight != "away"):
            pause = 0.0
        else:
            pause = min(asked, self._steps(session), self._playing(session), *(due - now for due in self._again), NEVER)
            pause = min(pause, CARET if caret and self.sight == "front" else NEVER, _timers(session))
        pause = max(pause, 0.0)
        self._expected, self._updates = now + pause, session.image.updates
        return pause

    def _steps(self, session: Session) -> float:
        """Of what frames do a part of each, and of what a thread does, whose bar is drawn."""
        image, pause = session.image, NEVER
        if session.work is not None or session.look_card.waiting or session.comparing.held:
            return 0.0
        if image.updates != self._updates:  # else nothing of it is shown, and no frame brings it on
            if image.compiling is not None:
                return 0.0
            if image.rehearsing is not None:
                pause = image.rests_for
        waits = session.job is not None or session.importing is not None or session.preview.busy
        return min(pause, 1.0 / BAR_FPS) if waits or session.comparing.waiting else pause

    def _playing(self, session: Session) -> float:
        """Of the clock, the turntable, an exposure that settles."""
        image = session.image
        settles = image.settling and image.updates != self._updates
        if not (session.playback.playing or session.tools.turning or settles):
            return NEVER
        if not self.plays(session):
            return NEVER
        slow = self.sight == "behind" and session.preferences.in_background == "slow"
        # a processor that draws pictures itself rests as long as it worked: something is left for the window
        rest = 1e-3 * image.frame.stats.total_ms if session.software and image.frame is not None else 0.0
        return max(1.0 / BEHIND_FPS if slow else 0.0, min(rest, LONGEST_REST))


def _timers(session: Session) -> float:
    """Of autosaves, of all documents."""
    dues = [journal.due for journal, _ in tabs.journals(session)]
    return min((due for due in dues if due is not None), default=NEVER)
