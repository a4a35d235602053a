"""glTF beyond the core: instances, variants, scenes by name, specular-glossiness by texels, extras, kept extensions."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from importers.gltf import spec_gloss
from importers.gltf.reader import load
from importers.model import ImportedModel
from importers.settings import ImportSettings
from importers.textures.image import decode
from tests.support.gltf_builder import GltfBuilder, png, triangle

SETTINGS = ImportSettings()


def read(b: GltfBuilder, folder: Path, **settings: Any) -> ImportedModel:
    return load(b.write_glb(folder / "t.glb"), SETTINGS.replace(**settings))


def test_instances_become_nodes(tmp_path: Path) -> None:
    b = triangle()
    attributes = {
        "TRANSLATION": b.accessor([[1, 2, 3], [4, 5, 6]]), "SCALE": b.accessor([[1, 1, 1], [2, 2, 2]]),
        "ROTATION": b.accessor([[0, 0, 0, 32767], [0, 32767, 0, 0]], "i2", normalized=True),
        "_ID": b.accessor([0, 1]),
    }  # fmt: skip
    b.root["nodes"] = [{"name": "n", "mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}]
    b.root["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    model = read(b, tmp_path)
    assert model.nodes[0].mesh is None
    assert [(n.name, n.parent, n.translation) for n in model.nodes[1:]] == [
        ("n 0", 0, (1, 2, 3)),
        ("n 1", 0, (4, 5, 6)),
    ]
    assert model.nodes[2].scale == (2, 2, 2)
    np.testing.assert_allclose(model.nodes[2].rotation, (0, 1, 0, 0), atol=1e-7)
    assert len(model.meshes) == 1
    assert not model.findings.has_errors
    attributes["SCALE"] = b.accessor([[1, 1, 1]])
    broken = read(b, tmp_path)
    assert broken.findings.has_errors
    assert broken.nodes[0].mesh is not None, "then the mesh appears once"


@pytest.mark.parametrize(("variant", "shown"), [("", 0), ("Night", 1), ("night", 1), ("none", 0)])
def test_variants(tmp_path: Path, variant: str, shown: int) -> None:
    b = triangle()
    for name in ("day", "dark"):
        b.material(name=name)
    mappings = [{"material": 0, "variants": [0]}, {"material": 1, "variants": [1, 7]}]
    b.root["meshes"][0]["primitives"][0] |= {
        "material": 0, "extensions": {"KHR_materials_variants": {"mappings": mappings}}
    }  # fmt: skip
    b.root["extensions"] = {"KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "Night"}]}}
    model = read(b, tmp_path, variant=variant)
    assert model.slots == [[shown]]
    assert model.meshes[0].extras["material_variants"] == {"names": ["day", "Night"], "slots": [[0, 1]]}
    assert any("variant 7 does not exist" in f.message for f in model.findings)
    assert any("there is no variant" in f.message for f in model.findings) == (variant == "none")


@pytest.mark.parametrize(("scene", "names"), [("", ["a"]), ("Second", ["b"]), ("1", ["b"]), ("7", ["a"])])
def test_scene_by_name_or_number(tmp_path: Path, scene: str, names: list[str]) -> None:
    b = triangle()
    b.root["nodes"] = [{"name": "a", "mesh": 0}, {"name": "b", "mesh": 0}]
    b.root["scenes"] = [{"nodes": [0]}, {"nodes": [1], "name": "second"}]
    model = read(b, tmp_path, scene=scene)
    assert [n.name for n in model.nodes] == names
    assert any("there is no scene" in f.message for f in model.findings) == (scene == "7")


def test_the_quadratic_undoes_metal_rough() -> None:
    """A metal/rough surface, written as diffuse and specular by their definition, comes back."""
    base = np.array([[0.8, 0.4, 0.1], [0.2, 0.5, 0.9], [0.6, 0.6, 0.6]])
    metallic = np.array([1.0, 0.0, 0.0])[:, None]
    specular = 0.04 * (1 - metallic) + base * metallic
    diffuse = base * (1 - metallic) * 0.96 / (1 - specular.max(axis=1, keepdims=True))
    got, metal = spec_gloss.convert(diffuse, specular)
    np.testing.assert_allclose(metal, metallic[:, 0], atol=1e-6)
    np.testing.assert_allclose(got, base, atol=1e-6)


def test_specular_glossiness_texel_by_texel(tmp_path: Path) -> None:
    b = triangle()
    pixels = np.zeros((2, 2, 4), np.uint8)
    pixels[:, 0] = (10, 10, 10, 255)  # a dielectric, smooth
    pixels[:, 1] = (255, 200, 100, 51)  # a metal, rough
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    diffuse, gloss = b.texture(png(2, 2, (128, 64, 32))), b.texture(file.getvalue())
    old = {
        "diffuseTexture": {"index": diffuse},
        "specularGlossinessTexture": {"index": gloss},
        "diffuseFactor": [1, 1, 1, 0.5],
    }
    b.material(name="old", extensions={"KHR_materials_pbrSpecularGlossiness": old})
    b.root["meshes"][0]["primitives"][0]["material"] = 0
    model = read(b, tmp_path)
    material = model.materials[0]
    assert (material.asset.params["metallic"], material.asset.params["roughness"]) == (1.0, 1.0)
    assert material.asset.params["base_color"] == (1.0, 1.0, 1.0, 0.5)
    images = [model.images[material.images[slot].image].data() for slot in ("base_color_map", "metal_rough_map")]
    color, rough = (decode(data or b"", "i", SETTINGS) for data in images)
    assert rough[0, 0].tolist() == [0, 0, 0, 255]
    assert rough[0, 1].tolist() == [0, 204, 255, 255]
    assert np.abs(color[0, 0].astype(int) - [128, 64, 32, 255]).max() <= 1
    assert np.abs(color[0, 1].astype(int) - [255, 200, 100, 255]).max() <= 1
    assert any("texel by texel" in f.message for f in model.findings)


def test_extras_are_kept_and_only_our_own_part_is_obeyed(tmp_path: Path) -> None:
    b = triangle()
    b.root["nodes"][0]["extras"] = {
        "tag": 3, "nothing": None, "skin_bind_world": [1] * 16, "lucarna": {"skin_bind_world": ["x"], "other": 1}
    }  # fmt: skip
    b.root["meshes"][0]["extras"] = {"lucarna": {"skinning": "dual_quaternion"}}
    model = read(b, tmp_path)
    assert model.nodes[0].extras == {"tag": 3}
    assert model.meshes[0].extras == {"skinning": "dual_quaternion"}
    assert any(f.code == "gltf.extras" for f in model.findings)


@pytest.mark.parametrize(
    "name",
    ["clearcoat", "sheen", "transmission", "volume", "iridescence", "anisotropy", "dispersion", "diffuse_transmission"],
)
def test_what_is_not_shown_is_kept_and_said(tmp_path: Path, name: str) -> None:
    b = triangle()
    image = b.texture({"uri": "coat.png"})
    extension = f"KHR_materials_{name}"
    b.material(name="m", extensions={extension: {"someFactor": 0.5, "someTexture": {"index": image, "texCoord": 1}}})
    b.root["meshes"][0]["primitives"][0]["material"] = 0
    b.root["extensionsRequired"] = [extension]
    model = read(b, tmp_path)
    kept = model.materials[0].asset.extensions[extension]
    assert kept == {"someFactor": 0.5, "someTexture": {"texCoord": 1, "image": 0, "image_name": "coat.png"}}
    assert any(f.message.startswith(extension) and "kept" in f.message for f in model.findings)
