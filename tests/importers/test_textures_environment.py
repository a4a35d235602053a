"""Environments: cube addressing, prefiltering against quadrature, SH, skies, the shipped data and the cache."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.assets.dds import read_dds, write_dds
from engine.assets.environment_dds import read_environment, sun_direction, write_environment
from engine.assets.scene import EnvironmentAsset
from engine.assets.texture import TextureAsset, mip_extent
from engine.core.errors import FormatError, InputError
from engine.core.paths import shaders_dir
from engine.math import ggx, sh
from engine.math.sphere import cube_directions, cube_solid_angles, fibonacci
from importers.textures import procedural
from importers.textures.cube import CubeChain, directions, faces_of, from_equirect
from importers.textures.environment import bake_environment, environment_file, studio_path
from importers.textures.ggx_tables import bake_dfg, lobe
from importers.textures.shipped import STUDIO_SIZE, STUDIO_SMALLEST


def level(cube: TextureAsset, mip: int) -> NDArray[np.float32]:
    n = mip_extent(cube.width, mip)
    faces = [np.frombuffer(cube.levels[f][mip], "<f2").reshape(n, n, 4)[..., :3] for f in range(6)]
    return np.stack(faces).astype(np.float32)


def test_directions_are_the_engines_and_look_up_inverts_them() -> None:
    d = directions(8)
    np.testing.assert_allclose(d, cube_directions(8), atol=1e-12)
    face, s, t = faces_of(d.reshape(-1, 3))
    np.testing.assert_array_equal(face, np.repeat(np.arange(6), 64))
    centre = (np.arange(8) + 0.5) / 4 - 1
    np.testing.assert_allclose(s.reshape(6, 8, 8)[:, 3], np.tile(centre, (6, 1)), atol=1e-12)
    np.testing.assert_allclose(t.reshape(6, 8, 8)[:, :, 3], np.tile(centre, (6, 1)), atol=1e-12)


def test_sampling_is_seamless_and_exact_at_centres() -> None:
    faces = (directions(16) * 0.5 + 0.5).astype(np.float32)
    cube = CubeChain.build(faces)
    np.testing.assert_allclose(
        cube.sample(directions(16).reshape(-1, 3).astype("f4"), 0), faces.reshape(-1, 3), atol=1e-5
    )
    d = fibonacci(4000).astype(np.float32)
    # a smooth function must stay smooth over the edges: the error is the interpolation's everywhere
    assert np.abs(cube.sample(d, 0.0) - (d * 0.5 + 0.5)).max() < 0.01


def test_equirect_orientation() -> None:
    image = np.zeros((64, 128, 3), np.float32)
    image[:, 64 - 4 : 64 + 4, 0] = 1.0  # u = 0.5
    image[:, 96 - 4 : 96 + 4, 1] = 1.0  # u = 0.75
    image[:4, :, 2] = 1.0
    cube = CubeChain.build(from_equirect(image, 32))
    ahead, right, up, behind = cube.sample(np.array([[0, 0, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "f4"), 0.0)
    assert ahead[0] > 0.9
    assert right[1] > 0.9
    assert up[2] > 0.9
    assert behind.max() < 0.1


def test_equirect_is_averaged_down_not_skipped() -> None:
    image = np.zeros((512, 1024, 3), np.float32)
    image[::2, ::2] = 4.0
    faces = from_equirect(image, 8)
    np.testing.assert_allclose(faces, 1.0, atol=0.02)


def test_uniform_environment_prefilters_to_itself() -> None:
    cube, sh9 = bake_environment(EnvironmentAsset(kind="uniform", color=(1.0, 0.5, 2.0)), 64)
    assert (cube.format, cube.cube, cube.layers, cube.mip_count) == ("rgba16f", True, 6, 5)
    for mip in range(cube.mip_count):
        np.testing.assert_allclose(
            level(cube, mip), np.broadcast_to([1.0, 0.5, 2.0], level(cube, mip).shape), rtol=1e-3
        )
    expected = np.zeros((9, 3))
    expected[0] = math.sqrt(4 * math.pi) * np.array([1.0, 0.5, 2.0])
    np.testing.assert_allclose(sh9, expected, atol=1e-5)


def test_sh_of_a_cosine_sky() -> None:
    # L = max(0, y): irradiance / pi facing up is the integral of cos^2 over the hemisphere / pi = 2/3
    faces = np.maximum(directions(64)[..., 1:2], 0.0).astype(np.float32).repeat(3, -1)
    _, sh9 = bake_environment(faces, 32)
    assert sh.evaluate(sh9, [0.0, 1.0, 0.0])[0] == pytest.approx(2 / 3, abs=0.02)
    assert sh.evaluate(sh9, [0.0, -1.0, 0.0])[0] == pytest.approx(0.0, abs=0.02)


def test_prefilter_matches_quadrature() -> None:
    def light(d: NDArray[np.float64]) -> NDArray[np.float64]:
        value = 0.2 + np.maximum(0.0, d @ np.array([0.6, 0.64, 0.48])) ** 6 * 5.0
        return np.repeat(value[..., None], 3, -1)

    cube, _ = bake_environment(light(directions(128)).astype(np.float32), 64)
    d, area = cube_directions(96).reshape(-1, 3), np.tile(cube_solid_angles(96).ravel(), 6)
    radiance = light(d)[:, 0]
    for mip in (2, 3, 4):
        image, normals = level(cube, mip), directions(mip_extent(64, mip))
        alpha = (mip / 4) ** 2
        for face, row, column in ((0, 1, 0), (2, 0, 1), (4, 1, 1)):
            n = normals[face, row, column]
            n_dot_l = d @ n
            half = d + n
            n_dot_h = (half @ n) / np.linalg.norm(half, axis=1)
            weight = np.where(n_dot_l > 0, ggx.D_GGX(n_dot_h, alpha) * n_dot_l, 0.0) * area
            want = (weight * radiance).sum() / weight.sum()
            assert image[face, row, column, 0] == pytest.approx(want, rel=0.03), (mip, face)


def test_lobe_weights_and_mirror() -> None:
    for roughness in (0.0, 0.3, 1.0):
        d, weights, solid_angle = lobe(roughness, 256)
        np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1.0, atol=1e-9)
        assert weights.sum() == pytest.approx(1.0)
        assert (solid_angle > 0).all()
    assert lobe(0.0, 64)[0][:, 2].min() > 0.999


def test_dfg_against_sampling_and_its_limits() -> None:
    rng = np.random.default_rng(0)
    table = bake_dfg(16)
    for j in (1, 6, 15):
        for i in (1, 7, 15):
            mu, alpha = i / 15, (j / 15) ** 2
            v = np.array([math.sqrt(1 - mu * mu), 0.0, mu])
            h = ggx.sample_visible_half(rng.random((200_000, 2)), v, alpha)
            v_dot_h = np.clip(h @ v, 0, 1)
            n_dot_l = 2 * v_dot_h * h[:, 2] - mu
            # visible normals: f cos / pdf = F G2 / G1 (Heitz 2018, eq. 19)
            g2 = ggx.V_SmithGGXCorrelated(mu, np.maximum(n_dot_l, 1e-9), alpha) * 4 * mu * np.maximum(n_dot_l, 1e-9)
            weight = np.where(n_dot_l > 0, g2 / ggx.G1_Smith(mu, alpha), 0.0)
            fresnel = (1 - v_dot_h) ** 5
            want = [(weight * (1 - fresnel)).mean(), (weight * fresnel).mean()]
            np.testing.assert_allclose(table[j, i], want, atol=2.5e-3)
    assert (table.sum(-1) <= 1.0 + 1e-6).all()  # with f0 = 1 nothing is gained
    smooth = ggx.dfg(1e-3, np.array([0.1, 0.5, 0.9]))
    np.testing.assert_allclose(smooth.sum(-1), 1.0, atol=1e-3)
    np.testing.assert_allclose(smooth[:, 1], (1 - np.array([0.1, 0.5, 0.9])) ** 5, atol=2e-3)


def test_shipped_dfg_is_what_baking_gives() -> None:
    texture = read_dds(shaders_dir() / "data" / "dfg_lut.dds")
    assert texture.format == "rg16f"
    n = texture.width
    table = np.frombuffer(texture.levels[0][0], "<f2").reshape(n, n, 2).astype(float)
    for j in (0, 40, n - 1):
        at = np.maximum(np.linspace(0, 1, n), 1e-3)
        want = ggx.dfg(at[j], at)
        np.testing.assert_allclose(table[j], want, atol=1e-3)


def test_shipped_studio_is_what_baking_gives() -> None:
    assert studio_path().stat().st_size <= 600_000
    shipped, sh9 = read_environment(studio_path())
    assert (shipped.format, shipped.width) == ("bc6h", STUDIO_SIZE)
    size = 64
    baked, baked_sh9 = bake_environment(EnvironmentAsset(kind="studio"), size, smallest=STUDIO_SMALLEST)
    np.testing.assert_allclose(sh9, baked_sh9, atol=2e-3)
    assert shipped.mip_count == STUDIO_SIZE.bit_length() - STUDIO_SMALLEST.bit_length() + 1
    # mean radiance over the sphere survives prefiltering, and compression, within a few percent
    area = cube_solid_angles(size)
    mean = float((level(baked, 0)[..., 0] * area).sum() / (4 * math.pi))
    assert mean == pytest.approx(float(sh9[0, 0]) / math.sqrt(4 * math.pi), rel=0.01)


def test_studio_is_neutral_and_calibrated() -> None:
    _, sh9 = read_environment(studio_path())
    np.testing.assert_allclose(sh9[:, 0], sh9[:, 2], atol=1e-5)
    assert sh.evaluate(sh9, [0.0, 1.0, 0.0])[0] == pytest.approx(0.9, abs=0.01)
    d = fibonacci(2000)
    assert sh.evaluate(sh9, d).min() > 0.05
    light = procedural.studio(d)
    assert light.min() > 0.02
    assert light.max() < 5.0


@pytest.mark.parametrize("degrees", [-90, -10, -3, 0, 0.5, 5, 20, 45, 70, 90])
@pytest.mark.parametrize("turbidity", [1.0, 3.0, 10.0, 20.0])
def test_skies_are_positive_and_finite(degrees: float, turbidity: float) -> None:
    environment = EnvironmentAsset(kind="sky", sun_elevation=math.radians(degrees), turbidity=turbidity)
    light = procedural.sky(np.concatenate([fibonacci(3000), [[0, 1, 0], [1, 0, 0], [0, -1, 0]]]), environment)
    assert np.isfinite(light).all()
    assert light.min() > 0.0
    assert light.max() < 100.0


def test_sky_is_brightest_near_the_sun_blue_and_dims_at_dusk() -> None:
    environment = EnvironmentAsset(kind="sky", sun_elevation=math.radians(40), sun_azimuth=1.0)
    d = fibonacci(5000)
    light = procedural.sky(d, environment)
    luminance = light @ np.array([0.2126, 0.7152, 0.0722])
    assert d[luminance.argmax()] @ sun_direction(environment) > 0.95
    away = -sun_direction(environment) * np.array([1.0, -1.0, 1.0])
    r, _, b = procedural.sky(away[None], environment)[0]
    assert b > 1.5 * r
    means = []
    for degrees in (40, 10, 0, -3, -6):
        environment.sun_elevation = math.radians(degrees)
        means.append(procedural.sky(d, environment).mean())
    assert means == sorted(means, reverse=True)


def test_sun_direction_convention() -> None:
    for azimuth, want in ((0.0, [0, 0, 1]), (math.pi / 2, [1, 0, 0])):
        environment = EnvironmentAsset(sun_elevation=0.0, sun_azimuth=azimuth)
        np.testing.assert_allclose(sun_direction(environment), want, atol=1e-12)
    np.testing.assert_allclose(sun_direction(EnvironmentAsset(sun_elevation=math.pi / 2)), [0, 1, 0], atol=1e-12)


def test_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    environment = EnvironmentAsset(kind="uniform", color=(0.5, 0.5, 0.5))
    path = environment_file(environment, tmp_path, size=16)
    assert path.is_relative_to(tmp_path / "cache")
    first = path.stat().st_mtime_ns
    environment.intensity, environment.rotation = 3.0, 1.0
    assert environment_file(environment, tmp_path, size=16) == path
    assert path.stat().st_mtime_ns == first
    environment.color = (0.5, 0.5, 0.6)
    assert environment_file(environment, tmp_path, size=16) != path
    path.write_bytes(b"damaged")
    environment.color = (0.5, 0.5, 0.5)
    texture, _ = read_environment(environment_file(environment, tmp_path, size=16))
    assert texture.width == 16
    assert environment_file(EnvironmentAsset(kind="studio"), tmp_path) == studio_path()
    black, sh9 = read_environment(environment_file(EnvironmentAsset(kind="none"), tmp_path, size=8))
    assert not sh9.any()
    assert not level(black, 0).any()


def test_images_and_cubes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shared_assets: Path) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    grace = shared_assets / "sdkmesh_head" / "Enviroment" / "Grace" / "IrradianceMap.dds"
    environment = EnvironmentAsset(kind="image", path=grace.name)
    baked = environment_file(environment, grace.parent, size=32)
    texture, sh9 = read_environment(baked)
    assert texture.width == 32
    assert (sh9[0] > 0).all()
    # a baked cube is used as it is
    assert environment_file(EnvironmentAsset(kind="image", path=baked.name), baked.parent) == baked
    with pytest.raises(InputError, match="not there"):
        environment_file(EnvironmentAsset(kind="image", path="absent.hdr"), tmp_path)


def test_bad_environment_files(tmp_path: Path) -> None:
    cube, sh9 = bake_environment(EnvironmentAsset(kind="uniform"), 8)
    write_environment(tmp_path / "e.dds", cube, sh9)
    assert read_environment(tmp_path / "e.dds")[1].shape == (9, 3)
    write_dds(tmp_path / "plain.dds", cube)
    with pytest.raises(FormatError, match="no baked environment"):
        read_environment(tmp_path / "plain.dds")
    for bad in ([], [[1.0] * 3] * 8, "x", None, [[1e300] * 3] * 9, {"a": 1}):
        cube.extras = {"environment": "lucarna.env/1", "sh9": bad}
        write_dds(tmp_path / "bad.dds", cube)
        with pytest.raises(FormatError):
            read_environment(tmp_path / "bad.dds")
    with pytest.raises(InputError):
        bake_environment(EnvironmentAsset(kind="uniform"), 48)
