"""Search in a text: where something occurs, and the text with all of it replaced. No imgui."""

from __future__ import annotations

import re
from dataclasses import dataclass

#: more occurrences are not counted
MOST = 9999


@dataclass(slots=True)
class Search:
    """What is looked for, and what is to stand in its place."""

    needle: str = ""
    new: str = ""
    case: bool = False
    word: bool = False

    def places(self, text: str) -> list[tuple[int, int, int]]:
        """(line, first column, end column) of each occurrence, from 0, none over the end of a line."""
        if not self.needle:
            return []
        pattern, found = self._pattern(), []
        for row, line in enumerate(text.split("\n")):
            for match in pattern.finditer(line):
                found.append((row, match.start(), match.end()))
                if len(found) >= MOST:
                    return found
        return found

    def replaced(self, text: str) -> str:
        """`text` with every occurrence replaced."""
        if not self.needle:
            return text
        pattern = self._pattern()
        return "\n".join(pattern.sub(lambda _: self.new, line) for line in text.split("\n"))

    def _pattern(self) -> re.Pattern[str]:
        body = re.escape(self.needle)
        if self.word:
            body = rf"(?<!\w){body}(?!\w)"
        return re.compile(body, 0 if self.case else re.IGNORECASE)


def after(places: list[tuple[int, int, int]], line: int, column: int, step: int) -> int:
    """The index of the first place from (line, column) on, or of the last before it (`step` -1), round and round."""
    if step > 0:
        return next((i for i, place in enumerate(places) if place[:2] >= (line, column)), 0)
    return next((i for i in reversed(range(len(places))) if places[i][:2] < (line, column)), len(places) - 1)
