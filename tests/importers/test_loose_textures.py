"""Loose textures beside a model: found by name, explained, overridden; and materials as settings want them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.assets.dds import read_dds
from importers.convert import convert
from importers.model import ImportedModel
from importers.registry import find_importer
from importers.settings import ImportSettings
from importers.textures.image import decode
from importers.textures.pixels import level_pixels
from importers.textures.png import png_bytes
from tests.support.gltf_builder import png, triangle

SETTINGS = ImportSettings()


def model_in(
    folder: Path, settings: ImportSettings = SETTINGS, materials: tuple[str, ...] = ("Mat_Wood",)
) -> ImportedModel:
    b = triangle()
    for name in materials:
        b.material(name=name, pbrMetallicRoughness={"baseColorFactor": [0.5, 0.5, 0.5, 0.25], "metallicFactor": 0.0})
    b.root["meshes"][0]["primitives"][0]["material"] = 0
    path = b.write_glb(folder / "crate.glb")
    return find_importer(path).load(path, settings)


def put(folder: Path, *names: str) -> None:
    folder.mkdir(exist_ok=True)
    for k, name in enumerate(names):
        (folder / name).write_bytes(png(4, 4, (40 + 20 * k, 100, 200)))


def said(model: ImportedModel) -> list[str]:
    return [f.message for f in model.findings if f.code == "materials.guess"]


def test_a_set_named_as_the_material(tmp_path: Path) -> None:
    put(tmp_path / "textures", "wood_albedo.png", "wood_n.png", "wood_r.png", "wood_m.png", "wood_ao.png", "wood_e.png",
        "wood_height.png", "stone_albedo.png")  # fmt: skip
    model = model_in(tmp_path)
    material = model.materials[0]
    assert set(material.images) == {
        "base_color_map", "normal_map", "metal_rough_map", "occlusion_map", "emissive_map"
    }  # fmt: skip
    assert material.asset.params["base_color"] == (1.0, 1.0, 1.0, 0.25)
    assert (material.asset.params["metallic"], material.asset.params["roughness"]) == (1.0, 1.0)
    assert "tangent" in model.meshes[0].streams, "a normal map found late still gets its tangents"
    packed = model.images[material.images["metal_rough_map"].image].data()
    assert packed is not None
    assert decode(packed, "p", SETTINGS)[0, 0].tolist() == [255, 80, 100, 255]
    assert any("base_color_map = wood_albedo.png: named as the material" in text for text in said(model))
    assert any("wood_height.png holds height" in text for text in said(model))
    assert {p.name for p in model.dependencies} >= {"wood_albedo.png", "wood_r.png", "wood_m.png"}


@pytest.mark.parametrize(
    ("files", "materials", "reason"),
    [
        (("crate_BaseColor.png", "other_color.png"), ("x",), "named as the file"),
        (("anything_d.png",), ("x",), "the only set"),
        (("anything_d.png",), ("x", "y"), ""),
        (("crate_d.png",), ("x", "y"), ""),
        (("picture.png", "wood.png"), ("wood",), ""),
    ],
)
def test_reasons(tmp_path: Path, files: tuple[str, ...], materials: tuple[str, ...], reason: str) -> None:
    put(tmp_path, *files)
    model = model_in(tmp_path, materials=materials)
    assert bool(model.materials[0].images) == bool(reason)
    assert not reason or any(reason in text for text in said(model))


def test_not_when_it_is_switched_off(tmp_path: Path) -> None:
    put(tmp_path, "wood_d.png")
    assert not model_in(tmp_path, SETTINGS.replace(loose_textures=False)).materials[0].images


def test_orm_serves_two_slots_and_directx_normals_are_turned(tmp_path: Path) -> None:
    put(tmp_path, "wood_ORM.png")
    (tmp_path / "wood_NormalDX.png").write_bytes(png(4, 4, (128, 228, 200)))
    model = model_in(tmp_path)
    images = model.materials[0].images
    assert images["metal_rough_map"].image == images["occlusion_map"].image
    result = convert(tmp_path / "crate.glb", tmp_path / "out", SETTINGS.replace(compress=False))
    normal = next(p for p in result.outputs if "NormalDX" in p.name)
    x, y = np.frombuffer(read_dds(normal).levels[0][0], np.uint8)[:2]
    assert abs(int(x) - 128) <= 1
    assert y < 60, "green pointed down and now points up"


def test_settings_have_the_last_word(tmp_path: Path) -> None:
    put(tmp_path, "wood_d.png", "wood_r.png", "own.png")
    table = {
        "mat_wood": {"base_color_map": "own.png", "metal_rough_map": False, "roughness": 0.2, "emissive": [1, 0, 0]}
    }
    model = model_in(tmp_path, SETTINGS.replace(materials=table))
    material = model.materials[0]
    assert model.images[material.images["base_color_map"].image].name == "own"
    assert "metal_rough_map" not in material.images
    assert (material.asset.params["roughness"], material.asset.params["emissive"]) == (0.2, (1, 0, 0))
    bad = {"mat_wood": {"base_color_map": "../secret.png", "normal_map": "none.png", "queue": "what"}}
    codes = [f.code for f in model_in(tmp_path, SETTINGS.replace(materials=bad)).findings]
    assert codes.count("materials.image") == 2
    assert codes.count("materials.setting") == 1


def test_settings_of_one_image(tmp_path: Path) -> None:
    b = triangle()
    (tmp_path / "skin.png").write_bytes(png(16, 16))
    color = b.texture({"uri": "skin.png"})
    b.material(name="m", pbrMetallicRoughness={"baseColorTexture": {"index": color}})
    b.root["meshes"][0]["primitives"][0]["material"] = 0
    path = b.write_gltf(tmp_path / "t.gltf")
    settings = SETTINGS.replace(textures={"skin.png": {"role": "data", "max_texture_size": 8}})
    result = convert(path, tmp_path / "out", settings)
    texture = read_dds(next(p for p in result.outputs if p.suffix == ".dds"))
    assert (texture.format, texture.width) == ("bc7", 8)
    told = convert(path, tmp_path / "out1", SETTINGS.replace(textures={"skim.png": {}}, materials={"n": {}}))
    assert [f.code for f in told.findings].count("settings.unmatched") == 2
    from engine.core.errors import UsageError

    with pytest.raises(UsageError, match="rolle"):
        convert(path, tmp_path / "out2", SETTINGS.replace(textures={"skin.png": {"rolle": "data"}}))


def test_roughness_makes_up_for_bumps(tmp_path: Path) -> None:
    bumps = np.zeros((8, 8, 3), np.uint8)
    bumps[:, ::2], bumps[:, 1::2] = (200, 128, 230), (55, 128, 230)
    (tmp_path / "wood_n.png").write_bytes(png_bytes(bumps))
    (tmp_path / "wood_orm.png").write_bytes(png(8, 8, (255, 30, 0)))
    model_in(tmp_path)
    greens = []
    for on in (False, True):
        settings = SETTINGS.replace(compress=False, roughness_from_normals=on)
        result = convert(tmp_path / "crate.glb", tmp_path / f"out{on}", settings)
        texture = read_dds(next(p for p in result.outputs if "orm" in p.name and "metal_rough" in p.name))
        greens.append([int(level_pixels(texture, 0, k)[0, 0, 1]) for k in range(texture.mip_count)])
    assert greens[0] == [30] * 4
    assert greens[1][0] == 30, "mip 0 shows the bumps themselves"
    assert min(greens[1][1:]) > 150


def test_what_the_settings_say_is_no_guess_and_no_mistake(tmp_path: Path) -> None:
    put(tmp_path, "wood_d.png", "wood_r.png")
    table = {"mat_wood": {"metal_rough_map": False, "rugness": 0.2, "roughness": -3.0, "metallic": 1}}
    model = model_in(tmp_path, SETTINGS.replace(materials=table))
    guesses = [f.message for f in model.findings if f.code == "materials.guess"]
    assert len(guesses) == 1
    assert guesses[0].startswith("base_color_map = ")
    wrong = [f.message for f in model.findings if f.code == "materials.setting"]
    assert len(wrong) == 2
    assert "did you mean 'roughness'?" in wrong[0]
    assert "rugness" not in model.materials[0].asset.params
    assert model.materials[0].asset.params["metallic"] == 1
