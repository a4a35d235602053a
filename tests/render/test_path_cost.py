"""The cost model behind `--path auto`: what it fits, keeps and chooses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.gpu import open_device
from engine.render.paths import cost
from engine.render.paths.cost import BUILT_IN, CostModel, PathCost, fit
from engine.render.settings import RenderSettings


def test_fit_finds_the_model_that_made_the_points() -> None:
    true = PathCost(1.5, 40.0, 3.0, 700.0)
    points = [("deferred", n, p, true.ms(n, p)) for n in (8, 256, 2048) for p in (20_000, 230_000)]
    got = fit(points, "a test").costs
    np.testing.assert_allclose(
        [got["deferred"].fixed, got["deferred"].pixel, got["deferred"].light, got["deferred"].both],
        [1.5, 40.0, 3.0, 700.0], rtol=1e-6,
    )  # fmt: skip
    assert got["forward"] == BUILT_IN["forward"]  # too few points


def test_no_cost_is_negative() -> None:
    rng = np.random.default_rng(3)
    points = [("forward-plus", n, p, float(rng.uniform(1, 9))) for n in (1, 64, 900) for p in (1000, 90_000)]
    fitted = fit(points, "noise").costs["forward-plus"]
    assert min(fitted.fixed, fitted.pixel, fitted.light, fitted.both) >= 0.0


def test_cheapest_by_lights_and_samples() -> None:
    model = CostModel()
    assert model.cheapest(1, 640 * 360, 1)[0] in ("forward", "deferred")
    assert model.cheapest(1024, 640 * 360, 1)[0] == "tiled-deferred"
    path, why = model.cheapest(1024, 640 * 360, 4)
    assert path == "forward-plus"
    assert "built-in" in why
    assert "4 samples" in why


def test_kept_per_device(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path))
    caps = open_device("null").caps
    assert cost.load(caps) == CostModel()
    model = fit([("forward", n, p, 1.0 + n * p * 1e-6) for n in (1, 9) for p in (100, 9000)], "fit of 4")
    path = cost.save(model, caps)
    assert cost.load(caps) == model
    for bad in ("", "{}", "[1]", path.read_text().replace('"both"', '"odd"'), path.read_text().replace("0.0", "-1.0")):
        path.write_text(bad)
        assert cost.load(caps).source == "built-in model"


def test_settings_know_every_path() -> None:
    assert RenderSettings().path == "auto"
    for path in cost.PATHS:
        assert RenderSettings(path=path).path == path
