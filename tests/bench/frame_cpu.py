"""The CPU's part of a frame, on the null device (no rasteriser): N cubes, each its own node, 8 materials."""

from __future__ import annotations

from collections.abc import Callable

from tests.bench.harness import Context, Row
from tests.bench.stages import EngineStage

GOALS = {10_000: "goal 3 ms", 100_000: "goal 25 ms"}


def run(ctx: Context) -> list[Row]:
    rows: list[Row] = []
    for count in (100, 1_000, 10_000) if ctx.quick else (100, 1_000, 10_000, 100_000):
        stage = EngineStage("null", count)
        for move in (True, False):
            row = ctx.measure(f"{count} cubes", "moving" if move else "static", _frame(stage, move))
            calls = int(stage.counters["api_calls"])
            goal = GOALS.get(count, "") if move else ""
            note = f"{calls} API calls, {int(stage.counters['draws'])} draws, {goal}".rstrip(", ")
            rows.append(Row(row.case, row.stage, row.time, note=note))
        stage.close()
        shadowed = EngineStage("null", count, shadows=True)
        rows.append(ctx.measure(f"{count} cubes", "moving, with sun shadows", _frame(shadowed, True)))
        shadowed.close()
    return rows


def _frame(stage: EngineStage, move: bool) -> Callable[[], object]:
    return lambda: stage.frame(move=move, read=False)
