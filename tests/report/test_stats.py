from __future__ import annotations

import json

import pytest

from engine.core.errors import UsageError
from engine.report.stats import FrameStats, PassStat
from engine.report.summary import measure, summarise
from engine.report.timers import CpuTimer, PassTimes


def test_frame_stats_json() -> None:
    stats = FrameStats([PassStat("sky", 0.123456, "gpu"), PassStat("sky", 1.0, "gpu")], 2.0, {"draws": 3, "bytes": 9})
    data = stats.to_json()
    assert json.loads(json.dumps(data)) == data
    assert list(data["counters"]) == ["bytes", "draws"]
    assert data["passes"][0] == {"name": "sky", "ms": 0.1235, "kind": "gpu"}
    assert stats.ms("sky") == pytest.approx(1.123456)
    assert stats.ms("none") == 0


def test_pass_times_sum_by_name_and_never_mix_kinds() -> None:
    times = PassTimes()
    times.add("a", 1.0)
    times.add("b", 5.0, "gpu")
    times.add("a", 2.0)
    with pytest.raises(ValueError, match="boom"), times.measure("c"):
        raise ValueError("boom")
    assert [p.name for p in times.passes()] == ["a", "b", "c"]
    assert times.total_ms("gpu") == 5.0
    assert 3.0 <= times.total_ms() < 1000.0
    frame = times.frame(9.0, draws=4)
    assert frame.counters == {"draws": 4}
    assert times.passes() == []


def test_cpu_timer() -> None:
    timer = CpuTimer()
    assert timer.ms == 0.0
    with timer:
        assert timer.ms >= 0.0
    assert timer.ms == timer.ms > 0.0


def test_summary_known_answers() -> None:
    s = summarise([5.0, 1.0, 2.0, 3.0, 100.0])
    assert (s.n, s.median, s.iqr, s.minimum, s.maximum) == (5, 3.0, 3.0, 1.0, 100.0)
    with pytest.raises(UsageError):
        summarise([])


def test_measure_runs_warm_up_and_before() -> None:
    calls: list[str] = []
    s = measure(lambda: calls.append("run"), repeats=3, warm_up=2, before=lambda: calls.append("before"))
    assert s.n == 3
    assert calls == ["before", "run"] * 5
