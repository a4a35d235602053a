"""What is left out is not missed: hypothesis-made scenes, pruned and with everything forced, equal to the bit."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings

from engine.math import quat
from engine.render.facts import SceneFacts
from engine.render.settings import DEBUG_VIEWS
from tests.pruning.compare import pruned_equals_forced, shoot, take
from tests.pruning.scenes import Body, SceneSpec, build, specs
from tests.support.stage import Stage

pytestmark = pytest.mark.gl

BARE = SceneSpec(bodies=(Body(metallic=0.0),))
LIT = replace(BARE, sun=2.0)
#: a ball over a card, so that its shadow is seen
SHADOWED = SceneSpec(bodies=(Body("sphere", 2), Body("card", 0, metallic=0.0)), lights=("directional",))

#: a pane over a card, between it and the sun
TINTED = replace(SHADOWED, bodies=(Body("card", 2, "transparent"), Body("card", 0, metallic=0.0)))
LAMP_TINTED = replace(TINTED, shadows=False, lights=("point",), local_shadows="all")

#: two bodies that hide the surroundings from each other
BESIDE = SceneSpec(bodies=(Body("cube", 0, metallic=0.0), Body("sphere", 1, metallic=0.0)))

#: a cut-out card, seen with several samples
LEAVES = replace(LIT, bodies=(Body("card", 1, "alpha_test", ("base_color_map",)),), samples=4)

#: a ball before a mirror
MIRRORED = replace(
    LIT, bodies=(Body("sphere", 1, metallic=0.0), Body("card", 0, features=("planar_reflection",), roughness=0.0))
)

#: a ball of glass before a block
GLASS = Body("sphere", 1, features=("transmission",), effect="layered", thickness=0.8)
BENT = replace(LIT, bodies=(GLASS, Body("cube", 1, metallic=0.0)))

#: fact -> two scenes that differ in that fact, and in no other but those named after it
TOGGLES: dict[str, tuple[SceneSpec, SceneSpec, tuple[str, ...]]] = {
    "opaque": (replace(LIT, bodies=()), LIT, ("sun_shadows",)),
    "transparent": (LIT, replace(LIT, bodies=(*LIT.bodies, Body("card", 1, "transparent"))), ()),
    "transmission": (
        replace(LIT, bodies=(*LIT.bodies, Body("card", 1, "transparent"))),
        replace(LIT, bodies=(*LIT.bodies, Body("card", 1, "transparent", (), ("transmission",), effect="layered"))),
        ("refraction",),
    ),
    "refraction": (replace(BENT, refraction="straight"), BENT, ()),
    "suns": (BARE, LIT, ("sun_shadows",)),
    "local_lights": (BARE, replace(BARE, lights=("point",)), ("lighting",)),
    "environment": (BARE, replace(BARE, environment="uniform"), ()),
    "background": (
        replace(BARE, environment="uniform"), replace(BARE, environment="uniform", background="environment"), (),
    ),
    "tone_map": (LIT, replace(LIT, tone_map="agx"), ()),
    "samples": (LIT, replace(LIT, samples=4), ()),
    "alpha_to_coverage": (
        replace(LEAVES, cutouts_smooth=False), LEAVES, (),
    ),
    "debug_view": (LIT, replace(LIT, view="normal"), ()),
    "sun_shadows": (replace(SHADOWED, shadows=False), SHADOWED, ()),
    "translucent_shadows": (TINTED, replace(TINTED, translucent_shadows=True), ()),
    "translucent_lamps": (LAMP_TINTED, replace(LAMP_TINTED, translucent_shadows=True), ()),
    "shadow_quality": (SHADOWED, replace(SHADOWED, shadow_filter="none"), ()),
    "ambient_occlusion": (
        replace(BESIDE, environment="uniform"), replace(BESIDE, environment="uniform", ambient_occlusion="gtao"), (),
    ),
    "indirect": (replace(BESIDE, environment="uniform"), replace(BESIDE, environment="uniform", gi="one"), ()),
    "planar": (replace(MIRRORED, planar_mirrors=0), MIRRORED, ()),
    "bloom": (LIT, replace(LIT, bloom=0.3), ()),
    "auto_exposure": (LIT, replace(LIT, auto_exposure=True), ()),
    "shadow_floor": (
        replace(SHADOWED, bodies=(Body("sphere", 0), Body("card", 3, metallic=0.0))),
        replace(SHADOWED, bodies=(Body("sphere", 0), Body("card", 3, metallic=0.0)), shadow_floor=0.8), (),
    ),
    "fxaa": (LIT, replace(LIT, antialias="fxaa"), ()),
    "depth_of_field": (LIT, replace(LIT, depth_of_field=True), ()),
    "smaa": (LIT, replace(LIT, antialias="smaa"), ()),
    "taa": (LIT, replace(LIT, antialias="taa"), ("motion",)),
    "local_shadows": (
        replace(SHADOWED, lights=("point",)), replace(SHADOWED, lights=("point",), local_shadows="all"), (),
    ),
    "soft_lamps": (
        replace(SHADOWED, lights=("point",), local_shadows="all"),
        replace(SHADOWED, lights=("ball",), local_shadows="all"), (),
    ),
    "area_lights": (replace(BARE, lights=("point",)), replace(BARE, lights=("disk",)), ()),
    "light_profiles": (replace(BARE, lights=("point",)), replace(BARE, lights=("profile",)), ()),
}  # fmt: skip
#: facts that are not of the scene: what they must do instead is tested below; of `lighting`, its paths and G-buffer, by
#: test_path_agreement.py and tests/stability/test_paths.py; of `quality` and `stencil`, what an effect says of
#: them, in tests/render/test_effect_stages.py and test_effect_passes.py; `motion` and `moving` show in what is gathered
#: over frames alone: tests/render/test_motion.py; `depth_asked` must change nothing: tests/render/test_depth_first.py
NOT_OF_THE_SCENE = {"depth_asked", "hdr_output", "force_all", "quality", "stencil", "lighting", "motion", "moving"}


@given(spec=specs)
@settings(
    max_examples=40, deadline=None, derandomize=True, database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    phases=[Phase.generate, Phase.shrink],
)  # fmt: skip
def test_random_scenes_are_bit_equal(stage: Stage, texture_folder: Path, spec: SceneSpec) -> None:
    pruned_equals_forced(stage, spec, texture_folder)


def test_every_fact_has_its_negative_test() -> None:
    names = {field.name for field in fields(SceneFacts)}
    assert names == set(TOGGLES) | NOT_OF_THE_SCENE, "a fact without a test may be switched off wrongly, unseen"


@pytest.mark.parametrize("fact", TOGGLES)
def test_switching_a_fact_on_changes_the_picture(stage: Stage, texture_folder: Path, fact: str) -> None:
    off_spec, on_spec, others = TOGGLES[fact]
    off, on = take(stage, off_spec, texture_folder), take(stage, on_spec, texture_folder)
    changed = {f.name for f in fields(SceneFacts) if getattr(off.facts, f.name) != getattr(on.facts, f.name)}
    assert changed == {fact, *others}
    assert (off.color != on.color).any()
    pruned_equals_forced(stage, off_spec, texture_folder)
    pruned_equals_forced(stage, on_spec, texture_folder)


@pytest.mark.parametrize("view", DEBUG_VIEWS)
def test_every_debug_view_survives_pruning(stage: Stage, texture_folder: Path, view: str) -> None:
    for spec in (BARE, LIT, replace(LIT, lights=("spot",), shadows=False)):
        pruned_equals_forced(stage, replace(spec, view=view), texture_folder)


def test_linear_output_is_made_only_for_who_asks(stage: Stage, texture_folder: Path) -> None:
    pictures = take(stage, LIT, texture_folder)
    assert "resolve" in {item.name for item in pictures.left_out}
    assert np.isfinite(pictures.hdr).all()  # and was there where it was asked for


@pytest.mark.parametrize(
    "change", [{"lights": ("dark",)}, {"environment": "uniform", "environment_intensity": 0.0}], ids=str
)
def test_what_gives_no_light_is_no_fact(stage: Stage, texture_folder: Path, change: dict[str, object]) -> None:
    """A light of intensity 0, an environment of intensity 0: the same facts, programs and picture as without."""
    without, with_ = take(stage, BARE, texture_folder), take(stage, replace(BARE, **change), texture_folder)
    assert without.facts == with_.facts
    assert (without.color == with_.color).all()


def test_turning_away_does_not_change_the_facts(stage: Stage, texture_folder: Path) -> None:
    """Nor recompile the graph: facts are of the scene, not of what the camera happens to see."""
    seen, unseen = (take(stage, replace(LIT, looks_away=away), texture_folder) for away in (False, True))
    assert seen.facts == unseen.facts
    camera = build(stage, LIT, texture_folder)
    shoot(stage, LIT, camera, force_all=False)
    graph = stage.runtime.renderer.graph
    before = graph.compiles
    for angle in np.linspace(0.0, 6.0, 7):
        camera.world_from_camera[:3, :3] = quat.to_matrix3(quat.from_axis_angle((0, 1, 0), angle))
        shoot(stage, LIT, camera, force_all=False)
    assert graph.compiles == before


def test_a_difference_is_noticed(stage: Stage, texture_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The comparison can fail: a sky that is never needed."""
    from engine.render.passes.sky import SkyPass

    monkeypatch.setattr(SkyPass, "needs", lambda self, facts: "planted: never needed")
    spec = replace(LIT, environment="uniform", background="environment")
    with pytest.raises(AssertionError, match="sky"):
        pruned_equals_forced(stage, spec, texture_folder)
