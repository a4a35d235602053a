"""Materials that come from materials: what is inherited, what is written back, where each value is from, and
mistakes."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.assets.material_parent import chain_files
from engine.assets.material_toml import format_material, read_material, update_material, write_material
from engine.core.errors import FormatError

STEEL = """schema = "lucarna.material/1"
name = "steel"
queue = "alpha_test"
features = ["unlit", "double_sided"]
[params]
metallic = 1.0
roughness = 0.2  # polished
base_color = "#ff8000"
[textures.normal_map]
path = "maps/n.dds"
wrap_u = "clamp"
[textures.base_color_map]
path = "maps/c.dds"
"""
WORN = """parent = "base/steel.material.toml"
[params]
roughness = 0.6
[textures]
base_color_map = false
[textures.normal_map]
scale = [2.0, 2.0]
"""
RED = """# the red one
parent = "worn.material.toml"
name = "red"
level = "high"
features = []
[params]
base_color = { srgb = [1.0, 0.0, 0.0, 0.5] }
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "base").mkdir()
    for name, text in {"base/steel": STEEL, "worn": WORN, "red": RED}.items():
        (tmp_path / f"{name}.material.toml").write_text(text, encoding="utf-8")
    return tmp_path


def failure(path: Path, text: str) -> str:
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FormatError) as caught:
        read_material(path)
    return str(caught.value).replace(f"{path.parent}/", "")


def test_a_chain_gives_one_material(folder: Path) -> None:
    red = read_material(folder / "red.material.toml")
    assert (red.name, red.effect, red.queue, red.level) == ("red", "surface", "alpha_test", "high")
    assert red.features == []
    assert red.params["metallic"] == 1.0
    assert red.params["roughness"] == 0.6
    assert red.params["base_color"] == pytest.approx((1.0, 0.0, 0.0, 0.5))
    assert list(red.textures) == ["normal_map"]
    normal = red.textures["normal_map"]
    assert (normal.path, normal.wrap_u, normal.scale) == ("base/maps/n.dds", "clamp", (2.0, 2.0))
    worn = read_material(folder / "worn.material.toml")
    assert worn.name == "worn"
    assert worn.features == ["unlit", "double_sided"]
    # IEC 61966-2-1: 0x80 is 0.2158605
    assert worn.params["base_color"] == pytest.approx((1.0, 0.2158605, 0.0), abs=1e-6)


def test_where_each_value_is_from(folder: Path) -> None:
    red = read_material(folder / "red.material.toml")
    assert [file.name for file in red.files] == [f"{n}.material.toml" for n in ("red", "worn", "steel")]
    origin = {key: file.name.split(".")[0] for key, file in red.origin.items()}
    assert origin == {
        "queue": "steel", "params.metallic": "steel", "params.roughness": "worn", "textures.normal_map.path": "steel",
        "textures.normal_map.wrap_u": "steel", "textures.normal_map.scale": "worn",
    }  # fmt: skip
    assert chain_files(folder / "red.material.toml") == list(red.files)


def test_only_what_is_other_is_written(folder: Path) -> None:
    path = folder / "red.material.toml"
    red = read_material(path)
    write_material(path, red)
    text = path.read_text(encoding="utf-8")
    assert 'parent = "worn.material.toml"' in text
    for inherited in ("roughness", "metallic", "queue", "effect", "normal_map"):
        assert inherited not in text
    assert read_material(path) == red
    red.params["metallic"] = 0.5
    red.textures["normal_map"].wrap_v = "mirror"
    del red.params["roughness"]  # cannot be taken away: it is inherited again
    write_material(path, red)
    assert "metallic = 0.5" in path.read_text(encoding="utf-8")
    again = read_material(path)
    assert again.textures["normal_map"].wrap_v == "mirror"
    assert again.params["roughness"] == 0.6
    red.textures.clear()
    write_material(path, red)
    assert "normal_map = false" in path.read_text(encoding="utf-8")
    assert not read_material(path).textures


def test_without_a_file_all_of_it_is_text(folder: Path) -> None:
    """A copy in the clipboard stands for itself."""
    text = format_material(read_material(folder / "red.material.toml"))
    assert "parent" not in text
    assert "metallic = 1.0" in text


