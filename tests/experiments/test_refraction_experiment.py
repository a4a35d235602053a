"""The experiment on slabs of glass: its truth, and that bending comes near it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from engine.experiments import refraction
from engine.experiments.harness import registry, sweep
from engine.experiments.harness.context import Context
from engine.experiments.harness.panes import Slab


def test_a_slab_shifts_and_does_not_turn() -> None:
    """At an angle a slab of index n shifts a ray by t sin(a) (1 - cos(a) / sqrt(n^2 - sin(a)^2)) across itself (Born
    and Wolf 1999, sect. 4.7); straight on, or of index 1, by nothing."""
    a = np.pi / 4
    d = np.array([[np.sin(a), 0.0, -np.cos(a)], [0.0, 0.0, -1.0]])
    start = np.array([[-1.0, 0.2, 1.0], [0.3, 0.1, 1.0]])
    straight = (start + d * ((start[:, 2] + 2.5) / -d[:, 2])[:, None])[:, :2]
    assert np.allclose(Slab(0.5, 2.0, 1.0).exact(start, d), straight)
    shown = Slab(0.5, 2.0).exact(start, d)
    shift = 0.5 * np.sin(a) * (1.0 - np.cos(a) / np.sqrt(1.5**2 - np.sin(a) ** 2))
    assert np.allclose(straight - shown, [(shift / np.cos(a), 0.0), (0.0, 0.0)])


@pytest.mark.gl
def test_bent_light_comes_near_snell(quick: Callable[[], Context], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep, "BUDGET_S", (0.05, 0.05))
    monkeypatch.setattr(refraction, "SLABS", {name: refraction.SLABS[name] for name in ("thin, near", "thick, near")})
    result = sweep.run_experiment("refraction", registry.get("refraction"), quick())
    assert [o for o in result.omitted if not o.why.startswith("quick mode")] == []
    found = {(p.knobs["slab"], p.knobs["method"]): p.error["rms"] for p in result.points}
    for slab in refraction.SLABS:
        assert found[slab, "tested"] == found[slab, "bent"] < 0.2 * found[slab, "straight"]
        assert found[slab, "bent"] < 1.0, "per cent of the picture's height"
