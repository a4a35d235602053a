"""What a result says about each setting against the default: take it, leave it, or what it would cost and give."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from engine.report.front import clearly_less
from engine.report.interval import Interval, ratio_interval
from engine.report.records import Point, Result

#: take: no worse in anything, better in one. cheaper, better: a trade. dominated: the default is surely no worse.
#: same: no difference that could be seen
KINDS = ("take", "cheaper", "better", "dominated", "same")


@dataclass(frozen=True, slots=True)
class Advice:
    """One setting against the default. `ms_saved`, `error_removed`: negative where it costs; `ratio`: its time over
    the default's, with the 95 % interval. `per_ms`: error gained or lost per millisecond of the trade."""

    kind: str
    knobs: dict[str, Any]
    ms_saved: float
    error_removed: float
    ratio: Interval
    per_ms: float = 0.0
    sure: bool = False
    text: str = field(default="")

    def rank(self) -> tuple[int, float]:
        """Sorts: what to take first; then trades, those that give most for a millisecond first."""
        return KINDS.index(self.kind), -self.per_ms if self.kind == "better" else self.per_ms


def advise(result: Result) -> list[Advice]:
    """Advice on every timed point but the default: what to take first, then trades by error per ms, then the rest."""
    timed = [p for p in result.points if p.ms is not None and p.status == "ok" and p.samples]
    found: list[Advice] = []
    for default in timed:
        if not all(default.knobs.get(k) == v for k, v in result.default.items()):
            continue
        others = {k: v for k, v in default.knobs.items() if k not in result.default and k == "scene"}
        same = [p for p in timed if p is not default and all(p.knobs.get(k) == v for k, v in others.items())]
        found += [against(p, default, result.metric, result.unit) for p in same]
    return sorted(found, key=Advice.rank)


def dominated(result: Result) -> list[dict[str, Any]]:
    """Knobs of the timed points that are not on the front."""
    return [dict(p.knobs) for p in result.points if p.ms is not None and not p.front]


def against(point: Point, default: Point, metric: str, unit: str) -> Advice:
    """`point` compared with `default`; both timed."""
    assert point.ms is not None, "only timed points are compared"
    assert default.ms is not None, "only timed points are compared"
    ratio = ratio_interval(point.samples, default.samples)
    mine, theirs = default.error[metric], point.error[metric]
    saved, removed = default.ms.median - point.ms.median, mine - theirs
    faster, slower = ratio.high < 1.0, ratio.low > 1.0
    less, more = clearly_less(theirs, mine), clearly_less(mine, theirs)
    per_ms = abs(removed / saved) if (faster or slower) and saved else 0.0
    if (faster and not more) or (less and not slower):
        kind = "take"
    elif faster:
        kind = "cheaper"
    elif less:
        kind = "better"
    elif slower or more:
        kind = "dominated"
    else:
        kind = "same"
    return Advice(
        kind, dict(point.knobs), saved, removed, ratio, per_ms, faster or slower,
        _text(kind, saved, removed, ratio, unit),
    )  # fmt: skip


def _text(kind: str, saved: float, removed: float, ratio: Interval, unit: str) -> str:
    time = f"{abs(saved):.3g} ms {'saved' if saved > 0 else 'more'}" if ratio.high < 1.0 or ratio.low > 1.0 else (
        "time below noise"
    )  # fmt: skip
    error = f"{abs(removed):.2g} {unit} {'less' if removed > 0 else 'more'} error" if removed else "no other error"
    words = {
        "take": "worth taking", "cheaper": "a trade for speed", "better": "a trade for quality",
        "dominated": "not worth it", "same": "makes no difference here",
    }[kind]  # fmt: skip
    return f"{words}: {time}, {error}"


def totals(advice: Sequence[Advice]) -> tuple[float, float]:
    """(ms saved, error removed) if everything worth taking were taken; effects need not add up, so an upper guess."""
    take = [a for a in advice if a.kind == "take"]
    return sum(max(a.ms_saved, 0.0) for a in take), sum(max(a.error_removed, 0.0) for a in take)
