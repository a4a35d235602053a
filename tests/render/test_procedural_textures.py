"""Texture slots that an effect computes: known texels and mips, computed again only where it must, mistakes, NaN."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from engine.app.runtime import Runtime
from engine.core.errors import ShaderError
from engine.core.paths import shaders_dir
from engine.gpu.types import Device
from engine.materials.effect import load_effect
from engine.materials.variant import draw_of
from engine.report.metrics import is_blank
from tests.support.effect_project import PATHS, EffectProject, picture

EFFECT = """name = "ramp"
extends = "surface"
[params.height]
type = "float"
default = 0.5
[params.other]
type = "float"
default = 0.5
[textures.steps]
default = "black"
[technique.texture]
compute = "effects/ramp.comp"
outputs = { base_color_map = "rgba32f", normal_map = "rgba32f" }
size = [16, 8]
levels.high = { size = [32, 16] }
"""
RAMP = """void main()
{
    vec2 at = texture_uv();
    write_base_color_map(vec4(at, material().height, 1.0));
    write_normal_map(vec4(at.x < 0.5 ? vec3(1.0, 0.5, 0.5) : vec3(0.5, 0.5, 1.0), 1.0));
}
"""
MATERIAL = 'name = "thing"\neffect = "ramp"\n[params]\nmetallic = 0.0\n'
FILES = {
    "shaders/effects/ramp.effect.toml": EFFECT,
    "shaders/effects/ramp.comp": RAMP,
    "thing.material.toml": MATERIAL,
}


@pytest.fixture
def project(tmp_path: Path) -> EffectProject:
    return EffectProject(tmp_path, FILES)


@pytest.fixture
def runtime(gl_device: Device, project: EffectProject) -> Iterator[Runtime]:
    made = project.open(gl_device)
    yield made
    made.close()


def thing(runtime: Runtime) -> int:
    return next(i for i, r in enumerate(runtime.residency.materials.records) if "height" in r.effect.param_by_name)


def texels(runtime: Runtime, level: int = 0, slot: str = "base_color_map") -> np.ndarray:
    texture, layer = runtime.residency.materials.slot_texture(thing(runtime), slot)
    return np.array(texture.read(level=level, layer=layer))


def test_texels_are_what_the_shader_writes_and_mips_their_means(runtime: Runtime) -> None:
    assert not is_blank(picture(runtime, quality="low"))
    y, x = np.mgrid[0:8, 0:16] + 0.5
    expected = np.stack([x / 16, y / 8, np.full_like(x, 0.5), np.ones_like(x)], axis=-1)
    assert np.array_equal(texels(runtime), expected.astype(np.float32))
    for level in range(1, 5):
        high, wide = max(expected.shape[0] // 2, 1), expected.shape[1] // 2
        rows = expected if expected.shape[0] == 1 else expected.reshape(high, 2, -1, 4).mean(axis=1)
        expected = rows.reshape(high, wide, 2, 4).mean(axis=2)
        assert texels(runtime, level) == pytest.approx(expected, abs=1e-6), level
    tip = 2.0 * texels(runtime, 4, "normal_map")[0, 0, :3] - 1.0
    assert tip == pytest.approx([0.5, 0.0, np.sqrt(0.75)], abs=1e-5), "directions stay of length 1"


def test_computed_again_only_where_the_shader_reads_it(runtime: Runtime) -> None:
    """A quality that is not the same has another size; the same picture in all paths."""
    textures, material = runtime.residency.procedural, thing(runtime)
    first = picture(runtime, path="forward", quality="low")
    assert textures.computed == 1
    for path in PATHS[1:]:
        assert np.array_equal(picture(runtime, path=path, quality="low"), first), path
    runtime.residency.set_material_param(material, "other", 0.9)
    runtime.residency.set_material_param(material, "roughness", 0.3)
    picture(runtime, quality="low")
    assert textures.computed == 1
    runtime.residency.set_material_param(material, "height", 0.9)
    picture(runtime, quality="low")
    assert textures.computed == 2
    assert (texels(runtime)[..., 2] == np.float32(0.9)).all()
    runtime.residency.set_material_param(material, "height", 0.5)
    runtime.residency.set_material_param(material, "other", 0.5)
    runtime.residency.set_material_param(material, "roughness", 1.0)
    assert np.array_equal(picture(runtime, quality="low"), first)
    picture(runtime, quality="high")
    assert texels(runtime).shape == (16, 32, 4)


def test_a_broken_edit_keeps_the_last_texels_and_says_where(runtime: Runtime, project: EffectProject) -> None:
    before = picture(runtime)
    project.write("shaders/effects/ramp.comp", RAMP.replace("vec4(at, material().height, 1.0)", "vec4(at, heigth)"))
    assert runtime.hot_reload.poll(force=True) is not None
    (problem,) = runtime.hot_reload.problems
    assert Path(problem.where.file).name == "ramp.comp"
    assert problem.where.line == 4
    assert np.array_equal(picture(runtime), before)
    project.write("shaders/effects/ramp.comp", RAMP.replace("material().height", "0.25"))
    assert runtime.hot_reload.poll(force=True) is not None
    assert not runtime.hot_reload.problems
    assert not np.array_equal(picture(runtime), before)
    assert (texels(runtime)[..., 2] == 0.25).all()
    project.write("shaders/effects/ramp.effect.toml", EFFECT.replace('compute = "effects/ramp.comp"', "compute = 3"))
    assert runtime.hot_reload.poll(force=True) is not None
    assert runtime.hot_reload.problems[0].where.line == 12
    assert (texels(runtime)[..., 2] == 0.25).all()


def test_nan_in_a_computed_texture_goes_back(runtime: Runtime, project: EffectProject) -> None:
    """Also where no pixel shows it: in one slot's corner, deferred, with 8 bit colours."""
    before = picture(runtime, path="deferred")
    bad = RAMP.replace("material().height", "texel() == ivec2(3, 2) ? sqrt(-1.0 - at.x) : material().height")
    project.write("shaders/effects/ramp.comp", bad)
    assert runtime.hot_reload.poll(force=True) is not None
    assert np.array_equal(picture(runtime, path="deferred"), before)
    (problem,) = runtime.hot_reload.problems
    assert "'computed textures' now leaves" in str(problem)
    assert "ramp.comp" in str(problem)
    assert np.isfinite(texels(runtime)).all()


