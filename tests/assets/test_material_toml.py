"""Material files: round trip, edits that keep comments, and errors with line, caret and suggestion."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.material_toml import (
    format_material,
    parse_material,
    read_material,
    update_material,
    write_material,
)
from engine.core.errors import FormatError, InputError, LucarnaError


def make_material() -> MaterialAsset:
    return MaterialAsset(
        'st"eel\\\n\x7f☃',
        "surface",
        "alpha_test",
        ["two_sided"],
        {"base_color": (1.0, 0.5, 0.25, 1.0), "roughness": 0.1, "count": 3, "on": True, "mode": "a"},
        {
            "normal_map": TextureRef("n.dds", "clamp", "mirror", "nearest", "nearest", 1, (0.5, 0.0), 0.25, (2.0, 3.0)),
            "odd slot": TextureRef(""),
        },
        {"KHR_materials_sheen": {"sheenColorFactor": [0.1, 1, 2.5], "deep": {"x y": [{"a": True}, "s"]}, "empty": {}}},
    )


def test_round_trip_and_same_bytes(tmp_path: Path) -> None:
    material = make_material()
    write_material(tmp_path / "m.material.toml", material)
    assert read_material(tmp_path / "m.material.toml") == material
    assert format_material(read_material(tmp_path / "m.material.toml")) == format_material(material)


def test_nulls_of_extensions_are_dropped() -> None:
    material = MaterialAsset("m", extensions={"X": {"a": None, "b": [1, None]}, "Y": None})
    assert parse_material(format_material(material), "m").extensions == {"X": {"b": [1]}}


EDITED = """\
# made by hand
name = "a"   # the name

[params]
# polished
roughness = 0.2 # keep me
metallic = 1.0
"""


def test_edits_keep_comments(tmp_path: Path) -> None:
    path = tmp_path / "m.material.toml"
    path.write_text(EDITED)
    material = update_material(
        path,
        {
            "params.roughness": 0.4,
            "params.metallic": None,
            "params.tint": (1.0, 0.0, 0.5),
            "queue": "transparent",
            "textures.normal_map.path": "n.dds",
            "textures.normal_map.scale": (2.0, 2.0),
        },
    )
    text = path.read_text()
    assert "# made by hand\n" in text
    assert "# the name\n" in text
    assert "# polished\nroughness = 0.4 # keep me\n" in text
    assert "metallic" not in text
    assert material == read_material(path)
    assert material.params == {"roughness": 0.4, "tint": (1.0, 0.0, 0.5)}
    assert material.textures["normal_map"].scale == (2.0, 2.0)
    assert material.queue == "transparent"


@pytest.mark.parametrize("changes", [{"queue": "solid"}, {"nme": "b"}, {"name.x": 1}, {"params.roughness.x": 1}])
def test_bad_edits_leave_the_file_alone(tmp_path: Path, changes: dict[str, object]) -> None:
    path = tmp_path / "m.material.toml"
    path.write_text(EDITED)
    with pytest.raises(InputError):
        update_material(path, changes)
    assert path.read_text() == EDITED


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ('name = "a"\nquue = "opaque"\n', 2, 1, "did you mean 'queue'"),
        ('name = "a"\nqueue = "opaqe"\n', 2, 9, "did you mean 'opaque'"),
        ('name = "a"\n[textures.n]\npath = "x"\nwrap_w = "clamp"\n', 4, 1, "did you mean 'wrap_v'"),
        ('name = "a"\n[textures.n]\npath = "x"\nscale = [1, "a"]\n', 4, 13, "number"),
        ('name = "a"\n[textures.n]\npath = "x"\nscale = [1]\n', 4, 9, "at least 2"),
        ('name = "a"\n[textures.n]\nuv_set = 0\n', 2, 1, "'path' is missing"),
        ('name = "a"\n[params]\nok = 1\nbad = nan\n', 4, 7, "not finite"),
        ('name = "a"\n[params]\nbad = [1, "x"]\n', 3, 7, "array of numbers"),
        ('name = "a"\n[params]\nbad = 2020-01-01\n', 3, 7, "no number"),
        ('effect = "a"\n', 1, 1, "'name' is missing"),
        ('schema = "lucarna.material/7"\nname = "a"\n', 1, 10, "lucarna.material/1"),
        ("name = 3\n", 1, 8, "string"),
        ('name = "a\n', 1, 10, "not valid TOML"),
    ],
)
def test_errors_point_at_the_place(text: str, line: int, column: int, message: str) -> None:
    with pytest.raises(FormatError) as info:
        parse_material(text, "m.material.toml")
    assert (info.value.where.line, info.value.where.column) == (line, column)
    assert message in str(info.value)
    shown = str(info.value).splitlines()
    assert shown[1] == "    " + text.split("\n")[line - 1]
    assert shown[2].startswith(" " * (3 + column) + "^")


def test_damaged_text_raises_only_our_errors() -> None:
    good = format_material(make_material())
    rng = random.Random(2)
    for _ in range(400):
        text = list(good)
        for _ in range(rng.randint(1, 3)):
            text[rng.randrange(len(text))] = rng.choice("0129-.,='\"[]{}#\n\\eatn")
        try:
            parse_material("".join(text), "m")
        except LucarnaError:
            continue
