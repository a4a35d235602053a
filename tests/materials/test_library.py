"""EffectLibrary: variants and their cache, magenta, hot reload that never loses the last good pipeline."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from engine.core.errors import InputError, Place, ShaderError, UsageError
from engine.core.paths import shaders_dir
from engine.framegraph.explain import explain
from engine.framegraph.graph import FrameGraph
from engine.gpu.null.device import NullDevice
from engine.gpu.types import BlendState, Pipeline, RenderPipelineDesc, VertexAttribute
from engine.materials.features import FeatureSet
from engine.materials.library import EffectLibrary

DATA = Path(__file__).parent / "data"
POSITION = VertexAttribute(0, "position", "f4x3")
UV0 = VertexAttribute(3, "uv0", "f4x2")


class PickyDevice(NullDevice):
    """A null device whose compiler refuses stages with the word BROKEN in them, and keeps the descs."""

    def __init__(self) -> None:
        super().__init__()
        self.descs: list[RenderPipelineDesc] = []

    def render_pipeline(self, desc: RenderPipelineDesc) -> Any:
        for stage in (desc.vertex, desc.fragment):
            if stage is not None and "BROKEN" in stage.text:
                line = next(i for i, text in enumerate(stage.text.splitlines()) if "BROKEN" in text)
                file, number = stage.lines[line]
                raise ShaderError("syntax error", where=Place(file, number, 1))
        self.descs.append(desc)
        return super().render_pipeline(desc)


@pytest.fixture
def device() -> PickyDevice:
    return PickyDevice()


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """A copy of the test effects that a test may change."""
    return shutil.copytree(DATA, tmp_path / "shaders")  # type: ignore[return-value]  # a fixture gives what it returns


def library(folder: Path = DATA) -> EffectLibrary:
    return EffectLibrary([folder, shaders_dir()])


def edit(path: Path, old: str, new: str) -> None:
    """Change a file so that its stamp differs even on coarse clocks."""
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    info = path.stat()
    os.utime(path, ns=(info.st_atime_ns, info.st_mtime_ns + 1_000_000))


def forward(effects: EffectLibrary, device: PickyDevice, *features: str) -> Pipeline:
    return effects.pipeline(device, "swatch", "forward", frozenset(features), (POSITION, UV0))


def test_effects_by_name() -> None:
    effects = library()
    assert effects.get("swatch") is effects.get("swatch")
    assert {"glow", "swatch", "surface"} <= set(effects.names())
    with pytest.raises(InputError, match="did you mean 'swatch'"):
        effects.get("swacth")


def test_a_variant_is_compiled_once(device: PickyDevice) -> None:
    effects = library()
    first = forward(effects, device)
    assert forward(effects, device) is first
    assert effects.compiled == 1
    assert forward(effects, device, "base_map") is not first
    assert effects.compiled == 2
    effects.pipeline(device, effects.get("swatch"), "forward", frozenset(), (POSITION, UV0), cull="none")
    effects.pipeline(device, "swatch", "forward", frozenset(), (POSITION, UV0), defines={"SAMPLES": 4})
    effects.pipeline(device, "swatch", "forward", frozenset(), (POSITION, UV0), prelude="// scene\n")
    assert effects.compiled == 5
    assert [v.label for v in effects.variants()] == ["swatch forward"] * 5


def test_state_comes_from_the_technique_unless_given(device: PickyDevice) -> None:
    effects = library()
    effects.pipeline(device, "glow", "forward", frozenset(), (POSITION,), targets=2, front_ccw=False)
    desc = device.descs[-1]
    assert desc.depth is not None
    assert not desc.depth.write
    assert desc.blend == (BlendState("one", "one", "add", "one", "one", "add"),) * 2
    assert (desc.raster.cull, desc.raster.front_ccw, desc.topology) == ("back", False, "triangles")
    effects.pipeline(
        device, "glow", "forward", frozenset(), (POSITION,),
        topology="lines", cull="none", fill="wireframe", blend="opaque", depth_write=True, depth_compare="equal",
    )  # fmt: skip
    desc = device.descs[-1]
    assert desc.depth is not None
    assert (desc.depth.write, desc.depth.compare) == (True, "equal")
    assert desc.blend == (None,)
    assert (desc.raster.cull, desc.raster.fill, desc.topology) == ("none", "wireframe", "lines")
    with pytest.raises(UsageError, match="did you mean 'opaque'"):
        effects.pipeline(device, "glow", "forward", blend="opaq")


def test_defines_and_prelude_reach_both_stages(device: PickyDevice) -> None:
    effects = EffectLibrary([DATA], prelude="// of the library\n")
    effects.pipeline(
        device, "swatch", "forward", frozenset({"base_map"}), (POSITION,), defines={"HAS_UV0": 1}, prelude="// of it\n"
    )
    fragment = device.descs[-1].fragment
    assert fragment is not None
    for text in (device.descs[-1].vertex.text, fragment.text):
        assert "#define BASE_MAP 1" in text
        assert "#define RELIEF_MAP 0" in text
        assert "#define HAS_UV0 1" in text  # what the caller defines goes over what the streams say
        assert "#define HAS_UV1 0" in text
        assert text.index("// of the library") < text.index("// of it") < text.index("struct MaterialParams")


def test_a_role_without_fragment_shader_and_its_features(device: PickyDevice) -> None:
    effects = library()
    effects.pipeline(device, "swatch", "shadow", frozenset({"base_map"}), (POSITION,), targets=0)
    desc = device.descs[-1]
    assert desc.fragment is None
    assert desc.blend == ()
    assert "#define BASE_MAP 0" in desc.vertex.text
    variant = effects.variants()[0]
    assert variant.features == frozenset()
    assert variant.absent["base_map"] == "makes no difference in shadow"


def test_variants_say_why_they_exist(device: PickyDevice) -> None:
    effects = library()
    told = FeatureSet({"base_map": "the material has the texture 'base_map'"}, {"relief_map": "no tangent"})
    effects.pipeline(device, "swatch", "forward", told, (POSITION,))
    variant = effects.variants()[0]
    assert variant.reasons == {"base_map": "the material has the texture 'base_map'"}
    assert variant.absent["relief_map"] == "no tangent"
    assert variant.absent["alpha_test"] == "no material of the variant uses it"


def test_unknown_roles_and_features(device: PickyDevice) -> None:
    with pytest.raises(InputError, match="did you mean 'forward'"):
        library().pipeline(device, "swatch", "froward")
    with pytest.raises(InputError, match="did you mean 'base_map'"):
        forward(library(), device, "base_mat")
    with pytest.raises(InputError, match="did you mean 'base_map'"):
        library().pipeline(device, "swatch", "shadow", frozenset({"base_mat"}))


def test_what_does_not_compile_is_magenta_and_tried_once(device: PickyDevice, folder: Path) -> None:
    edit(folder / "effects/swatch.frag", "vec3 color", "BROKEN vec3 color")
    effects = library(folder)
    with pytest.raises(ShaderError, match=r"swatch\.frag:9:1: syntax error"):
        forward(effects, device)
    count = effects.compiled
    pipeline, error = effects.pipeline_or_magenta(device, "swatch", "forward", frozenset(), (POSITION, UV0))
    assert error is not None
    assert error.where.line == 9
    fragment = device.descs[-1].fragment
    assert fragment is not None
    assert "vec4(1.0, 0.0, 1.0, 1.0)" in fragment.text
    again, _ = effects.pipeline_or_magenta(device, "swatch", "forward", frozenset(), (POSITION, UV0))
    assert again is pipeline
    assert effects.compiled == count + 1


def test_a_broken_vertex_shader_is_stood_in_for(device: PickyDevice, folder: Path) -> None:
    edit(folder / "effects/swatch.vert", "v_uv = a_uv0", "BROKEN")
    pipeline, error = library(folder).pipeline_or_magenta(device, "swatch", "forward", frozenset(), (POSITION, UV0))
    assert error is not None
    assert pipeline is not None
    assert any(Path(file).name == "surface.vert" for file, _ in device.descs[-1].vertex.lines)
    fragment = device.descs[-1].fragment
    assert fragment is not None
    assert Path(fragment.lines[-1][0]).name == "magenta.frag"


def test_a_missing_include_is_magenta_too(device: PickyDevice, folder: Path) -> None:
    edit(folder / "effects/swatch.frag", "lib/mix.glsl", "lib/mxi.glsl")
    effects = library(folder)
    _, error = effects.pipeline_or_magenta(device, "swatch", "forward", frozenset(), (POSITION, UV0))
    assert error is not None
    assert "did you mean 'lib/mix.glsl'" in str(error)
    edit(folder / "effects/swatch.frag", "lib/mxi.glsl", "lib/mix.glsl")
    assert effects.poll() == ["swatch"]
    _, error = effects.pipeline_or_magenta(device, "swatch", "forward", frozenset(), (POSITION, UV0))
    assert error is None


def test_a_missing_include_that_comes_later_is_found(device: PickyDevice, folder: Path) -> None:
    effects = library(folder)
    before = forward(effects, device)
    edit(folder / "effects/swatch.frag", "lib/mix.glsl", "lib/new.glsl")
    assert effects.poll() == []
    (folder / "lib/new.glsl").write_text("vec3 combine(uint mode, vec3 a, vec3 b) { return a; }\n", encoding="utf-8")
    info = (folder / "lib").stat()
    os.utime(folder / "lib", ns=(info.st_atime_ns, info.st_mtime_ns + 1_000_000))
    assert effects.poll() == ["swatch"]
    assert forward(effects, device) is not before


def test_poll_without_changes_does_nothing(device: PickyDevice) -> None:
    effects = library()
    forward(effects, device)
    assert effects.poll() == []
    assert effects.compiled == 1


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("effects/swatch.frag", "m.gain", "2.0 * m.gain"),
        ("effects/swatch.vert", "v_uv = a_uv0", "v_uv = 2.0 * a_uv0"),
        ("lib/mix.glsl", "a + b", "a - b"),
        ("effects/swatch.effect.toml", "max = 8.0", "max = 9.0"),
    ],
)
def test_a_changed_file_gives_a_new_pipeline(device: PickyDevice, folder: Path, file: str, old: str, new: str) -> None:
    effects = library(folder)
    before, effect = forward(effects, device), effects.get("swatch")
    edit(folder / file, old, new)
    assert effects.poll() == ["swatch"]
    assert (effects.get("swatch") is effect) == (not file.endswith(".toml"))
    if not file.endswith(".toml"):
        assert forward(effects, device) is not before
    assert effects.poll() == []
    assert effects.errors == {}


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("effects/swatch.frag", "m.gain", "BROKEN"),
        ("lib/mix.glsl", "a + b", "BROKEN"),
        ("effects/swatch.frag", "lib/mix.glsl", "lib/gone.glsl"),
        ("effects/swatch.effect.toml", "max = 8.0", "mxa = 8.0"),
        ("effects/swatch.effect.toml", "max = 8.0", "max = = 8.0"),
    ],
)
def test_a_bad_change_keeps_the_last_good_pipeline(
    device: PickyDevice, folder: Path, file: str, old: str, new: str
) -> None:
    effects = library(folder)
    before, effect = forward(effects, device), effects.get("swatch")
    edit(folder / file, old, new)
    assert effects.poll() == []
    assert forward(effects, device) is before
    assert effects.get("swatch") is effect
    assert "swatch" in str(effects.errors["swatch"]) or "mix.glsl" in str(effects.errors["swatch"])
    assert effects.poll() == []  # and it is not tried again until something changes
    edit(folder / file, new, old)
    assert effects.poll() == ["swatch"]
    assert effects.errors == {}
    assert effects.pipeline_or_magenta(device, "swatch", "forward", frozenset(), (POSITION, UV0))[1] is None


def test_variants_change_together_or_not_at_all(device: PickyDevice, folder: Path) -> None:
    effects = library(folder)
    plain, textured = forward(effects, device), forward(effects, device, "base_map")
    edit(folder / "effects/swatch.frag", "#if BASE_MAP", "// changed\n#if BASE_MAP\nBROKEN")
    device_render = PickyDevice.render_pipeline

    class OnlyTextured(PickyDevice):
        def render_pipeline(self, desc: RenderPipelineDesc) -> Any:
            if "#define BASE_MAP 0" in desc.vertex.text:
                return NullDevice.render_pipeline(self, desc)
            return device_render(self, desc)

    device.__class__ = OnlyTextured
    assert effects.poll() == []
    assert forward(effects, device) is plain
    assert forward(effects, device, "base_map") is textured


def test_a_child_follows_its_base(device: PickyDevice, folder: Path) -> None:
    effects = library(folder)
    effects.get("glow")
    edit(folder / "effects/swatch.effect.toml", "max = 8.0", "max = 9.0")
    assert effects.poll() == ["glow"]
    assert effects.get("glow").param("gain").max == 9.0


def test_a_deleted_file_keeps_everything(device: PickyDevice, folder: Path) -> None:
    effects = library(folder)
    before = forward(effects, device)
    (folder / "effects/swatch.frag").unlink()
    assert effects.poll() == []
    assert forward(effects, device) is before
    assert "swatch" in effects.errors


def test_a_variant_whose_feature_is_gone_goes(device: PickyDevice, folder: Path) -> None:
    effects = library(folder)
    forward(effects, device)
    forward(effects, device, "alpha_test")
    path = folder / "effects/swatch.effect.toml"
    edit(path, "[features.alpha_test]", "")
    edit(path, 'features = ["alpha_test"]', "features = []")
    assert effects.poll() == ["swatch"]
    assert len(effects.variants()) == 1
    with pytest.raises(InputError):
        forward(effects, device, "alpha_test")


def test_release_lets_go() -> None:
    device, effects = PickyDevice(), library()
    first = forward(effects, device)
    effects.release()
    assert effects.variants() == []
    assert forward(effects, device) is not first


def test_variants_are_explained(device: PickyDevice) -> None:
    effects = library()
    told = FeatureSet({"base_map": "the material has the texture 'base_map'"}, {"relief_map": "no tangent"})
    effects.pipeline(device, "swatch", "forward", told, (POSITION,))
    lines = explain(FrameGraph([]).compile(device, None, (4, 4)), effects.variants())
    assert "  swatch forward: base_map" in lines
    assert "    with base_map: the material has the texture 'base_map'" in lines
    assert "    without relief_map: no tangent" in lines
