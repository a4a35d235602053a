"""Random edits of effects, shaders and materials: nothing crashes, nothing leaks, the last good version stays.

`python -m tests.fuzz.effects` makes 10,000."""

from __future__ import annotations

from pathlib import Path

from engine.gpu.types import Device
from tests.fuzz.effects import fuzz

EDITS = 300


def test_random_edits(gl_device: Device, tmp_path: Path) -> None:
    tally = fuzz(gl_device, tmp_path, EDITS, 20)
    assert tally.failures == []
    refused = sum(count for (_, outcome), count in tally.changes.items() if outcome.startswith("refused"))
    assert refused > EDITS // 4, "too few of the edits were mistakes"
    assert tally.outcome("taken") > EDITS // 20, "too few of the edits were good"
    assert tally.compared >= refused
