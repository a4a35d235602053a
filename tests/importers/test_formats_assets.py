"""Real files: compressed against plain ones, KTX2 cubes, and there and back through GLB."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from importers.export.glb import glb_bytes
from importers.export.source import load_source
from importers.gltf.reader import load
from importers.registry import find_importer
from importers.settings import ImportSettings
from importers.textures.ktx2 import read_ktx2
from tests.importers.test_export_glb import check_same

SETTINGS = ImportSettings()


def test_draco_engine_is_the_plain_one(shared_assets: Path) -> None:
    pytest.importorskip("DracoPy")
    packed = load(shared_assets / "gltf_assimp" / "draco" / "2CylinderEngine.gltf", SETTINGS)
    plain = load(shared_assets / "gltf" / "2CylinderEngine" / "glTF-Binary" / "2CylinderEngine.glb", SETTINGS)
    assert not packed.findings.has_errors
    for one, two in zip(packed.meshes, plain.meshes, strict=True):
        low, high = (np.asarray(two.streams["position"]).min(0), np.asarray(two.streams["position"]).max(0))
        np.testing.assert_allclose(np.asarray(one.streams["position"]).min(0), low, atol=2e-3 * (high - low).max())
        np.testing.assert_allclose(np.asarray(one.streams["position"]).max(0), high, atol=2e-3 * (high - low).max())


def test_ktx2_cube(shared_assets: Path) -> None:
    data = (shared_assets / "env" / "chinese_garden" / "specular_256.ktx2").read_bytes()
    texture = read_ktx2(data, "specular")
    assert (texture.format, texture.width, texture.layers, texture.mip_count, texture.cube) == (
        "rgba8",
        256,
        6,
        5,
        True,
    )


@pytest.mark.parametrize(
    "name",
    ["CesiumMan/glTF-Binary/CesiumMan.glb", "AnimatedMorphCube/glTF-Binary/AnimatedMorphCube.glb",
     "TextureSettingsTest/glTF-Binary/TextureSettingsTest.glb", "Cameras/glTF-Embedded/Cameras.gltf"],
)  # fmt: skip
def test_there_and_back(shared_assets: Path, tmp_path: Path, name: str) -> None:
    path = shared_assets / "gltf" / name
    if not path.is_file():
        pytest.skip(f"no {name}")
    a = load_source(path, SETTINGS)
    out = tmp_path / path.with_suffix(".glb").name
    out.write_bytes(glb_bytes(a))
    check_same(a, load_source(out, SETTINGS))


def test_ogre_comes_back_from_glb(shared_assets: Path, tmp_path: Path) -> None:
    path = shared_assets / "ogre" / "models" / "robot.mesh"
    model = find_importer(path).load(path, SETTINGS)
    out = tmp_path / "robot.glb"
    out.write_bytes(glb_bytes(load_source(path, SETTINGS)))
    back = load(out, SETTINGS)
    assert [c.name for c in back.clips] == [c.name for c in model.clips]
    for stream in model.meshes[0].layout:
        np.testing.assert_array_equal(model.meshes[0].streams[stream], back.meshes[0].streams[stream])
    for one, two in zip(model.clips, back.clips, strict=True):
        for c, d in zip(one.channels, two.channels, strict=True):
            np.testing.assert_array_equal(c.values, d.values)
