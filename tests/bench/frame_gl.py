"""A whole frame with its picture read back, engine against the hand-written floor, interleaved in one run."""

from __future__ import annotations

import time

import numpy as np

from engine.report.summary import summarise
from tests.bench.harness import Context, Row
from tests.bench.stages import EngineStage, FloorStage


def run(ctx: Context) -> list[Row]:
    rows: list[Row] = []
    for count in (100, 1_000, 10_000) if ctx.quick else (100, 1_000, 10_000, 100_000):
        engine, floor = EngineStage("gl", count), FloorStage(count)
        for move in (True, False):
            rows += compare(engine, floor, count, move, 7 if ctx.quick else 15 if count < 100_000 else 7)
        engine.close()
        floor.close()
    return rows


def compare(engine: EngineStage, floor: FloorStage, count: int, move: bool, repeats: int) -> list[Row]:
    """Alternate the two, so that both see the same state of the machine; the ratio is the median of the pairs'."""
    wall: dict[str, list[float]] = {"engine": [], "floor": []}
    cpu: dict[str, list[float]] = {"engine": [], "floor": []}
    for i in range(repeats + 3):
        for name, stage in (("engine", engine), ("floor", floor)):
            start, start_cpu = time.perf_counter(), time.process_time()
            stage.frame(move=move)
            if i >= 3:
                wall[name].append((time.perf_counter() - start) * 1e3)
                cpu[name].append((time.process_time() - start_cpu) * 1e3)
    ratio = float(np.median(np.array(wall["engine"]) / np.array(wall["floor"])))
    case = f"{count} cubes"
    kind = "moving" if move else "static"
    calls = int(engine.counters["api_calls"])
    return [
        Row(
            case, f"{kind}: engine", summarise(wall["engine"]), note=f"{calls} API calls, cpu {_median(cpu['engine'])}"
        ),
        Row(
            case,
            f"{kind}: floor",
            summarise(wall["floor"]),
            note=f"cpu {_median(cpu['floor'])}; engine/floor {ratio:.2f}",
        ),
    ]


def _median(values: list[float]) -> str:
    return f"{float(np.median(values)):.1f} ms"
