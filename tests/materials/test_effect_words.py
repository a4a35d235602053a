"""The words of techniques: state groups, targets, stages, passes, levels, samplers, conditions; each mistake at its
place."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from engine.core.errors import ShaderError
from engine.gpu import open_device
from engine.gpu.types import BlendState, Caps, RenderPipelineDesc, SamplerDesc, StencilFace, StencilState
from engine.materials.effect import Effect, load_effect
from engine.materials.variant import VariantRequest, describe

V, F = "void main() { gl_Position = vec4(0.0); }", "void main() {}"
HEAD = 'name = "x"\n[technique.forward]\nvertex = "v.vert"\nfragment = "f.frag"\n'


def loaded(folder: Path, text: str, name: str = "x") -> Effect:
    (folder / f"{name}.effect.toml").write_text(text, encoding="utf-8")
    for file, source in (("v.vert", V), ("f.frag", F), ("g.geom", F), ("c.tesc", F), ("e.tese", F)):
        (folder / file).write_text(source, encoding="utf-8")
    return load_effect(folder / f"{name}.effect.toml", search=[folder])


def described(folder: Path, text: str, **request: object) -> RenderPipelineDesc:
    wanted = {"effect": "x", "role": "forward", "features": frozenset(), "attributes": (), **request}
    return describe(loaded(folder, text), VariantRequest(**wanted), [folder])  # type: ignore[arg-type]  # by name


def failure(folder: Path, text: str) -> str:
    with pytest.raises(ShaderError) as caught:
        loaded(folder, text)
    return str(caught.value).replace(f"{folder}/", "")


def test_state_groups_lie_over_each_other_key_by_key(tmp_path: Path) -> None:
    text = (
        'name = "x"\n[states.marked]\nstencil = { pass = "replace", reference = 3, back = { pass = "invert" } }\n'
        'depth = { write = false, bias = 2.0 }\nraster = { cull = "none" }\n'
        "[states.near]\ndepth = { bias = 5.0 }\nstencil.reference = 7\n"
        + HEAD.removeprefix('name = "x"\n')
        + 'states = ["marked", "near"]\ndepth = { compare = "always" }\nstencil = { read_mask = 15 }\n'
    )
    desc = described(tmp_path, text)
    replaced = StencilFace(passed="replace")
    assert desc.stencil == StencilState(replaced, StencilFace(passed="invert"), 7, 15, 255)
    assert desc.depth is not None
    assert (desc.depth.write, desc.depth.bias, desc.depth.compare) == (False, 5.0, "always")
    assert desc.raster.cull == "none"
    assert described(tmp_path, HEAD).stencil is None


def test_blend_by_word_table_and_target(tmp_path: Path) -> None:
    text = (
        'name = "x"\n[technique.gbuffer]\nvertex = "v.vert"\nfragment = "f.frag"\nwrite_mask = "rgb"\n'
        'blend = { src = "constant", dst = "one", op = "max" }\nblend_constant = [0.1, 0.2, 0.3, 0.4]\n'
        'targets.gbuffer1 = { blend = "additive" }\ntargets.0 = { write_mask = "a" }\n'
    )
    desc = described(tmp_path, text, role="gbuffer", targets=3)
    mixed = BlendState("constant", "one", "max", "constant", "one", "max")
    assert desc.blend == (
        replace(mixed, write_mask="a"), replace(mixed, write_mask="rgb"),
        BlendState("one", "one", "add", "one", "one", "add", "rgb"),
    )  # fmt: skip
    assert desc.blend_constant == (0.1, 0.2, 0.3, 0.4)


def test_what_is_blended_by_its_queue(tmp_path: Path) -> None:
    """The queue makes an opaque technique premultiplied; one that says how it blends keeps that."""
    assert described(tmp_path, HEAD, blended=True).blend[0] == BlendState(
        "one", "one_minus_src_alpha", "add", "one", "one_minus_src_alpha", "add"
    )
    own = described(tmp_path, HEAD + 'blend = "additive"\n', blended=True).blend[0]
    assert own == BlendState("one", "one", "add", "one", "one", "add")


def test_raster_words(tmp_path: Path) -> None:
    text = HEAD + (
        'raster = { cull = "front", front = "cw", fill = "wireframe", depth_clamp = true, alpha_to_coverage = true, '
        "sample_mask = 5, scissor = [0.0, 0.25, 0.5, 0.5] }\n"
    )
    raster = described(tmp_path, text, cull="none").raster
    assert (raster.cull, raster.front_ccw, raster.fill, raster.depth_clamp) == ("front", False, "wireframe", True)
    assert (raster.alpha_to_coverage, raster.sample_mask, raster.scissor) == (True, 5, (0.0, 0.25, 0.5, 0.5))
    assert described(tmp_path, HEAD, cull="none").raster.cull == "none"
    assert described(tmp_path, text, front_ccw=False).raster.front_ccw  # mirrored, and the technique turns it again


PASSES = HEAD + (
    'defines = { A = 1, B = 2.5 }\n[[technique.forward.passes]]\nname = "body"\n'
    '[[technique.forward.passes]]\nname = "hull"\nfragment = "hull.frag"\ndefines = { A = true, C = 3 }\n'
    'raster = { cull = "front" }\n'
)


def test_passes(tmp_path: Path) -> None:
    technique = loaded(tmp_path, PASSES).technique("forward")
    assert [draw.name for draw in technique.passes] == ["body", "hull"]
    assert technique.files == {"v.vert", "f.frag", "hull.frag"}
    (tmp_path / "hull.frag").write_text(F, encoding="utf-8")
    hull = described(tmp_path, PASSES, index=1)
    assert hull.raster.cull == "front"
    assert "#define A 1\n#define B 2.5\n#define C 3\n" in hull.vertex.text
    assert "#define C" not in described(tmp_path, PASSES).vertex.text


STAGES = HEAD + (
    '[technique.forward.levels.medium]\ngeometry = "g.geom"\nrequires = ["geometry"]\n'
    '[technique.forward.levels.high]\ntess_control = "c.tesc"\ntess_evaluation = "e.tese"\npatch_vertices = 4\n'
    'requires = ["tessellation", "hardware"]\n'
)


def test_stages_and_levels(tmp_path: Path) -> None:
    desc = described(tmp_path, STAGES)
    assert [source.stage for source in desc.stages] == ["vertex", "tess_control", "tess_evaluation", "fragment"]
    assert (desc.topology, desc.patch_vertices) == ("patches", 4)
    assert [s.stage for s in described(tmp_path, STAGES, level="medium").stages] == ["vertex", "geometry", "fragment"]
    assert described(tmp_path, STAGES, level="low").topology == "triangles"
    with pytest.raises(ShaderError, match="a strip of triangles cannot be drawn as patches"):
        described(tmp_path, STAGES, topology="triangle_strip")


@pytest.mark.parametrize(
    ("wanted", "software", "level", "why"),
    [
        ("auto", False, "high", "the highest"),
        ("auto", True, "medium", "the highest; high needs hardware"),
        ("high", True, "medium", "high is wanted; high needs hardware"),
        ("medium", False, "medium", "medium is wanted"),
        ("low", False, "low", "low is wanted"),
    ],
)
def test_the_level_is_chosen_by_device_and_wish(
    tmp_path: Path, wanted: str, software: bool, level: str, why: str
) -> None:
    device = open_device("null")
    caps: Caps = replace(device.caps, software=software)
    device.release()
    technique, reason = loaded(tmp_path, STAGES).technique("forward").at(wanted, caps)
    assert technique is not None
    assert (technique.level, reason) == (level, why)


def test_a_device_that_can_do_no_level(tmp_path: Path) -> None:
    text = HEAD + 'requires = ["hardware"]\nlevel = "high"\n'
    device = open_device("null")
    caps = replace(device.caps, software=True)
    device.release()
    assert loaded(tmp_path, text).technique("forward").at("low", caps)[0] is None
    with pytest.raises(ShaderError, match=r"x.effect.toml:2:1: technique.forward: this device can do no level; high n"):
        describe(loaded(tmp_path, text), VariantRequest("x", "forward", frozenset(), ()), [tmp_path], caps=caps)
    assert loaded(tmp_path, text).technique("forward").at("low", replace(caps, software=False))[1].startswith("low is")


def test_sampler_groups(tmp_path: Path) -> None:
    text = (
        'name = "x"\n[samplers.soft]\nwrap = "border"\nwrap_v = "mirror_once"\nborder = "#ff000080"\nanisotropy = 4.0\n'
        'compare = "lequal"\nlod_bias = -0.5\nlod_min = 1.0\nlod_max = 4.0\nmin_filter = "linear"\n'
        '[textures.a_map]\nsampler = "soft"\n[textures.b_map]\n'
    )
    slots = loaded(tmp_path, text).textures
    assert slots[1].sampler is None
    assert slots[0].sampler == SamplerDesc(
        "border", "mirror_once", "border", "linear", "linear", 4.0, "lequal",
        (1.0, 0.0, 0.0, pytest.approx(128 / 255)), -0.5, 1.0, 4.0,  # type: ignore[arg-type]  # near that number
    )  # fmt: skip


def test_inherited_techniques_change_key_by_key_and_go_by_false(tmp_path: Path) -> None:
    loaded(tmp_path, STAGES.replace('name = "x"', 'name = "base"') + '[technique.depth]\nvertex = "v.vert"\n', "base")
    text = (
        'name = "x"\nextends = "base"\n[technique]\ndepth = false\n[technique.forward.levels.medium]\ngeometry = ""\n'
        "raster.cull = 'none'\n"
    )
    effect = loaded(tmp_path, text)
    assert list(effect.techniques) == ["forward"]
    medium = effect.technique("forward").levels["medium"]
    assert (medium.passes[0].geometry, medium.raster.cull, medium.requires) == ("", "none", ("geometry",))


def test_findings_are_no_errors(tmp_path: Path) -> None:
    text = HEAD + '[technique.velocty]\nvertex = "v.vert"\n[technique.depth]\nvertex = "f.frag"\n'
    found = [(message, place.line) for message, place in loaded(tmp_path, text).findings]
    assert found[0][0].startswith("no pass asks for the role 'velocty' yet")
    assert found[0][1] == 5
    assert "depth and forward place vertices by other stages" in found[1][0]
    assert found[1][1] == 7
    assert not loaded(tmp_path, HEAD).findings


P = '[params.a]\ntype = "float"\ndefault = 0.0\n'


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        (HEAD + 'stencil = { pass = "replce" }', "5:20", "'replce' is not a choice (did you mean 'replace'?)"),
        (HEAD + "stencil = { passed = 'zero' }", "5:13", "unknown key 'passed' in technique.forward.stencil (did you"),
        (HEAD + "stencil = { front = { referenc = 1 } }", "5:23", "unknown key 'referenc'"),
        (HEAD + "stencil = { reference = 256 }", "5:25", "expected less than or equal to 255, got 256"),
        (HEAD + 'blend = { src = "src_alfa" }', "5:17", "did you mean 'src_alpha'?"),
        (HEAD + "blend = { sorce = 'one' }", "5:11", "unknown key 'sorce' in technique.forward.blend (did you mean 's"),
        (HEAD + "blend = 3", "5:9", "technique.forward.blend: 3 is not a choice"),
        (HEAD + "targets.gbufer0 = {}", "5:9", "the role 'forward' has no target 'gbufer0' (there are: color)"),
        (HEAD + "targets.1 = {}", "5:9", "the role 'forward' has no target '1'"),
        (HEAD.replace("forward", "depth") + "targets.color = {}", "5:9", "has no colour targets"),
        (HEAD + 'write_mask = "bgr"', "5:14", "technique.forward.write_mask"),
        (HEAD + "raster = { scissor = [0.0, 0.0, 1.5, 1.0] }", "5:33", "less than or equal to 1"),
        (HEAD + "raster = { scissor = [0.0] }", "5:22", "at least 4 items"),
        (HEAD + 'states = ["markd"]\n[states.marked]\ndepth.write = false', "5:11", "did you mean 'marked'?"),
        (HEAD + "[states.marked]\ndetph = {}", "6:1", "unknown key 'detph' in states.marked (did you mean 'depth'?)"),
        (HEAD + 'tess_control = "c"', "5:1", "needs a tess_evaluation stage"),
        (HEAD + "patch_vertices = 4", "5:1", "only a tess_evaluation stage draws patches"),
        (HEAD + 'tess_evaluation = "e"\npatch_vertices = 33', "6:18", "less than or equal to 32"),
        (HEAD + 'compute = "x.comp"', "5:1", "a technique draws"),
        (HEAD + 'pixel = "x"', "5:1", "unknown key 'pixel' in technique.forward"),
        (HEAD + "defines = { size = 3 }", "5:13", "'size' cannot be a macro here: use capitals"),
        (HEAD + "defines = { MOSS = 1 }\n[features.moss]", "5:13", "'MOSS' cannot be a macro here: is a feature"),
        (HEAD + 'streams = ["uv"]', "5:12", "there is no vertex stream 'uv'"),
        (HEAD + 'requires = ["tesselation"]', "5:13", "did you mean 'tessellation'?"),
        (HEAD + "[technique.forward.levels.hgih]", "5:1", "unknown level 'hgih' (did you mean 'high'?)"),
        (HEAD + "[technique.forward.levels.low]", "5:1", "the technique itself is the level 'low'"),
        (HEAD + '[technique.forward.levels.high]\nvertx = "v"', "6:1", "unknown key 'vertx' in technique.forward.lev"),
        (HEAD + '[[technique.forward.passes]]\nraster.cul = "none"', "6:8", "unknown key 'cul'"),
        (HEAD + '[[technique.forward.passes]]\nvertex = ""', "6:10", "every pass needs a vertex stage"),
        ('name = "x"\n[textures.a]\nsampler = "sfot"\n[samplers.soft]', "3:11", "did you mean 'soft'?"),
        ('name = "x"\n[samplers.soft]\nwrap = "clmap"', "3:8", "did you mean 'clamp'?"),
        ('name = "x"\n[samplers.soft]\nborder = "#12345"', "3:10", "5 digits, 3, 4, 6 or 8 are wanted"),
        ('name = "x"\n[samplers.soft]\nanisotropy = 32.0', "3:14", "less than or equal to 16"),
        ('name = "x"\n' + P + 'when = "b > 1"', "5:8", "condition 'b > 1': there is no 'b'"),
        ('name = "x"\n' + P + 'when = "a >"', "5:8", "expected a value at the end"),
        ('name = "x"\n[params.c]\ntype = "color3"\ndefault = "#ff00zz"', "4:11", "'z' is no hexadecimal digit"),
        ('name = "x"\n[params.c]\ntype = "color3"\ndefault = "ornage"', "4:11", "did you mean 'orange'?"),
        ('name = "x"\n[params.c]\ntype = "color3"\ndefault = { rgb = [1.0, 1.0, 1.0] }', "4:11", "one key, srgb or li"),
    ],
)  # fmt: skip
def test_mistakes(tmp_path: Path, text: str, place: str, message: str) -> None:
    found = failure(tmp_path, text)
    assert found.startswith(f"x.effect.toml:{place}: ")
    assert message in found
    assert "^" in found
