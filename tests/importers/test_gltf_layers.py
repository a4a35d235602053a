"""KHR_materials_* layers become features and parameters of `layered`, and come out again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from engine.assets.material import MaterialAsset
from engine.core.findings import Findings
from engine.core.paths import shaders_dir
from engine.materials.library import EffectLibrary
from importers.checks.scene import check_material_numbers
from importers.gltf.layers import LAYERS, SPECULAR_TEXTURES, write_layers
from importers.registry import find_importer
from importers.settings import ImportSettings

PNG = (
    "data:image/png;base64,"
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg=="
)
GIVEN: dict[str, dict[str, Any]] = {
    "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25,
                                "clearcoatTexture": {"index": 0},
                                "clearcoatNormalTexture": {"index": 0, "scale": 0.5}},
    "KHR_materials_sheen": {"sheenColorFactor": [0.5, 0.25, 0.75], "sheenRoughnessFactor": 0.5,
                            "sheenRoughnessTexture": {"index": 0}},
    "KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyRotation": 1.5},
    "KHR_materials_iridescence": {"iridescenceFactor": 0.5, "iridescenceIor": 1.5,
                                  "iridescenceThicknessMaximum": 500.0},
    "KHR_materials_transmission": {"transmissionFactor": 0.75, "transmissionTexture": {"index": 0}},
    "KHR_materials_volume": {"thicknessFactor": 0.5, "attenuationDistance": 2.0, "attenuationColor": [0.5, 1.0, 0.25]},
    "KHR_materials_dispersion": {"dispersion": 5.0},
    "KHR_materials_specular": {"specularColorTexture": {"index": 0}},
}  # fmt: skip


def read(folder: Path, extensions: dict[str, Any]) -> tuple[Any, Any]:
    document = {
        "asset": {"version": "2.0"}, "images": [{"uri": PNG}], "textures": [{"source": 0}],
        "materials": [{"name": "m", "extensions": extensions}],
    }  # fmt: skip
    path = folder / "m.gltf"
    path.write_text(json.dumps(document), encoding="utf-8")
    model = find_importer(path).load(path, ImportSettings())
    return model.materials[0], model.findings


def test_all_layers(tmp_path: Path) -> None:
    material, findings = read(tmp_path, GIVEN)
    asset = material.asset
    assert asset.effect == "layered"
    assert asset.features == ["clearcoat", "sheen", "anisotropy", "iridescence", "transmission", "dispersion"]
    params = asset.params
    assert (params["clearcoat"], params["clearcoat_roughness"], params["clearcoat_normal_scale"]) == (0.5, 0.25, 0.5)
    assert params["sheen_color"] == (0.5, 0.25, 0.75)
    assert (params["anisotropy"], params["anisotropy_rotation"]) == (0.5, 1.5)
    assert (params["iridescence_ior"], params["iridescence_thickness_min"]) == (1.5, 100.0)
    assert (params["thickness"], params["attenuation_distance"]) == (0.5, 2.0)
    roles = {slot: use.role for slot, use in material.images.items()}
    assert roles == {
        "clearcoat_map": "data", "clearcoat_normal_map": "normal", "sheen_roughness_map": "data",
        "transmission_map": "data", "specular_color_map": "color",
    }  # fmt: skip
    assert asset.extensions == {}, "what is drawn is written from the parameters"
    assert not any("kept" in f.message for f in findings)


def test_there_and_back(tmp_path: Path) -> None:
    material, _ = read(tmp_path, GIVEN)
    written = write_layers(material.asset, lambda slot: {"index": 0})
    assert written == GIVEN


@pytest.mark.parametrize(
    ("extensions", "why"),
    [
        ({"KHR_materials_clearcoat": {"clearcoatFactor": 0}}, "strength is 0"),
        ({"KHR_materials_sheen": {}}, "strength is 0"),
        ({"KHR_materials_volume": {"thicknessFactor": 1}}, "without transmission"),
        ({"KHR_materials_unlit": {}, "KHR_materials_clearcoat": {"clearcoatFactor": 1}}, "unlit"),
        ({"KHR_materials_diffuse_transmission": {}}, "not shown yet"),
    ],
)  # fmt: skip
def test_what_shows_nothing_is_kept_and_costs_nothing(tmp_path: Path, extensions: dict[str, Any], why: str) -> None:
    material, findings = read(tmp_path, extensions)
    assert material.asset.effect == "surface"
    kept = [name for name in extensions if name != "KHR_materials_unlit"]
    assert list(material.asset.extensions) == kept
    assert any(why in f.message and "kept" in f.message for f in findings)


def test_values_beyond_their_range_are_told(tmp_path: Path) -> None:
    bad = {"KHR_materials_clearcoat": {"clearcoatFactor": 7, "clearcoatRoughnessFactor": "x"}}
    material, findings = read(tmp_path, bad)
    assert material.asset.params["clearcoat"] == 1.0
    assert material.asset.params["clearcoat_roughness"] == 0.0
    assert len(list(findings)) >= 2


def test_table_fits_the_effect() -> None:
    effect = EffectLibrary([shaders_dir()]).get("layered")
    for layer in LAYERS.values():
        names = [p for p, *_ in layer.numbers.values()] + [p for p, *_ in layer.colors.values()]
        for name, (_, _, least, most) in ((v[0], v) for v in layer.numbers.values()):
            assert (effect.param(name).min, effect.param(name).max) == pytest.approx((least, most), abs=1e-3), name
        assert set(names) <= set(effect.param_by_name)
        assert not layer.feature or layer.feature in effect.features
        assert {slot for slot, _ in layer.textures.values()} <= set(effect.slot_by_name)
    assert {slot for slot, _ in SPECULAR_TEXTURES.values()} <= set(effect.slot_by_name)


def test_check_tells_of_pairs() -> None:
    findings = Findings()
    check_material_numbers(MaterialAsset("m", effect="microfacet", features=["masking_walter"]), "", findings)
    assert [f.code for f in findings if f.code == "material.pairing"] == ["material.pairing"]
