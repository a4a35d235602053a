"""Three values become one. The user's change wins over the source's; where both changed, that is said."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

#: no value at all: a key that one side does not have
NOTHING: Any = object()


@dataclass(slots=True)
class Report:
    """What a merge decided, a line each. `kept`: changes of the user's that went through; `taken`: what the source
    changed; `conflicts`: both did, and the user's stands; `orphans`: changes whose part is no longer in the source."""

    kept: list[str] = field(default_factory=list)
    taken: list[str] = field(default_factory=list)
    conflicts: list[str] = field(default_factory=list)
    orphans: list[str] = field(default_factory=list)

    @property
    def summary(self) -> str:
        """One line."""
        parts = [
            f"{len(found)} {what if len(found) != 1 else one}"
            for found, what, one in (
                (self.taken, "changes taken over", "change taken over"),
                (self.kept, "of your changes kept", "of your changes kept"),
                (self.conflicts, "changed on both sides, yours kept", "changed on both sides, yours kept"),
                (self.orphans, "orphans", "orphan"),
            )
            if found
        ]
        return "; ".join(parts) or "nothing differs"


def merge_value(base: Any, theirs: Any, ours: Any, what: str, report: Report) -> Any:
    """`base` as last imported, `theirs` as imported now, `ours` as the user has it."""
    if same(ours, base):
        if not same(theirs, base):
            report.taken.append(what)
        return theirs
    if same(theirs, base):
        report.kept.append(what)
    elif not same(theirs, ours):
        report.conflicts.append(f"{what}: yours is {_short(ours)}, the source now says {_short(theirs)}")
    return ours


def merge_mapping(
    base: Mapping[str, Any], theirs: Mapping[str, Any], ours: Mapping[str, Any], what: str, report: Report
) -> dict[str, Any]:
    """Key by key; the order is that of `theirs`, then what only the user has."""
    merged = {}
    for key in dict.fromkeys([*theirs, *ours, *base]):
        values = [side.get(key, NOTHING) for side in (base, theirs, ours)]
        found = merge_value(values[0], values[1], values[2], f"{what}{key}", report)
        if found is not NOTHING:
            merged[key] = found
    return merged


def same(one: Any, other: Any) -> bool:
    if one is NOTHING or other is NOTHING:
        return one is other
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


def _short(value: Any) -> str:
    if value is NOTHING:
        return "nothing"
    if isinstance(value, (list, tuple)) and all(isinstance(v, (int, float)) for v in value):
        return "(" + ", ".join(f"{v:.4g}" for v in value) + ")"
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 60 else text[:57] + "…"
