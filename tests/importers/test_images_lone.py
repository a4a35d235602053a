"""Lone images: pictures, cubes, arrays, environments, and textures that are in GPU formats already."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from engine.assets.dds import read_dds, write_dds
from engine.assets.environment_dds import read_environment
from engine.assets.scene_json import read_scene
from engine.assets.texture import TextureAsset
from engine.core.errors import FormatError, InputError
from engine.report.image import save_exr
from importers.convert import convert
from importers.settings import ImportSettings
from importers.textures.pixels import level_pixels, rgba_pixels, texture_picture
from tests.importers.test_gltf_compressed import ktx2_file

SETTINGS = ImportSettings()


def picture(path: Path, color: tuple[int, ...] = (10, 200, 30), size: tuple[int, int] = (8, 6)) -> Path:
    Image.new("RGB", size, color).save(path)
    return path


def made(path: Path, **settings: object) -> TextureAsset:
    out = path.parent / "out"
    convert(path, out, SETTINGS.replace(**settings))
    return read_dds(out / f"{path.stem}.dds")


@pytest.mark.parametrize(
    ("name", "settings", "format"),
    [
        ("a.png", {}, "bc7-srgb"), ("a_n.tga", {}, "bc5"), ("a_orm.bmp", {}, "bc7"), ("a_ao.jpg", {}, "bc4"),
        ("a.tif", {"role": "mask"}, "bc4"), ("a.webp", {"compress": False}, "rgba8-srgb"),
    ],
)  # fmt: skip
def test_role_by_name_or_setting(tmp_path: Path, name: str, settings: dict[str, object], format: str) -> None:
    texture = made(picture(tmp_path / name), **settings)
    assert (texture.format, texture.width, texture.height, texture.mip_count) == (format, 8, 6, 4)


def test_a_picture_comes_with_a_card(tmp_path: Path) -> None:
    result = convert(picture(tmp_path / "a.png", size=(12, 6)), tmp_path / "out", SETTINGS)
    assert result.scene is not None
    scene = read_scene(result.scene)
    assert scene.nodes[0].mesh is not None
    assert [p.name for p in result.outputs] == ["a.card.material.toml", "a.dds", "a.lmesh", "a.scene.json"]


def test_six_faces_become_a_cube(tmp_path: Path) -> None:
    names = ("right", "left", "top", "bottom", "front", "back")
    for k, name in enumerate(names):
        picture(tmp_path / f"sky_{name}.png", (k * 40, 255 - k * 40, 9), (8, 8))
    texture = made(tmp_path / "sky_left.png", compress=False)
    assert (texture.cube, texture.layers, texture.mip_count) == (True, 6, 4)
    assert [level_pixels(texture, k)[0, 0, 0] for k in range(6)] == [k * 40 for k in range(6)]
    picture(tmp_path / "sky_back.png", size=(4, 4))
    with pytest.raises(FormatError, match="is 4x4"):
        made(tmp_path / "sky_left.png")
    (tmp_path / "sky_back.png").unlink()
    assert not made(tmp_path / "sky_left.png").cube, "five faces are five pictures"


def test_numbered_files_become_an_array_when_asked(tmp_path: Path) -> None:
    for k in (0, 1, 10):
        picture(tmp_path / f"tile_{k}.png", (k * 20, 0, 0))
    texture = made(tmp_path / "tile_1.png", image_as="array", compress=False)
    assert [level_pixels(texture, k)[0, 0, 0] for k in range(texture.layers)] == [0, 20, 200]
    assert not texture.cube
    with pytest.raises(InputError, match="numbered"):
        made(picture(tmp_path / "plain.png"), image_as="array")


def test_panorama_to_cube_and_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importers.textures.environment.SIZE", 16)
    image = np.zeros((16, 32, 3), np.float32)
    image[:8] = (0.25, 0.5, 4.0)  # the upper half
    save_exr(tmp_path / "sky.exr", image)
    convert(tmp_path / "sky.exr", tmp_path / "env", SETTINGS.replace(image_as="environment"))
    cube, sh9 = read_environment(tmp_path / "env" / "sky.dds")
    up = np.frombuffer(cube.levels[2][0], "<f2").reshape(cube.width, cube.width, 4)
    np.testing.assert_allclose(up[cube.width // 2, cube.width // 2, :3], (0.25, 0.5, 4.0), rtol=2e-3)
    np.testing.assert_allclose(sh9[0] * 0.282095, np.array([0.25, 0.5, 4.0]) / 2, rtol=0.05)
    flat = picture(tmp_path / "pan.png", (188, 188, 188), (32, 16))
    texture = made(flat, image_as="cube", compress=False)
    assert (texture.cube, texture.width) == (True, 8)
    assert set(level_pixels(texture, 3)[..., 0].ravel().tolist()) == {188}
    with pytest.raises(InputError, match="no panorama"):
        made(picture(tmp_path / "b.png", size=(7, 7)), image_as="cube")


def test_stored_textures_pass_through(tmp_path: Path) -> None:
    blocks = [bytes(range(64)), bytes(range(16)), bytes(range(16)), bytes(range(16))]
    original = TextureAsset("bc7", 8, 8, [blocks] * 6, cube=True)
    write_dds(tmp_path / "c.dds", original)
    same = made(tmp_path / "c.dds")
    assert (same.format, same.cube, [bytes(x) for x in same.levels[4]]) == ("bc7", True, blocks)
    small = made(tmp_path / "c.dds", max_texture_size=4)
    assert (small.width, small.mip_count, bytes(small.levels[0][0])) == (4, 3, blocks[1])
    (tmp_path / "k.ktx2").write_bytes(ktx2_file(145, 8, 8, [bytes(range(64))]))
    assert bytes(made(tmp_path / "k.ktx2").levels[0][0]) == bytes(range(64))
    write_dds(tmp_path / "f.dds", TextureAsset("rgba32f", 2, 1, [[np.arange(8, dtype="<f4").tobytes()]]))
    assert (made(tmp_path / "f.dds").format, made(tmp_path / "f.dds").width) == ("rgba32f", 2)
    (tmp_path / "p.ktx2").write_bytes(ktx2_file(43, 4, 4, [bytes([9, 8, 7, 255]) * 16]))
    assert made(tmp_path / "p.ktx2").format == "bc7-srgb", "plain pixels are encoded"


def test_textures_back_to_pixels(tmp_path: Path) -> None:
    from importers.textures.encode import encode

    rng = np.random.default_rng(1)
    smooth = np.repeat(np.repeat(rng.integers(60, 200, (2, 3, 4), np.uint8), 4, 0), 4, 1)
    smooth[..., 3] = 255
    for role, channels, error in (("color", 4, 3), ("metal_rough", 4, 3), ("mask", 1, 2)):
        back = rgba_pixels(encode(smooth, role, SETTINGS))
        assert np.abs(back[..., : min(channels, 3)].astype(int) - smooth[..., : min(channels, 3)]).max() <= error
    vectors = np.full((4, 4, 4), 255, np.uint8)
    vectors[..., :3] = (180, 90, 240)
    write_dds(tmp_path / "n.dds", encode(vectors, "normal", SETTINGS))
    from importers.textures.image import decode

    x, y, z, _ = decode(texture_picture(tmp_path / "n.dds", True), "n", SETTINGS)[0, 0] / 127.5 - 1
    assert abs(x * x + y * y + z * z - 1) < 0.02
    assert z > 0.8
    with pytest.raises(FormatError, match="BC6H"):
        level_pixels(TextureAsset("bc6h", 4, 4, [[bytes(16)]]))


def test_toksvig_widens_where_normals_cancel() -> None:
    from importers.textures.toksvig import rougher

    flat = np.zeros((4, 4, 3), np.float32)
    flat[..., 2] = 1
    mip = np.full((2, 2, 4), 0.5, np.float32)
    np.testing.assert_allclose(rougher(mip, flat), mip)
    bent = flat.copy()
    bent[:, ::2] = (np.sin(0.3), 0, np.cos(0.3))
    bent[:, 1::2] = (-np.sin(0.3), 0, np.cos(0.3))
    length = np.cos(0.3)
    wanted = (0.5**4 + 2 * (1 - length) / length) ** 0.25
    np.testing.assert_allclose(rougher(mip, bent)[..., 1], wanted, rtol=1e-5)
    np.testing.assert_array_equal(rougher(mip, bent)[..., [0, 2, 3]], mip[..., [0, 2, 3]])
