"""What every bench uses: Context.measure gives a Row; `table` prints rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from engine.report.summary import Summary, measure


@dataclass(frozen=True, slots=True)
class Row:
    """One measured stage: `case` says on what (10k nodes), `stage` what was done; times in ms."""

    case: str
    stage: str
    time: Summary
    bench: str = ""
    note: str = ""

    def of(self, bench: str) -> Row:
        return replace(self, bench=bench)

    def to_json(self) -> dict[str, Any]:
        return {
            "bench": self.bench, "case": self.case, "stage": self.stage, "ms": self.time.to_json(), "note": self.note,
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Context:
    """Passed to every bench's `run`."""

    quick: bool = False

    def measure(
        self, case: str, stage: str, run: Callable[[], object], *, before: Callable[[], object] | None = None,
        note: str = "",
    ) -> Row:  # fmt: skip
        """Time `run` (ms per call), with `before` called untimed ahead of each call."""
        repeats, warm_up = (7, 2) if self.quick else (41, 5)
        return Row(case, stage, measure(run, repeats=repeats, warm_up=warm_up, before=before), note=note)


def table(rows: Sequence[Row]) -> str:
    """Return the rows as a markdown table."""
    lines = ["| bench | case | stage | median ms | IQR | min | n | note |", "|---|---|---|---:|---:|---:|---:|---|"]
    for r in rows:
        t = r.time
        lines.append(
            f"| {r.bench} | {r.case} | {r.stage} | {t.median:.3f} | {t.iqr:.3f} | {t.minimum:.3f} | {t.n} | {r.note} |"
        )
    return "\n".join(lines)
