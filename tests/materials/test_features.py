"""Features of a material on a mesh: what switches them on, what drops them, and the reasons."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.assets.material import MaterialAsset, TextureRef
from engine.core.errors import InputError
from engine.materials.effect import load_effect
from engine.materials.features import FeatureSet, resolve_features

EFFECT = load_effect(Path(__file__).parent / "data" / "effects" / "swatch.effect.toml")
MESH = ("position", "normal", "tangent", "uv0", "uv1")


def test_textures_imply_features() -> None:
    found = resolve_features(EFFECT, MaterialAsset("m", textures={"base_map": TextureRef("a.dds")}), MESH)
    assert found == {"base_map"}
    assert found.reasons["base_map"] == "the material has the texture 'base_map'"


def test_a_feature_without_its_streams_is_dropped_with_the_reason() -> None:
    material = MaterialAsset("m", features=["relief_map"], textures={"relief_map": TextureRef("a.dds", uv_set=1)})
    found = resolve_features(EFFECT, material, ("position", "normal", "uv0", "uv1"))
    assert found == frozenset()  # uv1 neither: no texture is read that wants it
    assert found.dropped == {"relief_map": "the material asks for it, but the mesh has no tangent"}


def test_vertex_color_comes_with_the_mesh_and_alpha_test_with_the_queue() -> None:
    found = resolve_features(EFFECT, MaterialAsset("m", queue="alpha_test"), (*MESH, "color"))
    assert found == {"vertex_color", "alpha_test"}
    assert found.reasons["alpha_test"] == "the material's queue is alpha_test"


def test_uv1_only_where_the_mesh_has_it() -> None:
    material = MaterialAsset("m", textures={"base_map": TextureRef("a.dds", uv_set=1)})
    assert resolve_features(EFFECT, material, MESH) == {"base_map", "uv1"}
    without = resolve_features(EFFECT, material, ("position", "normal", "uv0"))
    assert without == {"base_map"}
    assert "the mesh has no uv1" in without.dropped["uv1"]


@pytest.mark.parametrize(
    "ref", [TextureRef("a", offset=(0.5, 0.0)), TextureRef("a", rotation=0.1), TextureRef("a", scale=(1.0, -1.0))]
)
def test_uv_transform(ref: TextureRef) -> None:
    assert resolve_features(EFFECT, MaterialAsset("m", textures={"base_map": ref}), MESH) == {
        "base_map",
        "uv_transform",
    }


def test_unknown_names_are_errors() -> None:
    material = MaterialAsset("m", features=["base_mpa"], textures={"relief": TextureRef("a")})
    with pytest.raises(InputError) as caught:
        resolve_features(EFFECT, material, MESH)
    assert "unknown feature 'base_mpa' (did you mean 'base_map'?)" in str(caught.value)
    assert "unknown texture 'relief' (did you mean 'relief_map'?)" in str(caught.value)


def test_a_feature_set_is_a_frozenset() -> None:
    found = FeatureSet({"a": "because"})
    assert found == frozenset({"a"})
    assert hash(found) == hash(frozenset({"a"}))
    assert {found: 1}[frozenset({"a"})] == 1
