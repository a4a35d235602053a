"""The call stream that the null device records."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

LIMIT = 100_000


@dataclass(frozen=True, slots=True)
class Call:
    """One command: `name` as in the protocols, what it was given, and the pass it was given to."""

    name: str
    values: dict[str, Any]
    inside: str = ""

    def __getattr__(self, name: str) -> Any:
        try:
            return self.values[name]
        except KeyError:
            raise AttributeError(f"{self.name} has no {name!r}, only {', '.join(self.values)}") from None


class CallStream:
    """The last LIMIT calls; `recording` off costs next to nothing."""

    def __init__(self, recording: bool = True, limit: int = LIMIT) -> None:
        self.recording = recording
        self._calls: deque[Call] = deque(maxlen=limit)

    def add(self, name: str, inside: str = "", **values: Any) -> None:
        if self.recording:
            self._calls.append(Call(name, values, inside))

    def named(self, *names: str) -> list[Call]:
        """The calls of these names, in order."""
        return [call for call in self._calls if call.name in names]

    def names(self) -> list[str]:
        return [call.name for call in self._calls]

    def clear(self) -> None:
        self._calls.clear()

    def __iter__(self) -> Iterator[Call]:
        return iter(self._calls)

    def __len__(self) -> int:
        return len(self._calls)
