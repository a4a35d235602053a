"""Frame quality experiments, at thumbnail size."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from engine.experiments import antialias, bloom, dof, exposure, presets
from engine.experiments.harness import registry, sweep
from engine.experiments.harness.context import Context
from engine.report.records import Result

pytestmark = pytest.mark.gl


@pytest.fixture(autouse=True)
def _few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep, "REPEATS", (5, 5))
    monkeypatch.setattr(sweep, "BUDGET_S", (0.2, 0.2))
    for module, name in ((bloom, "size"), (antialias, "size"), (presets, "picture_size"), (exposure, "picture_size")):
        monkeypatch.setattr(module, name, lambda ctx: (96, 64))
    monkeypatch.setattr(dof, "lens_places", lambda ctx: 32)


def run(name: str, ctx: Context) -> Result:
    result = sweep.run_experiment(name, registry.get(name), ctx)
    why = [o for o in result.omitted if not o.why.startswith("quick mode") and "the device takes" not in o.why]
    assert why == []
    assert all(extreme.ok for extreme in result.extremes), result.extremes
    return result


@pytest.mark.usefixtures("gl_device")
def test_bloom_is_the_halos_and_keeps_the_light(quick: Callable[[], Context]) -> None:
    pytest.importorskip("flip_evaluator")
    errors = {p.curve: p.error for p in run("bloom", quick()).points if p.knobs["radius"] == 0.1}
    assert errors["bloom"]["misplaced"] < 0.1
    assert abs(errors["bloom"]["lost"]) < 1e-3 < errors["calm"]["lost"]
    assert errors["off"]["misplaced"] == 1.0


@pytest.mark.usefixtures("gl_device")
def test_what_is_metered_is_the_mean(quick: Callable[[], Context]) -> None:
    pytest.importorskip("flip_evaluator")
    points = run("exposure", quick()).points
    assert len(points) == 4
    for point in points:
        metered = point.knobs["form"] == "metered"
        assert (point.error["stops"] < 1.0 / 16.0) == metered, point.knobs
        assert (point.error["flip"] < 0.1) == metered, "and shown so"


@pytest.mark.usefixtures("gl_device")
def test_every_way_to_smooth_edges_helps(quick: Callable[[], Context]) -> None:
    pytest.importorskip("flip_evaluator")
    result = run("antialias", quick())
    points = result.points
    found = {(p.curve, p.knobs["samples"]): p.error["rmse_8_bit"] for p in points}
    assert found["fxaa", 1] < 0.9 * found["none", 1]
    assert found["smaa", 1] < 0.9 * found["none", 1]
    assert found["taa", 16] < found["none", 1]
    assert found["msaa", 4] < found["fxaa", 1]
    assert all(p.error["rmse_8_bit"] == max(p.error["at_rest"], p.error["turning"]) for p in points)
    taa = next(p.error for p in points if p.curve == "taa")
    assert taa["at_rest"] < taa["turning"], "what is judged is the worse"
    moving = {row[0]: [float(cell.split()[0]) for cell in row[1:]] for row in result.tables[-1].rows}
    assert moving["none"][0] == moving["msaa 4"][0] == 0.0, "nothing can be left behind"
    assert moving["taa 16"][0] < 5.0
    assert moving["taa 16"][1] == pytest.approx(100.0, abs=3.0), "a line at rest has all its light"
    light, restless, flicker, missing = moving["taa 16"][2:]
    assert light == pytest.approx(100.0, abs=6.0), "what is missed in half of the frames is there all the same"
    assert restless == pytest.approx(100.0, abs=6.0), "whether something else moves or not"
    assert flicker < 2.0
    assert missing == 0.0
    assert moving["msaa 4"][2] == pytest.approx(100.0, abs=3.0)
    by_angle = {row[0]: float(row[-1]) for row in result.tables[1].rows}
    assert by_angle["taa 16"] < by_angle["msaa 4"] < by_angle["none"], "an edge at rest"


@pytest.mark.usefixtures("gl_device")
def test_a_lens_is_nearer_to_the_lens(quick: Callable[[], Context]) -> None:
    pytest.importorskip("flip_evaluator")
    errors = {p.curve: p.error for p in run("dof", quick()).points}
    assert errors["gathered"]["rmse"] < 0.6 * errors["off"]["rmse"]
    assert abs(errors["gathered"]["lost"]) < 0.03


@pytest.mark.usefixtures("gl_device")
def test_better_presets_are_better(quick: Callable[[], Context]) -> None:
    pytest.importorskip("flip_evaluator")
    result = run("presets", quick())
    errors = {(p.curve, p.knobs["preset"]): p.error["rmse_8_bit"] for p in result.points}
    table = [row for row in result.tables[0].rows if row[1] in ("low", "high")]
    assert all(row[-1].startswith(("on the front", "beaten by")) for row in table)
    assert len(table) == 2
    assert errors["preset", "high"] < errors["preset", "low"] < errors["none", "low"]