def test_what_never_compiled_is_magenta(gl_device: Device, project: EffectProject) -> None:
    project.write("shaders/effects/ramp.comp", "void main() { wrong }\n")
    runtime = project.open(gl_device)
    try:
        seen = picture(runtime, view="base_color").astype(int)[24, 32]
        assert seen[0] > 200, seen
        assert seen[1] < 30, seen
        assert [state for state, _ in runtime.hot_reload.standing()] == ["magenta"]
        project.write("shaders/effects/ramp.comp", RAMP)
        assert runtime.hot_reload.poll(force=True) is not None
        picture(runtime, quality="low")
        assert texels(runtime).shape == (8, 16, 4)
        assert not runtime.hot_reload.problems
    finally:
        runtime.close()


def test_materials_have_a_layer_each_and_stay_one_batch(gl_device: Device, project: EffectProject) -> None:
    """And nothing at all is done for what is not drawn."""
    project.write("floor.material.toml", MATERIAL.replace("thing", "floor") + "height = 0.75\n")
    runtime = project.open(gl_device)
    try:
        picture(runtime, quality="low")
        drawn = runtime.renderer.draws.opaque
        assert len({batch.state for batch in drawn}) == 1
        values = [texels_of(runtime, m)[0, 0, 2] for m in range(len(runtime.residency.materials.records))]
        assert sorted(values)[-2:] == [0.5, 0.75]
        unseen = runtime.residency.load_material(project.write("unseen.material.toml", MATERIAL))
        picture(runtime, quality="low")
        assert runtime.residency.procedural.computed == 2
        assert unseen >= 2
    finally:
        runtime.close()


