"""Rectangle, disk and profiled lights in pictures: against closed forms, quadrature, and the lights they turn into."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.assets.primitives import card, uv_sphere
from engine.assets.scene import LightAsset
from engine.math import ggx, ltc, quat
from tests.support.stage import Stage, front_camera

SIZE = (24, 24)
#: turns -Z to -Z: the light at +Z shines at the card in the XY plane as it is
FACING = (0.0, 0.0, 0.0, 1.0)
IES = "IESNA91\nTILT=NONE\n1 1000 1 {v} {h} 1 2 0 0 0\n1 1 10\n{vertical}\n{horizontal}\n{candela}\n"


@pytest.fixture
def matt(stage: Stage, surface) -> Stage:
    """A dark stage with a grey card that only scatters."""
    stage.dark()
    stage.add(card(8.0), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, specular=0.0))
    return stage


def pixels(half: float = 0.5) -> np.ndarray:
    """Where the pixels of a front camera's picture lie on the card: f8[h,w,3], orthographic enough near the middle."""
    at = (np.arange(SIZE[0]) + 0.5) / SIZE[0] * 2.0 - 1.0
    x, y = np.meshgrid(at, -at)
    return np.stack([x, y, np.zeros_like(x)], -1) * half


def middle(stage: Stage) -> np.ndarray:
    return stage.hdr((9, 9), front_camera(0.01))[4, 4, :3].astype(float)


@pytest.mark.parametrize("height", [0.02, 0.5, 3.0])
@pytest.mark.parametrize("kind", ["rectangle", "disk"])
def test_a_lambertian_light_over_a_matt_card(matt: Stage, kind: str, height: float) -> None:
    """Rectangle: the polygon's closed form. Disk of radius a: a^2 / (a^2 + h^2) (Howell, B-13); 16 corners for it."""
    matt.lamp(LightAsset(kind, intensity=3.0, width=1.2, height=1.2), (0, 0, height), FACING)
    a = 0.6
    if kind == "disk":
        factor = a * a / (a * a + height * height)
    else:
        corners = np.array([(a, a, height), (-a, a, height), (-a, -a, height), (a, -a, height)])
        factor = float(ltc.form_factor(corners))
    assert middle(matt) == pytest.approx(3.0 * 0.5 * factor, rel=3e-3)


def test_horizon_cuts_what_is_below_it(matt: Stage) -> None:
    """A wall that stands on the card, half of it sunk: the part above counts."""
    matt.lamp(LightAsset("rectangle", intensity=5.0, width=2.0, height=4.0), (1.0, 0, 0), _turned("y", math.pi / 2))
    above = np.array([(1, 2, 1), (1, -2, 1), (1, -2, 0), (1, 2, 0.0)])
    assert middle(matt) == pytest.approx(5.0 * 0.5 * abs(float(ltc.form_factor(above))), rel=2e-3)


def test_one_side_and_two(matt: Stage) -> None:
    back = _turned("x", math.pi)
    row = matt.lamp(LightAsset("rectangle", intensity=2.0), (0, 0, 1.0), back)
    assert (middle(matt) == 0.0).all()
    matt.runtime.scene.lights.set(row, two_sided=True)
    behind = middle(matt)
    matt.runtime.scene.nodes.set_rotation([int(matt.runtime.scene.lights.node[row])], [FACING])
    matt.runtime.update()
    assert behind == pytest.approx(middle(matt), rel=1e-3)
    assert behind[0] > 0.1


@pytest.mark.parametrize(("metallic", "roughness"), [(0.0, 0.3), (1.0, 0.6)])
def test_a_small_light_is_a_point_light(stage: Stage, surface, metallic: float, roughness: float) -> None:
    """Also where its lobe is taken for a transformed cosine: within that fit's error, 6 % of the brightest pixel."""
    pictures = []
    for light in (LightAsset("point", intensity=1.0), LightAsset("rectangle", intensity=1e4, width=0.01, height=0.01)):
        stage.dark()
        stage.add(card(8.0), surface(base_color=(0.8, 0.5, 0.2, 1), metallic=metallic, roughness=roughness))
        stage.lamp(replace(light), (0.2, 0.1, 1.5), FACING)
        pictures.append(stage.hdr(SIZE, front_camera())[..., :3])
    point, area = pictures
    lean = 1.5 / np.linalg.norm(pixels() - [0.2, 0.1, 1.5], axis=-1)  # a flat light shines with the cosine
    assert np.abs(area / lean[..., None] - point).max() < 0.06 * point.max()
    assert point.max() > 0.05


