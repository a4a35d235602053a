"""Where the import card stands, how much of the viewport it takes, and when it folds to one line. No imgui."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

#: em: how wide it is at most and at least; from the picture's edge; below the axes; worth showing unasked
WIDTH, NARROW, EDGE, TOP, LEAST = 23.0, 8.0, 0.8, 8.0, 7.0
#: the part of the picture that it covers at most, and em that one line of it takes
SHARE, LINE = 1.0 / 3.0, 2.4
#: draws in which what the window does by itself, as framing what was opened, is nobody's deed
YOUNG = 5


@dataclass(frozen=True, slots=True)
class Place:
    """em, from the top right of the picture; `height`: at most, the rest is scrolled to. `whole`: there is room for
    more than a line; `line`: where that begins, when it is folded; `fits`: a line does."""

    top: float
    line: float
    width: float
    height: float
    whole: bool
    fits: bool


def placed(width: float, height: float, wanted: float = 1e9) -> Place:
    """Where the card, `wanted` high, goes in a picture of that size (em): below the axes where there is room, else
    further up; over no more than SHARE of the picture, where that is more than a line."""
    room = max(height - 2.0 * EDGE, LINE)
    share = SHARE * width * height
    wide = min(WIDTH, max(width - 2.0 * EDGE, NARROW))
    narrow = min(max(share / room, NARROW), wide)
    whole = share / wide >= LEAST and room >= LEAST
    wide = wide if whole else narrow
    high = max(min(room, share / wide), LINE)
    top, line = (max(min(TOP, height - EDGE - h), EDGE) for h in (min(high, wanted), LINE))
    return Place(top, line, wide, high, whole, height >= LINE + EDGE)


class Folding:
    """`whole`: None where it is as there is room, else as the user or what he did wants it.

    An import that is new is shown whole. The first thing that the user does then (`deed`: what he has selected, where
    he looks from, how many edits there are) folds it, unless he opened it himself: then he folds it, too."""

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
