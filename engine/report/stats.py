"""FrameStats: what one frame cost, pass by pass, and what it counted."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

#: How a time was taken: by the GPU's timestamps, by the CPU's clock, or by wall clock round a finish.
KINDS = ("gpu", "cpu", "wall")


@dataclass(frozen=True, slots=True)
class PassStat:
    """One pass: `ms` of the kind `kind` (KINDS)."""

    name: str
    ms: float
    kind: str = "cpu"


@dataclass(slots=True)
class FrameStats:
    """One frame: its passes in order, `total_ms` (wall), and counters such as draws, instances, triangles, bytes."""

    passes: list[PassStat] = field(default_factory=list)
    total_ms: float = 0.0
    counters: dict[str, int | float] = field(default_factory=dict)

    def ms(self, name: str) -> float:
        """Milliseconds of all passes called `name`; 0 if there is none."""
        return sum(p.ms for p in self.passes if p.name == name)

    def to_json(self) -> dict[str, Any]:
        """A JSON value: counters sorted, passes in order, times rounded to 0.1 microsecond."""
        return {
            "total_ms": round(self.total_ms, 4),
            "passes": [{"name": p.name, "ms": round(p.ms, 4), "kind": p.kind} for p in self.passes],
            "counters": dict(sorted(self.counters.items())),
        }