@pytest.mark.parametrize("roughness", [0.2, 0.5, 0.9])
def test_glossy_metal_against_quadrature(stage: Stage, surface, roughness: float) -> None:
    """Every pixel of a card under a rectangle, GGX summed over the light: the fit's error, at most 4 % of the peak."""
    stage.dark()
    stage.add(card(8.0), surface(base_color=(1, 1, 1, 1), metallic=1.0, roughness=roughness))
    stage.lamp(LightAsset("rectangle", intensity=1.0, width=0.8, height=0.4), (0.1, 0.3, 0.7), FACING)
    camera = front_camera()
    found = stage.hdr(SIZE, camera)[..., 0].astype(float)
    distance = float(camera.world_from_camera[2, 3])
    p = pixels(math.tan(camera.yfov / 2) * distance)
    v = np.array([0.0, 0.0, distance]) - p
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    nodes, weights = np.polynomial.legendre.leggauss(48)
    x, y = np.meshgrid(0.1 + 0.4 * nodes, 0.3 + 0.2 * nodes)
    share = np.outer(weights, weights) * 0.4 * 0.2
    to_light = np.stack([x, y, np.full_like(x, 0.7)], -1) - p[:, :, None, None]
    d2 = (to_light**2).sum(-1)
    l = to_light / np.sqrt(d2)[..., None]
    h = l + v[:, :, None, None]
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    alpha = roughness**2
    lobe = ggx.D_GGX(h[..., 2], alpha) * ggx.V_SmithGGXCorrelated(v[:, :, None, None, 2], l[..., 2], alpha)
    truth = (lobe * l[..., 2] ** 2 / d2 * share).sum(axis=(2, 3))
    assert np.abs(found - truth).max() < 0.04 * truth.max()


@pytest.mark.parametrize("kind", ["rectangle", "disk"])
@pytest.mark.parametrize(
    "values",
    [
        {"width": 0.0}, {"width": 0.0, "height": 0.0}, {"width": 1e-6, "height": 1e-6}, {"width": 1e6, "height": 1e6},
        {"range": 1e-6}, {"range": 1e6}, {"temperature": 1e9}, {"temperature": math.nan}, {"width": math.nan},
        {"intensity": math.inf}, {"color": (math.nan, 1.0, 1.0)},
    ],
    ids=str,
)  # fmt: skip
def test_extremes_stay_finite(stage: Stage, surface, kind: str, values: dict[str, object]) -> None:
    stage.dark()
    stage.add(uv_sphere(0.5, 8, 16), surface(roughness=0.0, metallic=1.0, base_color=(1, 1, 1, 1)))
    for place in ((0, 0, 0.5), (0.3, 0.0, 0.0), (0, 0, 1e-7), (0.0, 2.0, 0.0)):
        stage.lamp(LightAsset(kind, two_sided=True, **values), place, FACING)  # type: ignore[arg-type]
    assert np.isfinite(stage.hdr((16, 16), front_camera())).all()


def test_a_light_in_the_plane_of_what_it_shines_on(matt: Stage) -> None:
    matt.lamp(LightAsset("rectangle", two_sided=True), (0, 0, 0.0), FACING)
    matt.lamp(LightAsset("disk", width=0.5, height=0.5), (0.1, 0, 0.0), FACING)
    picture = matt.hdr(SIZE, front_camera())
    assert np.isfinite(picture).all()
    assert picture[..., :3].max() < 1.0  # all of a sky of 1 nit on grey is 0.5


@pytest.mark.parametrize("kind", ["point", "spot", "rectangle", "disk"])
def test_nothing_beyond_the_range(matt: Stage, kind: str) -> None:
    """Exactly nothing, and by the bounds that culling goes by, too."""
    matt.lamp(LightAsset(kind, intensity=9.0, range=0.5, width=0.4, height=0.2), (0, 0, 0.45), FACING)
    picture = matt.hdr(SIZE, front_camera(0.8))[..., 0]
    assert picture[12, 12] > 0.0
    bounds = matt.runtime.renderer.rows.lights.bounds
    reach = math.sqrt(float(bounds.radius[0]) ** 2 - 0.45**2)
    camera_scale = 0.8 * 1.25  # the framing leaves a margin: pixels out there are farther still
    far = np.linalg.norm(pixels(0.8), axis=-1) > reach * camera_scale
    assert far.any()
    assert (picture[far] == 0.0).all()


def test_the_order_of_lights_does_not_change_a_bit(stage: Stage, surface) -> None:
    rng = np.random.default_rng(5)
    kinds = ["point", "spot", "rectangle", "disk"]
    lamps = [
        (
            LightAsset(kinds[k % 4], tuple(rng.random(3)), 1.0 + k, 3.0, 0.1, 0.6, 0.3, 0.2),
            (0, 0, 1.0) if k % 3 == 0 else (*rng.uniform(-1, 1, 2), 1.0),
        )
        for k in range(24)
    ]  # fmt: skip
    pictures = []
    for order in (range(24), rng.permutation(24)):
        stage.dark()
        stage.add(card(4.0), surface(roughness=0.3))
        for k in order:
            stage.lamp(replace(lamps[k][0]), lamps[k][1], FACING)
        pictures.append(stage.hdr(SIZE, front_camera()))
    assert np.array_equal(*pictures)
    assert pictures[0].max() > 0.1


