"""One bad texel stays one bad texel: every pass of every path, by itself. A pass is covered by being registered."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from engine.framegraph.passes import Pass
from engine.gpu.types import Device
from engine.render.paths.choice import PASSES as PATHS
from tests.stability import poison_checks as checks
from tests.stability.rows import covers
from tests.support import poison
from tests.support.stage import Stage

pytestmark = pytest.mark.gl

#: pass name -> (pass, the path that it is tried in)
PASSES = {item.name: (item, path) for path, make in reversed(PATHS.items()) for item in make()}
#: deferred paths have one sample a pixel, and these passes work with one only
ONE_SAMPLE = ("taa", "depth_of_field")
MULTISAMPLED = [n for n, (_, path) in PASSES.items() if path in ("forward", "forward-plus") and n not in ONE_SAMPLE]


@pytest.fixture
def full(gl_device: Device) -> Iterator[Stage]:
    made = checks.full_stage(gl_device)
    yield made
    made.close()


@pytest.mark.parametrize("item", [item for item, _ in PASSES.values()], ids=list(PASSES))
def test_pass_declares_its_reach(item: Pass) -> None:
    checks.has_declared_reach(item)


@covers("format.one-bad-pixel")
@pytest.mark.parametrize("value", poison.VALUES)
@pytest.mark.parametrize("name", PASSES)
def test_pass_contains_poison(full: Stage, name: str, value: str) -> None:
    item, path = PASSES[name]
    checks.pass_contains_poison(full, item, poison.VALUES[value], path=path)


@covers("format.one-bad-pixel")
@pytest.mark.parametrize("value", ["nan", "inf", "minus_one", "huge"])
@pytest.mark.parametrize("name", MULTISAMPLED)
def test_multisampled_pass_contains_poison(full: Stage, name: str, value: str) -> None:
    item, path = PASSES[name]
    checks.pass_contains_poison(full, item, poison.VALUES[value], samples=4, path=path)


def test_poison_is_really_planted(full: Stage) -> None:
    """The harness can fail: a plain value planted in front of the tone map shows in that pixel, and only there."""
    view = checks.full_view(full)
    clean = poison.shoot(full.runtime, view, "tone_map")
    shot = poison.shoot(full.runtime, view, "tone_map", ("hdr", 3, 5, 0.25))
    differs = (shot.color != clean.color).any(axis=-1)
    assert differs.sum() == 1
    assert differs[5, 3]


def test_poison_in_front_of_several_samples_is_really_planted(full: Stage) -> None:
    view = checks.full_view(full, samples=4)
    clean = poison.shoot(full.runtime, view, "tone_map")
    shot = poison.shoot(full.runtime, view, "tone_map", ("hdr", 3, 5, 0.25))
    differs = (shot.color != clean.color).any(axis=-1)
    assert differs.sum() == 1
    assert differs[5, 3]
