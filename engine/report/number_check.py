"""NumberReport: what the check of a frame's numbers found, pass by pass. Made by engine.render.nonfinite."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

#: the brightest that lighting may leave in a target: sanitise() in shaders/lib/math.glsl cuts there
HIGHEST = 32000.0


@dataclass(frozen=True, slots=True)
class NumberRow:
    """One level of one texture right after `pass_name` wrote it. Counts are pixels (of all layers; a pixel of several
    samples counts once). `negative`, `over` (above HIGHEST) are counted for radiance only; alone they are no mistake.

    `made`: pixels with NaN or an infinity more than the pass before had left there. `first`: x, y (row 0 on top),
    layer of the first such pixel in reading order, and `value`, what it held; None where there is none.
    """

    pass_name: str
    resource: str
    level: int
    width: int
    height: int
    nan: int
    inf: int
    negative: int
    over: int
    made: int
    first: tuple[int, int, int] | None = None
    value: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    @property
    def bad(self) -> bool:
        return self.nan + self.inf > 0

    def describe(self) -> str:
        """`3 NaN in hdr at (12, 40): nan 0.5 0.5 1`."""
        counts = [f"{n:,} {what}" for n, what in ((self.nan, "NaN"), (self.inf, "Inf")) if n]
        text = f"{' and '.join(counts) or 'no NaN or Inf'} in {self.resource}"
        text += f" (mip {self.level})" if self.level else ""
        if self.first is not None:
            x, y, layer = self.first
            text += f" at ({x}, {y})" + (f" of layer {layer}" if layer else "")
            text += ": " + " ".join(f"{v:.6g}" for v in self.value)
        return text


@dataclass(frozen=True, slots=True)
class NumberReport:
    """`rows` in the order of execution; `unchecked`: textures of a kind that cannot be looked into, as `pass: name`."""

    rows: tuple[NumberRow, ...] = ()
    unchecked: tuple[str, ...] = field(default=())

    @property
    def first(self) -> NumberRow | None:
        """Where it began: the first pass that left a NaN or an infinity."""
        return next((row for row in self.rows if row.bad), None)

    @property
    def bad_pixels(self) -> int:
        """The most pixels with NaN or Inf that any pass left in one texture."""
        return max((row.nan + row.inf for row in self.rows), default=0)

    def lines(self) -> list[str]:
        """The report as text: where it began, then every texture that is not clean."""
        first = self.first
        count = len({(row.pass_name, row.resource) for row in self.rows})
        if first is None:
            found = [f"numbers: {count} textures after their passes hold no NaN and no infinity"]
        else:
            found = [f"numbers: pass {first.pass_name!r} made the first: {first.describe()}"]
            found += [f"  {row.pass_name}: {row.describe()}, {row.made:,} of them new" for row in self.rows if row.bad]
        for row in self.rows:
            parts = [f"{n:,} {what}" for n, what in ((row.negative, "below 0"), (row.over, f"above {HIGHEST:g}")) if n]
            if parts:
                found.append(f"  {row.pass_name}: {' and '.join(parts)} in {row.resource}")
        found += [f"  not looked into: {name}" for name in self.unchecked]
        return found

    def to_json(self) -> dict[str, Any]:
        """A JSON value; numbers that JSON has not are strings."""
        rows = []
        for row in self.rows:
            rows.append(
                {
                    "pass": row.pass_name, "texture": row.resource, "mip": row.level, "nan": row.nan, "inf": row.inf,
                    "negative": row.negative, "over": row.over, "made": row.made,
                    "first": None if row.first is None else list(row.first),
                    "value": [v if math.isfinite(v) else str(v) for v in row.value] if row.bad else None,
                }
            )  # fmt: skip
        return {"rows": rows, "unchecked": list(self.unchecked)}