def _profile(tmp_path: Path, vertical: str, horizontal: str, candela: str) -> str:
    file = tmp_path / "lamp.ies"
    counts = {"v": len(vertical.split()), "h": len(horizontal.split())}
    file.write_text(IES.format(vertical=vertical, horizontal=horizontal, candela=candela, **counts), encoding="utf-8")
    return str(file)


def test_a_profile_shapes_the_light(matt: Stage, tmp_path: Path) -> None:
    """Twice the candela at 45 degrees than straight ahead: candela cos^3 / h^2 on the card."""
    path = _profile(tmp_path, "0 45 90", "0", "100 200 0")
    row = matt.lamp(LightAsset("point", intensity=2.0, profile=path), (0, 0, 0.25), FACING)
    camera = front_camera()
    picture = matt.hdr(SIZE, camera)[..., 0].astype(float)
    p = pixels(math.tan(camera.yfov / 2) * float(camera.world_from_camera[2, 3]))
    cosine = 0.25 / np.linalg.norm(p - [0, 0, 0.25], axis=-1)
    candela = np.interp(np.degrees(np.arccos(cosine)), [0, 45, 90], [1.0, 2.0, 0.0])
    truth = 0.5 / math.pi * candela * cosine**3 / 0.25**2
    assert np.abs(picture - truth).max() < 5e-3 * truth.max()
    matt.runtime.scene.lights.set(row, profile="")
    assert middle(matt) == pytest.approx(0.5 / math.pi * 2.0 / 0.25**2, rel=3e-3)


def test_a_profile_is_turned_with_its_light(matt: Stage, tmp_path: Path) -> None:
    """Bright along the node's +X: to the right; turned a quarter about the beam: upwards."""
    path = _profile(tmp_path, "0 90", "0 90 180 270 360", "100 100 10 10 1 1 10 10 100 100")
    row = matt.lamp(LightAsset("point", profile=path), (0, 0, 0.3), FACING)
    right = matt.hdr(SIZE, front_camera())[..., 0]
    assert right[12, 20] > 20 * right[12, 3]
    assert right[3, 12] == pytest.approx(right[20, 12], rel=0.05)
    matt.runtime.scene.nodes.set_rotation([int(matt.runtime.scene.lights.node[row])], [_turned("z", math.pi / 2)])
    matt.runtime.update()
    up = matt.hdr(SIZE, front_camera())[..., 0]
    assert up[3, 12] > 20 * up[20, 12]


def test_a_profile_that_cannot_be_read_is_a_finding(matt: Stage, tmp_path: Path) -> None:
    matt.lamp(LightAsset("point", profile="no such file.ies"), (0, 0, 0.3), FACING)
    assert middle(matt)[0] > 0.0
    assert "no such file" in str(next(iter(matt.runtime.renderer.light_findings)))


def test_a_profile_is_read_again_and_keeps_its_last_good_shape(matt: Stage, tmp_path: Path) -> None:
    file = tmp_path / "lamp.ies"
    matt.lamp(LightAsset("point", intensity=2.0, profile=str(file)), (0, 0, 0.25), FACING)
    reload = matt.runtime.hot_reload
    even = middle(matt)
    pictures = []
    for candela in ("100 200 0", "100 x00 0", "100 50 0"):  # there at last, broken, good again
        _profile(tmp_path, "0 45 90", "0", candela)
        assert reload.stale()
        taken = reload.apply().names
        pictures.append(middle(matt))
        assert not reload.stale()
        assert taken == ([] if "x" in candela else ["lamp.ies"])
        (error,) = [str(e) for e in reload.problems] or [""]
        assert ("lamp.ies:7: 'x00' is no number" in error) == ("x" in candela), error
        assert [state for state, _ in reload.standing()] == (["previous"] if "x" in candela else [])
    half, kept, whole = pictures
    assert half == pytest.approx(0.5 * even, rel=2e-3)
    assert np.array_equal(kept, half)
    assert whole == pytest.approx(even, rel=2e-3)


def _turned(axis: str, angle: float) -> tuple[float, ...]:
    return tuple(quat.from_axis_angle([float(axis == a) for a in "xyz"], angle).tolist())


def test_a_light_of_another_kind_that_comes_later_shines(matt: Stage, surface) -> None:
    """The surface shader without area lights, in use since the first picture, is no longer enough for the second."""
    point, disk = LightAsset("point", intensity=1.0), LightAsset("disk", intensity=10.0, width=2.0, height=2.0)
    matt.lamp(point, (0.0, 0.0, 1.0))
    middle(matt)
    matt.lamp(disk, (0.0, 0.0, 0.2), FACING)
    later = middle(matt)
    matt.dark()
    matt.add(card(8.0), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, specular=0.0))
    matt.lamp(point, (0.0, 0.0, 1.0))
    matt.lamp(disk, (0.0, 0.0, 0.2), FACING)
    matt.runtime.renderer.programs.forget()
    assert (later == middle(matt)).all()
