"""What of a text field's many small edits is one step of undo: letters typed in one go are. No imgui."""

from __future__ import annotations

#: seconds between two letters after which the next one begins a step of its own
PAUSE = 0.8


class Gestures:
    """Counts edits as the field does (its undo index) and remembers at which counts a step begins."""

    def __init__(self, index: int) -> None:
        self._starts = [index]
        self._top = index
        self._last = -1e9

    def edited(self, before: int, after: int, now: float, *, typing: bool) -> None:
        """The count rose from `before` to `after` by an edit. `typing`: of a letter in the line of the one before."""
        self._starts = [start for start in self._starts if start < before or start == before == self._starts[0]]
        begins = not typing or now - self._last > PAUSE or not self._starts
        if begins and before not in self._starts:
            self._starts.append(before)
        self._top, self._last = after, now if typing else -1e9

    def undone_to(self, index: int) -> int:
        """The count to go back to, after one edit was undone and `index` are left."""
        self._last = -1e9
        return max((start for start in self._starts if start <= index), default=index)

    def redone_to(self, index: int) -> int:
        """The count to go on to, after one edit was done again and there are `index`."""
        self._last = -1e9
        return min((start for start in self._starts if start >= index), default=self._top)
