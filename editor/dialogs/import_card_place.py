"""Where the import card stands, how much of the viewport it takes, and when it folds to one line. No imgui."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

#: em: how wide it is at most; from the viewport's edge; where it begins; the bars above the picture; worth showing
WIDTH, EDGE, TOP, BARS, LEAST = 23.0, 0.8, 13.5, 5.0, 7.0
#: the part of the picture that it covers at most, and em that one line of it takes
SHARE, LINE = 1.0 / 3.0, 2.4
#: draws in which what the window does by itself, as framing what was opened, is nobody's deed
YOUNG = 5


@dataclass(frozen=True, slots=True)
class Place:
    """em; `height`: at most, the rest is scrolled to. `whole`: there is room for more than a line; `line`: where that
    begins, when it is folded."""

    top: float
    line: float
    width: float
    height: float
    whole: bool


def placed(width: float, height: float) -> Place:
    """Where the card goes in a viewport of that size (em), bars and all: below the axes where there is room, else
    further up; over no more than SHARE of the picture, where that is more than a line."""
    wide = max(min(WIDTH, width - 2.0 * EDGE), 8.0)
    share = SHARE * width * max(height - BARS, 0.0) / wide
    top = max(min(TOP, height - EDGE - share), BARS)
    room = min(height - top - EDGE, share)
    line = max(min(TOP, height - 2.0 * EDGE - LINE), BARS)
    return Place(top, line, wide, max(room, LINE), room >= LEAST)


class Folding:
    """`whole`: None where it is as there is room, else as the user or what he did wants it.

    An import that is new is shown whole. The first thing that the user does then (`deed`: what he has selected, where he
    looks from, how many edits there are) folds it, unless he opened it himself: then he folds it, too."""

    def __init__(self) -> None:
        self.whole: bool | None = None
        self.by_hand = False
        self._known: dict[int, Any] = {}
        self._deed: Hashable = None
        self._age = 0

    def choose(self, whole: bool) -> None:
        """The user says how."""
        self.whole, self.by_hand = whole, whole

    def follow(self, news: Any, deed: Hashable, *, busy: bool) -> None:
        """Once a draw. `news`: of the import that is shown, one object for each; `busy`: another one is being made."""
        if id(news) not in self._known:
            if len(self._known) > 32:
                self._known.clear()
            self._known[id(news)] = news  # kept, so that no other one gets its id
            if not self.by_hand:
                self.whole = None
            self._age = 0
        self._age += 1
        if busy or self._age <= YOUNG:
            self._deed = deed
        elif deed != self._deed:
            self._deed = deed
            if not self.by_hand:
                self.whole = False
