"""Effect files: what they give, what `extends` merges, and every mistake with its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.core.errors import InputError, ShaderError, UsageError
from engine.core.paths import shaders_dir
from engine.gpu.types import DepthState
from engine.materials.effect import BLENDS, Effect, load_effect

DATA = Path(__file__).parent / "data"


def swatch() -> Effect:
    return load_effect(DATA / "effects" / "swatch.effect.toml")


def write(folder: Path, text: str, name: str = "x") -> Path:
    path = folder / f"{name}.effect.toml"
    path.write_text(text, encoding="utf-8")
    return path


def failure(folder: Path, text: str) -> str:
    with pytest.raises(ShaderError) as caught:
        load_effect(write(folder, text))
    return str(caught.value).replace(str(folder) + "/", "")


def test_everything_declared_is_there_in_order() -> None:
    effect = swatch()
    assert list(effect.features) == ["base_map", "relief_map", "vertex_color", "alpha_test"]
    assert effect.features["relief_map"].needs == ("tangent",)
    assert [p.name for p in effect.params] == ["gain", "tint", "mode", "flip", "shift"]
    assert effect.param("mode").choices == ("multiply", "add")
    assert [(s.name, s.unit, s.space, s.default) for s in effect.textures] == [
        ("base_map", 0, "srgb", "white"),
        ("relief_map", 1, "normal", "flat_normal"),
    ]
    assert effect.technique("forward").depth == DepthState()
    assert effect.technique("shadow").depth == DepthState(bias_slope=-1.5)
    assert effect.technique("shadow").fragment == ""


def test_names_that_are_not_there() -> None:
    with pytest.raises(InputError, match="did you mean 'forward'"):
        swatch().technique("forwrad")
    with pytest.raises(UsageError, match="did you mean 'gain'"):
        swatch().param("gian")
    with pytest.raises(InputError, match="did you mean 'base_map'"):
        swatch().check_features(frozenset({"base_mpa"}))


def test_extends_merges_tables() -> None:
    glow = load_effect(DATA / "effects" / "glow.effect.toml")
    assert [p.name for p in glow.params] == ["gain", "tint", "mode", "flip", "shift", "halo"]
    assert glow.param("gain").default == 4.0
    assert glow.param("gain").max == 8.0
    assert glow.technique("forward").blend == "additive"
    assert glow.technique("forward").vertex == "effects/swatch.vert"
    assert not glow.technique("forward").depth.write
    assert glow.doc == ""
    assert [file.name for file in glow.files] == ["glow.effect.toml", "swatch.effect.toml"]
    assert glow.source_hash != swatch().source_hash


def test_macros_are_always_defined() -> None:
    effect = swatch()
    macros = effect.defines("shadow", frozenset({"alpha_test", "uv1"}), ["position", "uv0"])
    assert macros["ALPHA_TEST"] == 1
    assert macros["BASE_MAP"] == 0
    assert macros["UV1"] == 1
    assert macros["UV_TRANSFORM"] == 0
    assert macros["ROLE_SHADOW"] == 1
    assert macros["ROLE_FORWARD"] == 0
    assert macros["HAS_UV0"] == 1
    assert macros["HAS_TANGENT"] == 0


def test_only_features_that_matter_in_the_role_are_active() -> None:
    effect = swatch()
    wanted = frozenset({"alpha_test", "base_map"})
    assert effect.active("forward", wanted) == wanted
    assert effect.active("shadow", wanted) == {"alpha_test"}


def test_row_layout_is_std430() -> None:
    layout = swatch().row_layout
    # gain 0, tint (vec3) at 16, mode 28, flip 32, shift 40, then two slots of 4 + 4 + 16 + 16 from 48
    names = ["gain", "tint", "mode", "flip", "shift", "base_map_layer", "base_map_uv", "base_map_row0", "base_map_row1"]
    assert [layout.offset(n) for n in names] == [0, 16, 28, 32, 40, 48, 52, 64, 80]
    assert layout.size == 144


def test_generated_text() -> None:
    effect = swatch()
    plain = effect.glsl(frozenset())
    assert "layout(binding = 1) uniform sampler2DArray t_relief_map;" in plain
    assert "uv1 : uv0" not in plain
    assert "within_quad" not in plain
    full = effect.glsl(frozenset({"uv1", "uv_transform"}))
    assert "within_quad(vec4(m.base_map_uv == 1u ? 1.0 : 0.0))" in full
    assert "dot(within_quad(m.base_map_row0).xyz, p)" in full


def test_an_effect_without_anything_still_has_a_row(tmp_path: Path) -> None:
    effect = load_effect(write(tmp_path, 'name = "x"\n'))
    assert effect.row_layout.size >= 4


def test_unknown_key_with_place_caret_and_suggestion(tmp_path: Path) -> None:
    text = failure(tmp_path, 'name = "x"\n[technique.forward]\nvertex = "a"\ndetph = { test = true }\n')
    assert text.startswith("x.effect.toml:4:1: unknown key 'detph' in technique.forward (did you mean 'depth'?)")
    assert text.endswith("    detph = { test = true }\n    ^")


def test_all_mistakes_are_collected(tmp_path: Path) -> None:
    text = failure(
        tmp_path,
        'name = "x"\nfoo = 1\n[params.a]\ntype = "flaot"\ndefault = 1.0\n[params.b]\ndefault = 1.0\n'
        '[technique.forward]\nvertex = "v"\ndepth = { compare = "gequel" }\nraster = 3\n',
    )
    assert text.startswith("x.effect.toml: 5 mistakes")
    assert "x.effect.toml:2:1: unknown key 'foo'" in text
    assert "x.effect.toml:4:8: params.a.type: 'flaot' is not a choice (did you mean 'float'?)" in text
    assert "x.effect.toml:6:1: the key 'type' is missing in params.b" in text
    assert "x.effect.toml:10:21: technique.forward.depth.compare: 'gequel' is not a choice" in text
    assert "x.effect.toml:11:10: technique.forward.raster: expected a table, got 3" in text


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ('name = "y"', "1:8", "the name 'y' is not that of the file, 'x'"),
        ('name = "x"\n[features.a]\nimplied_by = "b_map"\n[textures.a_map]', "3:14", "did you mean 'a_map'"),
        ('name = "x"\n[features.a]\nneeds = ["uv0", "tangnet"]', "3:17", "did you mean 'tangent'"),
        ('name = "x"\n[params.a]\ntype = "float"\ndefault = 2.0\nmax = 1.0', "4:11", "outside [-inf, 1]"),
        ('name = "x"\n[params.a]\ntype = "color3"\ndefault = [1.0]', "4:11", "expected 3 number(s)"),
        ('name = "x"\n[params.a]\ntype = "float"\ndefault = 2.0\nmin = 3.0\nmax = 1.0', "5:7", "min 3 is above max 1"),
        ('name = "x"\n[params.a]\ntype = "enum"\ndefault = "b"', "2:1", "an enum without choices"),
        ('name = "x"\n[params.a]\ntype = "float"\nchoices = ["b"]\ndefault = 0', "4:1", "only an enum has choices"),
        ('name = "x"\n[params.Size]\ntype = "float"\ndefault = 0', "2:1", "cannot be a name in a shader"),
        ('name = "x"\n[params.float]\ntype = "float"\ndefault = 0', "2:1", "cannot be a name in a shader"),
        ('name = "x"\n[params.a_uv]\ntype = "uint"\ndefault = 0\n[textures.a]', "2:1", "is also a generated field"),
        (
            'name = "x"\n[features.ab]\n[technique.forward]\nvertex = "v"\nfeatures = ["ba"]',
            "5:13", "there is no feature 'ba'",
        ),
        ('name = "x"\nextends = "nothing"', "2:11", "extends 'nothing', which is not there"),
        ('name = "x"\nextends = "x"', "2:11", "break the circle"),
    ],
)  # fmt: skip
def test_what_makes_no_sense(tmp_path: Path, text: str, place: str, message: str) -> None:
    found = failure(tmp_path, text)
    assert found.startswith(f"x.effect.toml:{place}: ")
    assert message in found
    assert "^" in found


def test_a_mistake_in_the_base_points_to_the_base(tmp_path: Path) -> None:
    write(tmp_path, 'name = "base"\n\n[params.a]\ntype = "float"\ndefault = 0.0\nmxa = 3.0\n', "base")
    text = failure(tmp_path, 'name = "x"\nextends = "base"\n[params.a]\ndefault = 1.0\n')
    assert text.startswith("base.effect.toml:6:1: unknown key 'mxa' in params.a")


def test_blends_are_what_their_names_say() -> None:
    assert BLENDS["opaque"] is None
    premultiplied, additive = BLENDS["premultiplied"], BLENDS["additive"]
    assert premultiplied is not None
    assert (premultiplied.src, premultiplied.dst) == ("one", "one_minus_src_alpha")
    assert additive is not None
    assert (additive.src, additive.dst) == ("one", "one")


def test_every_effect_of_the_product_loads() -> None:
    files = sorted((shaders_dir() / "effects").glob("*.effect.toml"))
    assert files
    for file in files:
        assert load_effect(file, search=[shaders_dir()]).techniques
