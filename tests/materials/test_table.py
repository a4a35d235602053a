"""MaterialTable: rows, checked values, dirty ranges, growth, migration; the uv transform's known answers."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from engine.assets.material import MaterialAsset, TextureRef
from engine.core.errors import InputError, UsageError
from engine.materials.effect import load_effect
from engine.materials.table import MaterialTable, uv_rows

EFFECTS = Path(__file__).parent / "data" / "effects"
EFFECT = load_effect(EFFECTS / "swatch.effect.toml")


def transformed(ref: TextureRef, u: float, v: float) -> tuple[float, float]:
    row0, row1 = uv_rows(ref)
    return row0[0] * u + row0[1] * v + row0[2], row1[0] * u + row1[1] * v + row1[2]


def test_a_row_holds_params_layers_and_uv() -> None:
    table = MaterialTable(EFFECT)
    material = MaterialAsset(
        "m",
        params={"gain": 2, "tint": [0.1, 0.2, 0.3], "mode": "add", "flip": True},
        textures={"base_map": TextureRef("a", uv_set=1, offset=(0.25, 0.5))},
    )
    index = table.add(material, {"base_map": 7})
    row = table.rows[index]
    assert row["gain"] == 2.0
    np.testing.assert_array_equal(row["tint"], np.array([0.1, 0.2, 0.3], np.float32))
    assert (row["mode"], row["flip"]) == (1, 1)
    np.testing.assert_array_equal(row["shift"], [0.0, 0.0])  # the default
    assert (row["base_map_layer"], row["base_map_uv"]) == (7, 1)
    np.testing.assert_array_equal(row["base_map_row0"], [1.0, 0.0, 0.25, 0.0])
    np.testing.assert_array_equal(row["base_map_row1"], [0.0, 1.0, 0.5, 0.0])
    np.testing.assert_array_equal(row["relief_map_row0"], [1.0, 0.0, 0.0, 0.0])
    assert table.rows.flags.c_contiguous


def test_values_come_back() -> None:
    table = MaterialTable(EFFECT)
    row = table.add(MaterialAsset("m"), {})
    assert table.get_param(row, "mode") == "multiply"
    assert table.get_param(row, "flip") is False
    table.set_param(row, "tint", "0.5 0.25 1")
    assert table.get_param(row, "tint") == (0.5, 0.25, 1.0)
    table.set_param(row, "mode", "add")
    assert table.get_param(row, "mode") == "add"
    assert table.get_param(row, "gain") == 1.0


def test_bad_values_change_nothing() -> None:
    table = MaterialTable(EFFECT)
    row = table.add(MaterialAsset("m"), {})
    rev = table.rev
    for name, value, message in [
        ("gain", 9.0, r"outside \[0, 8\]"),
        ("gian", 1.0, "did you mean 'gain'"),
        ("mode", "mulitply", "did you mean 'multiply'"),
        ("tint", [1.0, 2.0], "expected 3"),
        ("gain", math.nan, "finite"),
    ]:
        with pytest.raises(UsageError, match=message):
            table.set_param(row, name, value)
    with pytest.raises(UsageError, match="row 1"):
        table.set_param(1, "gain", 1.0)
    assert table.rev == rev
    assert table.get_param(row, "gain") == 1.0


def test_all_mistakes_of_a_material_at_once() -> None:
    material = MaterialAsset("m", params={"gian": 1.0, "gain": -1.0}, textures={"base": TextureRef("a")})
    table = MaterialTable(EFFECT)
    with pytest.raises(InputError) as caught:
        table.add(material, {})
    for words in ("'gian'", "outside", "unknown texture 'base' (did you mean 'base_map'?)"):
        assert words in str(caught.value)
    assert len(table) == 0


def test_it_grows_and_keeps_its_rows() -> None:
    table = MaterialTable(EFFECT)
    for index in range(100):
        assert table.add(MaterialAsset(f"m{index}", params={"gain": index / 100}), {}) == index
    np.testing.assert_allclose(table.rows["gain"], np.arange(100) / 100, rtol=1e-6)


def test_dirty_range_and_rev() -> None:
    table = MaterialTable(EFFECT)
    for index in range(5):
        table.add(MaterialAsset(f"m{index}"), {})
    assert table.dirty == (0, 5)
    table.clean()
    assert table.dirty is None
    rev = table.rev
    table.set_param(3, "gain", 2.0)
    table.set_texture(1, "base_map", TextureRef("b", rotation=math.pi / 2), 4)
    assert table.dirty == (1, 4)
    assert table.rev == rev + 2
    assert table.rows[1]["base_map_layer"] == 4


def test_migrate_keeps_what_still_means_the_same() -> None:
    table = MaterialTable(EFFECT)
    table.add(MaterialAsset("m", params={"gain": 3.0, "mode": "add"}), {"base_map": 2})
    moved = table.migrate(load_effect(EFFECTS / "glow.effect.toml"))
    assert moved.get_param(0, "gain") == 3.0
    assert moved.get_param(0, "mode") == "add"
    assert moved.get_param(0, "halo") == 0.5
    assert moved.rows[0]["base_map_layer"] == 2
    assert moved.dirty == (0, 1)
    assert moved.rev > table.rev


def test_khr_texture_transform_examples() -> None:
    # KHR_texture_transform, first example: the lower left quadrant of the image, rotated clockwise by 90 degrees
    ref = TextureRef("a", offset=(0.0, 1.0), rotation=math.pi / 2, scale=(0.5, 0.5))
    for (u, v), expected in [((0, 0), (0.0, 1.0)), ((1, 0), (0.0, 0.5)), ((0, 1), (0.5, 1.0)), ((1, 1), (0.5, 0.5))]:
        assert transformed(ref, u, v) == pytest.approx(expected)
    # second example: v counted from the bottom
    flipped = TextureRef("a", offset=(0.0, 1.0), scale=(1.0, -1.0))
    assert transformed(flipped, 0.25, 0.25) == pytest.approx((0.25, 0.75))


def test_scale_comes_before_rotation() -> None:
    ref = TextureRef("a", rotation=math.pi / 2, scale=(2.0, 3.0))
    assert transformed(ref, 1.0, 0.0) == pytest.approx((0.0, -2.0))
    assert transformed(ref, 0.0, 1.0) == pytest.approx((3.0, 0.0))
