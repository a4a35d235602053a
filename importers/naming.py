"""File names for what an import writes: safe on every system, unique, and the same each time."""

from __future__ import annotations

import re

_UNSAFE = re.compile(r'[\x00-\x1f<>:"/\\|?*\x7f\s]+')


def safe_name(name: str, fallback: str = "unnamed") -> str:
    """`name` without separators, spaces, control characters and what Windows forbids; at most 60 characters."""
    name = name.encode("utf-8", "replace").decode("utf-8")
    return _UNSAFE.sub("_", name).strip("._ ")[:60].strip("._ ") or fallback


class UniqueNames:
    """Hands out names that differ even where letter case is ignored: the second `a` becomes `a_2`."""

    def __init__(self) -> None:
        self._taken: set[str] = set()

    def take(self, name: str) -> str:
        base, number = name, 1
        while name.casefold() in self._taken:
            number += 1
            name = f"{base}_{number}"
        self._taken.add(name.casefold())
        return name
