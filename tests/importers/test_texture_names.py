"""File names of textures: what they say, and what they do not."""

from __future__ import annotations

import pytest

from importers.texture_names import face_of, plain, read_name


@pytest.mark.parametrize(
    ("stem", "base", "role"),
    [
        ("wood_albedo", "wood", "color"), ("Wood_BaseColor", "wood", "color"), ("wood_base_color_2k", "wood", "color"),
        ("WoodFloorDiffuse", "wood floor", "color"), ("wall_brick_d", "wall brick", "color"),
        ("wood_n", "wood", "normal"), ("rock_NormalGL_4K", "rock", "normal"), ("rock_nor_gl_1k", "rock", "normal"),
        ("rock_NormalDX", "rock", "normal_dx"), ("rock-Normal-DirectX", "rock", "normal_dx"),
        ("a_r", "a", "rough"), ("a_roughness", "a", "rough"), ("a_Glossiness", "a", "gloss"), ("a_m", "a", "metal"),
        ("a_Metallic", "a", "metal"), ("a_orm", "a", "orm"), ("a_arm_2048", "a", "orm"), ("a_ao", "a", "occlusion"),
        ("a_AmbientOcclusion", "a", "occlusion"), ("a_e", "a", "emissive"), ("a_Emissive", "a", "emissive"),
        ("a_height", "a", "height"), ("albedo", "albedo", ""), ("wooden", "wooden", ""), ("Brand", "brand", ""),
        ("world", "world", ""), ("ModelR", "model r", ""), ("floor 01", "floor", ""),
    ],
)  # fmt: skip
def test_suffixes(stem: str, base: str, role: str) -> None:
    found = read_name(stem)
    assert (found.role, found.base if role else base) == (role, base)


@pytest.mark.parametrize(
    ("stem", "wanted"),
    [
        ("sky_px", ("sky", 0)), ("sky_negz", ("sky", 5)), ("sky-left", ("sky", 1)), ("skyTop", None),
        ("night_UP", ("night", 2)), ("sky_+x", ("sky", 0)), ("sky_z-", ("sky", 5)), ("px", ("", 0)),
        ("sky_back", ("sky", 5)), ("sky_rt", ("sky", 0)), ("photo", None),
    ],
)  # fmt: skip
def test_faces(stem: str, wanted: tuple[str, int] | None) -> None:
    assert face_of(stem) == wanted


def test_names_are_compared_without_what_says_nothing() -> None:
    assert plain("Mat_Wood Floor") == plain("wood-floor_material") == plain("M_WoodFloor") == "woodfloor"