def texels_of(runtime: Runtime, material: int) -> np.ndarray:
    texture, layer = runtime.residency.materials.slot_texture(material, "base_color_map")
    return np.array(texture.read(layer=layer))


def test_nothing_is_dispatched_on_the_second_frame_nor_without_such_an_effect(
    null_device: Device, project: EffectProject
) -> None:
    runtime = project.open(null_device)
    try:
        picture(runtime, path="forward", quality="low")
        first = null_device.counters.dispatches
        picture(runtime, path="forward", quality="low")
        again = null_device.counters.dispatches
        # the texture, then four mips of each of two outputs
        assert first - again == 1 + 2 * 4
        project.write("thing.material.toml", 'name = "thing"\n')
        runtime.hot_reload.poll(force=True)
        for _ in range(2):  # the first one after an edit is looked into
            picture(runtime, path="forward", quality="low")
        assert null_device.counters.dispatches == again
        assert runtime.residency.procedural.computed == 1
    finally:
        runtime.close()


HEAD = 'name = "x"\nextends = "surface"\n[technique.texture]\n'
GOOD = 'compute = "effects/a.comp"\noutputs = { base_color_map = "rgba8" }\nsize = [64, 64]\n'


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        (HEAD + GOOD + 'vertex = "v"', "7:1", "computes textures and draws nothing, so it has no vertex"),
        (HEAD + GOOD + "depth = { write = false }", "7:1", "so it has no depth"),
        (HEAD + GOOD.replace("base_color_map", "base_colour_map"), "5:13", "did you mean 'base_color_map'?"),
        (HEAD + GOOD.replace("rgba8", "rgba9"), "5:30", "'rgba9' is not a choice (did you mean 'rgba8'"),
        (HEAD + GOOD.replace("64, 64", "64, 65"), "6:13", "65 is no power of two"),
        (HEAD + GOOD.replace("64, 64", "64"), "6:8", "at least 2 items"),
        (HEAD + GOOD.replace("64, 64", "64, 8192"), "6:13", "less than or equal to 4096"),
        (HEAD + GOOD.replace("size = [64, 64]", ""), "3:1", "the key 'size' is missing in technique.texture"),
        (HEAD + GOOD.splitlines()[0] + "\nsize = [8, 8]", "3:1", "the key 'outputs' is missing"),
        (HEAD + "\n".join(GOOD.splitlines()[1:]), "3:1", "needs a compute stage"),
        (
            HEAD.replace("texture]", "forward]") + "size = [8, 8]",
            "4:1",
            "draws in the role 'forward', so it has no size",
        ),
    ],
)
def test_mistakes(tmp_path: Path, text: str, place: str, message: str) -> None:
    file = tmp_path / "x.effect.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ShaderError) as caught:
        load_effect(file, search=[shaders_dir()])
    assert message in str(caught.value)
    assert f":{place}: " in str(caught.value)


def test_passes_follow_each_other_and_read_what_was_written(gl_device: Device, project: EffectProject) -> None:
    """The second pass moves the first one's ramp by a texel, round the edge."""
    passes = '[[technique.texture.passes]]\n[[technique.texture.passes]]\ncompute = "effects/turn.comp"\n'
    project.write("shaders/effects/ramp.effect.toml", EFFECT.replace("levels.high = { size = [32, 16] }\n", passes))
    turn = "void main()\n{\n    write_normal_map(read_base_color_map(texel() + ivec2(1, 0)));\n}\n"
    project.write("shaders/effects/turn.comp", turn)
    runtime = project.open(gl_device)
    try:
        picture(runtime)
        assert np.array_equal(texels(runtime, slot="normal_map"), np.roll(texels(runtime), -1, axis=1))
        effect = runtime.residency.effect_of(thing(runtime))
        requests = [v.request for v in runtime.residency.effects.variants() if v.request.role == "texture"]
        assert [draw_of(effect, r).compute for r in requests] == ["effects/ramp.comp", "effects/turn.comp"]
    finally:
        runtime.close()
