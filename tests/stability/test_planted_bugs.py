"""The guards can fail: bugs planted in copied shaders, in a pass or in a fact are caught by the tests named here."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from engine.core.errors import LucarnaError
from engine.core.paths import shaders_dir
from engine.gpu.types import Device
from engine.render import variant_requests
from engine.render.facts import SceneFacts
from engine.render.passes.light_volumes import LightVolumesPass
from engine.render.passes.resolve import ResolvePass
from engine.render.passes.sky import SkyPass
from engine.render.passes.tiled_shading import TiledShadingPass
from engine.render.passes.tone_map import ToneMapPass
from engine.render.passes.transparent import TransparentPass
from tests.pruning.compare import pruned_equals_forced
from tests.pruning.scenes import Body, SceneSpec, write_textures
from tests.stability import brdf_checks, path_checks, poison_checks
from tests.support.shader_probe import ShaderProbe
from tests.support.stage import Stage

pytestmark = pytest.mark.gl

#: a scene that needs every pass and every branch
RICH = SceneSpec(
    bodies=(Body(), Body("card", 1, "transparent")), lights=("point",), environment="uniform", sun=1.0,
    background="environment",
)  # fmt: skip


@pytest.fixture
def plant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, str, str], Path]:
    """Gives a copy of the shaders with one text put in another's place; everything made from now on uses it."""

    def planted(file: str, sound: str, broken: str) -> Path:
        folder = tmp_path / "shaders"
        shutil.copytree(shaders_dir(), folder)
        text = (folder / file).read_text(encoding="utf-8")
        assert sound in text, f"{file} has changed: plant this bug in another way"
        (folder / file).write_text(text.replace(sound, broken), encoding="utf-8")
        for name, module in list(sys.modules.items()):
            if name.startswith("engine.") and hasattr(module, "shaders_dir"):
                monkeypatch.setattr(module, "shaders_dir", lambda: folder)
        return folder

    return planted


@pytest.fixture
def full(gl_device: Device) -> Iterator[Callable[[], Stage]]:
    """Makes the poison test's stage, after the bug has been planted."""
    made: list[Stage] = []

    def make() -> Stage:
        made.append(poison_checks.full_stage(gl_device))
        return made[-1]

    yield make
    for stage in made:
        stage.close()


def test_a_wrong_one_over_pi(gl_device: Device, tmp_path: Path, plant: Callable[..., Path]) -> None:
    """Caught by test_brdf.py::test_lambert_reflects_its_albedo."""
    folder = plant("lib/lights.glsl", "r.diffuse_albedo * (1.0 / PI)", "r.diffuse_albedo")
    with pytest.raises(AssertionError, match=r"reflects 3\.14"):
        brdf_checks.lambert_reflects_its_albedo(ShaderProbe(gl_device, tmp_path, folder))


def test_a_ggx_without_its_one_over_pi(gl_device: Device, tmp_path: Path, plant: Callable[..., Path]) -> None:
    """Caught by test_brdf.py::test_coat_gains_no_energy and test_ggx_resolves_its_lobe."""
    folder = plant("lib/brdf.glsl", "return k * k * (1.0 / PI);", "return k * k;")
    probe = ShaderProbe(gl_device, tmp_path, folder)
    with pytest.raises(AssertionError, match="albedo"):
        brdf_checks.coat_gains_no_energy(probe)
    with pytest.raises(AssertionError, match="p99"):
        brdf_checks.ggx_resolves_its_lobe(probe, 0.1)


def test_an_unclamped_ggx(gl_device: Device, tmp_path: Path, plant: Callable[..., Path]) -> None:
    """Caught by test_brdf.py::test_least_roughness_is_bounded."""
    folder = plant("lib/lights.glsl", "min(d * vis, 1e6)", "d * vis")
    with pytest.raises(AssertionError, match="alpha"):
        brdf_checks.least_roughness_is_bounded(ShaderProbe(gl_device, tmp_path, folder))


def test_the_textbook_ggx(gl_device: Device, tmp_path: Path, plant: Callable[..., Path]) -> None:
    """(n.h)^2 (a^2 - 1) + 1 loses its digits: caught by test_brdf.py::test_ggx_resolves_its_lobe."""
    folder = plant(
        "lib/brdf.glsl", "float k = alpha / max(dot(n_cross_h, n_cross_h) + a * a, 1e-20);",
        "float k = alpha / (n_dot_h * n_dot_h * (alpha * alpha - 1.0) + 1.0);",
    )  # fmt: skip
    with pytest.raises(AssertionError):
        brdf_checks.ggx_resolves_its_lobe(ShaderProbe(gl_device, tmp_path, folder), 0.002025)