def test_an_edit_of_the_child_keeps_comments_and_the_parent_as_it_is(folder: Path) -> None:
    before = (folder / "base/steel.material.toml").read_bytes()
    path = folder / "red.material.toml"
    red = update_material(path, {"params.roughness": 0.9, "textures.normal_map.wrap_u": "repeat"})
    assert red.params["roughness"] == 0.9
    assert red.textures["normal_map"].wrap_u == "repeat"
    text = path.read_text(encoding="utf-8")
    assert text.startswith("# the red one\nparent")
    assert "metallic" not in text
    assert (folder / "base/steel.material.toml").read_bytes() == before
    assert update_material(path, {"params.roughness": None}).params["roughness"] == 0.6


def test_samplers_that_are_meant_are_kept(tmp_path: Path) -> None:
    """`wrap_u = "repeat"` is the default, but not where the effect's sampler group says otherwise."""
    path = tmp_path / "a.material.toml"
    path.write_text('name = "a"\n[textures.x]\npath = "x.dds"\nwrap_u = "repeat"\nwrap_v = "clamp"\n', encoding="utf-8")
    material = read_material(path)
    assert material.textures["x"].stated == ("wrap_u",)
    write_material(path, material)
    assert 'wrap_u = "repeat"' in path.read_text(encoding="utf-8")
    assert "min_filter" not in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        ('parent = "wron.material.toml"', "x.material.toml:1:10", "the parent 'wron.material.toml' is not there"),
        ('parent = "wron.material.toml"', "x.material.toml:", "did you mean 'worn.material.toml'?"),
        ('parent = "x.material.toml"', "x.material.toml:", "go in a circle: x.material.toml -> x.material.toml"),
        ('parent = "loop.material.toml"', "loop.material.toml:1:10", "go in a circle: x.material.toml -> l"),
        ("parent = 3", "x.material.toml:1:10", "valid string"),
        ('parent = "bad.material.toml"', "bad.material.toml:2:5", "the parent of x.material.toml: "),
        ('parent = "wide.material.toml"', "wide.material.toml:2:9", "expected 'background'"),
        ('parent = "worn.material.toml"\n[params]\nroughness = [[1]]', "x.material.toml:3:13", "is no number"),
        ('parent = "worn.material.toml"\n[textures.occlusion_map]\nuv_set = 1', "x.material.toml:2:1", "key 'path'"),
        ('name = "x"\n[textures]\na_map = false', "x.material.toml:3:9", "false takes an inherited texture away"),
        ('name = "x"\n[params]\nc = "#12345"', "x.material.toml:3:5", "c: '#12345' is no colour: 5 digits"),
        ('name = "x"\n[params]\nc = "#12345g"', "x.material.toml:", "'g' is no hexadecimal digit"),
        ('name = "x"\n[params]\nc = { rgb = [1.0, 0.0, 0.0] }', "x.material.toml:3:5", "a colour's table has one key"),
        ('name = "x"\nlevel = "hihg"', "x.material.toml:", "did you mean 'high'?"),
        ('name = "x"\nparnet = "y"', "x.material.toml:", "did you mean 'parent'?"),
    ],
)  # fmt: skip
def test_mistakes(folder: Path, text: str, place: str, said: str) -> None:
    for name, other in (
        ("loop", 'parent = "x.material.toml"'), ("bad", 'name = "bad"\nnot toml'),
        ("wide", 'name = "w"\nqueue = "opake"'),
    ):  # fmt: skip
        (folder / f"{name}.material.toml").write_text(other, encoding="utf-8")
    message = failure(folder / "x.material.toml", text)
    assert message.startswith(place)
    assert said in message
    assert "^" in message


def test_a_long_chain_ends(tmp_path: Path) -> None:
    for i in range(40):
        (tmp_path / f"m{i}.material.toml").write_text(f'parent = "m{i + 1}.material.toml"\n', encoding="utf-8")
    with pytest.raises(FormatError, match="more than 32 parents"):
        read_material(tmp_path / "m0.material.toml")
