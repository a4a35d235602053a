"""The PBR materials of 3ds Max, Maya and Blender, as real files hold them: which maps and values come out."""

from __future__ import annotations

from pathlib import Path

import pytest

from importers.fbx.reader import load
from importers.settings import ImportSettings

FULL = {"base_color_map", "metal_rough_map", "emissive_map", "normal_map", "occlusion_map"}
BOTH = {"roughness": 1.0, "metallic": 1.0}
#: the values of the scene that the files were made from
CASES = {
    "max_gltf_material_7700_binary": (FULL, {"roughness": 0.06, "metallic": 0.05, "ior": 1.33, "specular": 0.21}),
    "max_openpbr_material_7700_ascii": (FULL - {"occlusion_map"}, BOTH | {"ior": 1.3, "emissive_strength": 3.3}),
    "max_pbr_metal_rough_material_7700_ascii": (FULL, BOTH),
    "max_pbr_spec_gloss_material_7700_ascii": (FULL, {"metallic": 0.0}),
    "max_physical_material_textures_7500_ascii": (FULL - {"occlusion_map"}, BOTH | {"ior": 1.52}),
    "maya_shaderfx_pbs_material_7700_ascii": ({"base_color_map", "metal_rough_map", "emissive_map"}, {"metallic": 1.0}),
    "blender_293_embedded_textures_7400_binary": ({"base_color_map", "metal_rough_map", "emissive_map"}, {}),
}
ROLES = {"base_color_map": "color", "emissive_map": "color", "metal_rough_map": "metal_rough", "normal_map": "normal",
         "occlusion_map": "occlusion"}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_maps_and_values(name: str, shared_assets: Path) -> None:
    slots, params = CASES[name]
    model = load(shared_assets / "fbx_ufbx" / f"{name}.fbx", ImportSettings())
    material = model.materials[0]
    assert set(material.images) == slots
    for slot, use in material.images.items():
        assert use.role == ROLES[slot]
        data = model.images[use.image].data()
        assert data is not None
        assert data.startswith((b"\x89PNG", b"\xff\xd8"))
    assert {key: material.asset.params[key] for key in params} == pytest.approx(params, rel=1e-4)


def test_vertex_colours(shared_assets: Path) -> None:
    model = load(shared_assets / "fbx_ufbx" / "zbrush_vertex_color_7500_ascii.fbx", ImportSettings())
    colors = model.meshes[0].streams["color"]
    assert len({tuple(row) for row in colors.tolist()}) > 1