def test_a_pass_that_leaks_what_is_not_a_number(full: Callable[[], Stage], plant: Callable[..., Path]) -> None:
    """Caught by test_poison.py::test_pass_contains_poison[resolve-nan]."""
    plant("passes/resolve.frag", "sanitise(hdr.rgb)", "hdr.rgb")
    with pytest.raises(AssertionError, match=r"'resolve'.* is not finite"):
        poison_checks.pass_contains_poison(full(), ResolvePass(), float("nan"))


def test_a_pass_that_smears_its_neighbours(full: Callable[[], Stage], plant: Callable[..., Path]) -> None:
    """A filter of two pixels that says it reaches 0. Caught by test_poison.py::test_pass_contains_poison."""
    plant(
        "passes/tone_map.frag", "texelFetch(t_hdr, ivec2(gl_FragCoord.xy), s)",
        "(texelFetch(t_hdr, ivec2(gl_FragCoord.xy), s) + texelFetch(t_hdr, ivec2(gl_FragCoord.xy) - ivec2(1, 0), s))",
    )  # fmt: skip
    with pytest.raises(AssertionError, match="out of reach"):
        poison_checks.pass_contains_poison(full(), ToneMapPass(), 0.0)


def test_a_pass_without_a_reach(full: Callable[[], Stage], monkeypatch: pytest.MonkeyPatch) -> None:
    """Caught by test_poison.py::test_pass_declares_its_reach."""
    monkeypatch.setattr(ToneMapPass, "reach", None)
    with pytest.raises(AssertionError, match="does not say how far"):
        poison_checks.has_declared_reach(ToneMapPass())


@pytest.mark.parametrize("broken", [SkyPass, TransparentPass], ids=["sky", "transparent"])
def test_a_pass_that_thinks_it_is_not_needed(
    gl_device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, broken: type
) -> None:
    """Caught by tests/pruning/test_pruning.py::test_random_scenes_are_bit_equal and test_switching_a_fact_on."""
    write_textures(tmp_path)
    stage = Stage(gl_device)
    pruned_equals_forced(stage, RICH, tmp_path)
    monkeypatch.setattr(broken, "needs", lambda self, facts: "planted")
    with pytest.raises(AssertionError, match="pixels differ"):
        pruned_equals_forced(stage, RICH, tmp_path)
    stage.close()


@pytest.mark.parametrize(
    ("path", "broken"), [("deferred", LightVolumesPass), ("tiled-deferred", TiledShadingPass)], ids=lambda v: str(v)
)
def test_a_light_pass_that_thinks_it_is_not_needed(
    gl_device: Device, monkeypatch: pytest.MonkeyPatch, path: str, broken: type
) -> None:
    """Caught by test_paths.py::test_every_path_gives_the_same_picture: no light, or no graph at all."""
    stage = Stage(gl_device)
    try:
        monkeypatch.setattr(broken, "needs", lambda self, facts: "planted")
        with pytest.raises((AssertionError, LucarnaError)):
            path_checks.paths_agree(stage, path)
    finally:
        stage.close()


@pytest.mark.parametrize("layout", [1, 2])
def test_a_gbuffer_too_narrow_for_its_materials(
    gl_device: Device, monkeypatch: pytest.MonkeyPatch, layout: int
) -> None:
    """Caught by test_paths.py::test_a_layout_of_the_gbuffer_is_enough and
    tests/render/test_gbuffer.py::test_layout_is_the_narrowest."""
    stage = Stage(gl_device)
    try:
        monkeypatch.setattr("engine.render.light_path.layout_of", lambda rows: layout - 1)
        with pytest.raises(AssertionError, match="leaves out what is seen"):
            path_checks.layout_is_enough(stage, layout)
    finally:
        stage.close()


@pytest.mark.parametrize("branch", ["ENVIRONMENT", "SUNS", "LOCAL_LIGHTS"])
def test_a_branch_compiled_out_wrongly(
    gl_device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, branch: str
) -> None:
    """Caught by tests/pruning/test_pruning.py::test_random_scenes_are_bit_equal."""
    write_textures(tmp_path)
    sound = SceneFacts.variant_defines

    def without(self: SceneFacts) -> dict[str, int]:
        return sound(self) if self.force_all else {**sound(self), branch: 0}

    if branch == "LOCAL_LIGHTS":  # decided per path
        local = variant_requests._local_lights
        monkeypatch.setattr(
            variant_requests, "_local_lights", lambda s, facts, *r: local(s, facts, *r) * facts.force_all
        )
    monkeypatch.setattr(SceneFacts, "variant_defines", without)
    stage = Stage(gl_device)
    with pytest.raises(AssertionError, match="pixels differ"):
        pruned_equals_forced(stage, RICH, tmp_path)
    stage.close()
