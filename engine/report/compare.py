"""Two reports: what got worse, better, appeared or went, point by point."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

#: errors are deterministic up to the driver: 2 % is a change. Times need a quarter and more than both quartile ranges.
ERROR_FACTOR, TIME_FACTOR = 1.02, 1.25
#: differences of rounding errors are no change
TINY = 1e-12


@dataclass(frozen=True, slots=True)
class Change:
    """`kind`: a metric, "ms", or what was true and is no more. Values before and after; `worse` says which way."""

    experiment: str
    point: str
    kind: str
    before: float | None
    after: float | None
    worse: bool
    numbers: bool = True

    def line(self) -> str:
        word = "worse" if self.worse else "better"
        place = f"{self.experiment} [{self.point}]" if self.point else self.experiment
        if not self.numbers:
            return f"{word}: {place}: {self.kind}"
        ratio = f" (×{self.after / self.before:.3g})" if self.before and self.after else ""
        return f"{word}: {place}: {self.kind} {_text(self.before)} -> {_text(self.after)}{ratio}"


@dataclass(slots=True)
class Comparison:
    """All changes; `notes` say what could not be compared."""

    changes: list[Change] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @property
    def regressions(self) -> list[Change]:
        return [c for c in self.changes if c.worse]

    def lines(self) -> list[str]:
        """For people: regressions first."""
        ordered = self.regressions + [c for c in self.changes if not c.worse]
        better = len(ordered) - len(self.regressions)
        return [c.line() for c in ordered] + self.notes + [f"{len(self.regressions)} worse, {better} better"]

    def to_json(self) -> dict[str, Any]:
        rows = [
            {"experiment": c.experiment, "point": c.point, "kind": c.kind, "before": c.before, "after": c.after,
             "worse": c.worse}
            for c in self.changes
        ]  # fmt: skip
        return {"changes": rows, "notes": self.notes, "worse": len(self.regressions)}


def compare(a: dict[str, Any], b: dict[str, Any]) -> Comparison:
    """Compare the JSON twins `a` (before) and `b` (after). Times only where device and driver are the same."""
    result = Comparison()
    same_device = all(a.get(k) == b.get(k) for k in ("device", "driver", "machine"))
    if not same_device:
        result.notes.append("note: other device, driver or processor: times are not compared")
    for key in ("quick", "seed"):
        if a.get(key) != b.get(key):
            result.notes.append(f"note: {key} was {a.get(key)} and is {b.get(key)}: not the same was measured")
    before = {e["name"]: e for e in a["experiments"]}
    after = {e["name"]: e for e in b["experiments"]}
    for name in before.keys() - after.keys():
        result.notes.append(f"note: {name} is only in the first report")
    for name in sorted(after.keys() - before.keys()):
        result.notes.append(f"note: {name} is only in the second report")
    for name in sorted(before.keys() & after.keys()):
        _experiment(result, name, before[name], after[name], times=same_device)
    return result


def _experiment(result: Comparison, name: str, a: dict[str, Any], b: dict[str, Any], *, times: bool) -> None:
    if a.get("default_on_front") is True and b.get("default_on_front") is False:
        result.changes.append(Change(name, "", "default left its front", None, None, True, numbers=False))
    if a.get("default") != b.get("default"):
        result.notes.append(f"note: {name}: the default was {a.get('default')} and is {b.get('default')}")
    _orders(result, name, a, b)
    _extremes(result, name, a, b)
    points = {_key(p): p for p in a["points"]}
    for point in b["points"]:
        key = _key(point)
        old = points.pop(key, None)
        if old is None:
            result.notes.append(f"note: {name} [{key}] is new")
            continue
        for metric, now in (point.get("error") or {}).items():
            _error(result, name, key, metric, (old.get("error") or {}).get(metric), now)
        if times:
            _time(result, name, key, old.get("ms"), point.get("ms"))
    result.notes += [f"note: {name} [{key}] is gone" for key in points]


def _orders(result: Comparison, name: str, a: dict[str, Any], b: dict[str, Any]) -> None:
    """Orders of convergence that were as expected and are no more, or the reverse."""
    before = {(o["curve"], o["over"]): o for o in a.get("orders") or ()}
    for order in b.get("orders") or ():
        old = before.get((order["curve"], order["over"]))
        if old is not None and old["met"] != order["met"]:
            kind = f"order over {order['over']} (expected {order['expected']:g})"
            change = Change(name, order["curve"], kind, old["observed"], order["observed"], not order["met"])
            result.changes.append(change)


def _extremes(result: Comparison, name: str, a: dict[str, Any], b: dict[str, Any]) -> None:
    """Extreme cases that were held and fail now, or the reverse."""
    before = {e["what"]: e for e in a.get("extremes") or ()}
    for extreme in b.get("extremes") or ():
        old = before.get(extreme["what"])
        if old is not None and old["ok"] != extreme["ok"]:
            kind = f"extreme case {'holds' if extreme['ok'] else 'fails'} ({extreme['found']})"
            change = Change(name, extreme["what"], kind, None, None, not extreme["ok"], numbers=False)
            result.changes.append(change)


def _error(result: Comparison, name: str, key: str, metric: str, old: float | None, now: float | None) -> None:
    before, after = (math.inf if v is None else float(v) for v in (old, now))
    if before == after or max(before, after) < TINY:
        return
    if after > before * ERROR_FACTOR or before > after * ERROR_FACTOR:
        result.changes.append(Change(name, key, metric, old, now, after > before))


def _time(result: Comparison, name: str, key: str, old: Any, now: Any) -> None:
    if not old or not now or old.get("kind") != now.get("kind"):
        return
    before, after = float(old["median"] or 0.0), float(now["median"] or 0.0)
    noise = float(old["iqr"] or 0.0) + float(now["iqr"] or 0.0)
    ratio = after / before if before > 0.0 else math.inf
    if abs(after - before) > noise and (ratio > TIME_FACTOR or ratio < 1.0 / TIME_FACTOR):
        result.changes.append(Change(name, key, "ms", before, after, after > before))


def _key(point: dict[str, Any]) -> str:
    return ", ".join(f"{k} {v}" for k, v in sorted((point.get("knobs") or {}).items()))


def _text(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"
