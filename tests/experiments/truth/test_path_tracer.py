"""The path tracer where the answer is known: furnaces, plates under lights, closed boxes, and how chance falls."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

pytest.importorskip("embreex")

from engine.assets.primitives import cube, plane, uv_sphere
from engine.assets.scene import LightAsset
from engine.experiments.truth.lobes import Lobes
from engine.experiments.truth.path_tracer import Settings, radiance, trace
from engine.experiments.truth.surroundings import Surroundings
from engine.experiments.truth.traced_scene import TracedScene
from engine.math import quat
from engine.math.sphere import fibonacci
from engine.math.transform import look_at
from engine.render.camera import Camera
from tests.experiments.truth import stage

#: shines down: -Z turned to -Y
DOWN = quat.from_axis_angle((1.0, 0.0, 0.0), -math.pi / 2)
LAMBERT = {"base": 0.5, "specular": 0.0}


def looking(scene: TracedScene, at: Any, eye: Any, count: int = 4096, **settings: Any) -> tuple[float, float]:
    """Mean radiance that comes from `at` to `eye`, and its standard error."""
    eye, at = np.asarray(eye, np.float64), np.asarray(at, np.float64)
    d = np.broadcast_to((at - eye) / np.linalg.norm(at - eye), (count, 3)).copy()
    got = radiance(scene, np.broadcast_to(eye, (count, 3)).copy(), d, Settings(**settings), np.random.default_rng(7))
    mean = got.mean(axis=1)
    return float(mean.mean()), float(mean.std() / math.sqrt(count))


@pytest.mark.parametrize(
    "values",
    [
        {"base": 1.0, "specular": 0.0},
        {"base": 1.0, "specular": 1.0, "roughness": 0.3},
        {"base": 1.0, "metallic": 1.0, "specular": 1.0, "roughness": 0.15},
        {"base": 1.0, "metallic": 1.0, "specular": 1.0, "roughness": 0.5},
        {"base": 1.0, "metallic": 1.0, "specular": 1.0, "roughness": 1.0},
    ],
)
@pytest.mark.parametrize("place", [0.0, 0.9])
def test_white_in_a_white_furnace_is_white(values: dict[str, float], place: float) -> None:
    """At the middle of a ball and near its rim: what is lost at grazing angles comes back."""
    ball = stage.scene(stage.triangles(uv_sphere(1.0, 48, 96)), stage.material(**values), around=1.0)
    mean, error = looking(ball, (place, 0.0, math.sqrt(1.0 - place**2)), (place, 0.0, 5.0), bounces=4)
    assert mean == pytest.approx(1.0, abs=4.0 * error + 2e-3)
    assert error < 0.02


def test_a_plate_under_a_point_light() -> None:
    lamp = stage.lamps((LightAsset("point", (1.0, 1.0, 1.0), 8.0), (0.0, 2.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    plate = stage.scene(stage.triangles(plane(20.0)), stage.material(**LAMBERT), lamp)
    mean, error = looking(plate, (1.5, 0.0, 0.0), (0.0, 5.0, 3.0), 8)
    d2 = 1.5**2 + 2.0**2
    assert mean == pytest.approx(0.5 / math.pi * 8.0 / d2 * 2.0 / math.sqrt(d2), rel=1e-6)
    assert error < 1e-9, "no chance where a light has no extent"


def test_many_lamps_are_looked_at_by_chance() -> None:
    light = LightAsset("point", (1.0, 1.0, 1.0), 1.0)
    heights = (1.0, 1.5, 2.0, 2.5, 3.0, 3.5)
    lamps = stage.lamps(*((light, (0.0, h, 0.0), (0.0, 0.0, 0.0, 1.0)) for h in heights))
    plate = stage.scene(stage.triangles(plane(20.0)), stage.material(**LAMBERT), lamps)
    mean, error = looking(plate, (0.0, 0.0, 0.0), (0.0, 5.0, 3.0), 8000)
    assert mean == pytest.approx(0.5 / math.pi * sum(1.0 / h**2 for h in heights), abs=4.0 * error)
    assert 0.0 < error < 0.02 * mean


def test_a_plate_under_a_rectangle_and_a_disk() -> None:
    """The form factor of a rectangle parallel to the plate, above one of its corners (Siegel and Howell, 14), and of a
    disk above its middle."""
    light = LightAsset("rectangle", (1.0, 1.0, 1.0), 3.0, width=2.0, height=1.0)
    plate = stage.scene(
        stage.triangles(plane(20.0)), stage.material(**LAMBERT), stage.lamps((light, (0, 1.5, 0), DOWN))
    )
    mean, error = looking(plate, (1.0, 0.0, 0.5), (4.0, 5.0, 3.0), 20000)
    a, b = 2.0 / 1.5, 1.0 / 1.5
    ra, rb = math.sqrt(1.0 + a * a), math.sqrt(1.0 + b * b)
    part = (a / ra * math.atan(b / ra) + b / rb * math.atan(a / rb)) / (2.0 * math.pi)
    assert mean == pytest.approx(0.5 * 3.0 * part, abs=4.0 * error)
    assert error < 0.01 * mean
    light = LightAsset("disk", (1.0, 1.0, 1.0), 3.0, width=1.6, height=1.6)
    plate = stage.scene(
        stage.triangles(plane(20.0)), stage.material(**LAMBERT), stage.lamps((light, (0, 1.5, 0), DOWN))
    )
    mean, error = looking(plate, (0.0, 0.0, 0.0), (4.0, 5.0, 3.0), 20000)
    assert mean == pytest.approx(0.5 * 3.0 * 0.8**2 / (0.8**2 + 1.5**2), abs=4.0 * error)


def test_a_glossy_plate_sees_a_rectangle_both_ways_alike() -> None:
    """Against brute force over the rectangle with the same surface: the two samplers are weighed right."""
    light = LightAsset("rectangle", (1.0, 1.0, 1.0), 3.0, width=2.0, height=1.0)
    values = {"base": 0.6, "metallic": 1.0, "specular": 1.0, "roughness": 0.35}
    lamp = stage.lamps((light, (0.0, 1.5, 0.0), DOWN))
    plate = stage.scene(stage.triangles(plane(20.0)), stage.material(**values), lamp)
    at, eye = np.array([0.8, 0.0, 0.0]), np.array([2.4, 2.8, 0.3])
    mean, error = looking(plate, at, eye, 40000)
    x, y = np.meshgrid((np.arange(300) + 0.5) / 300 * 2 - 1, (np.arange(300) + 0.5) / 300 - 0.5)
    to = np.stack([x.ravel(), np.full(x.size, 1.5), y.ravel()], axis=1) - at
    d2 = (to**2).sum(axis=1)
    l = to / np.sqrt(d2)[:, None]
    v = (eye - at) / np.linalg.norm(eye - at)
    n, one = len(l), np.ones(len(l))
    lobes = Lobes.make(np.tile([0.0, 1.0, 0.0], (n, 1)), np.tile(v, (n, 1)), one * 0.35, np.full((n, 3), 0.6), one,
                       np.zeros((n, 3)))  # fmt: skip
    want = float((lobes.value(l)[0][:, 0] * 3.0 * l[:, 1] / d2).mean() * 2.0)
    assert mean == pytest.approx(want, abs=4.0 * error)
    assert error < 0.01 * mean


@pytest.mark.parametrize("albedo", [0.3, 0.7])
def test_a_closed_box_that_glows(albedo: float) -> None:
    """Radiance inside is e / (1 - rho), for diffuse walls everywhere the same."""
    walls = stage.material(base=albedo, specular=0.0, emissive=0.25)
    walls.double_sided[:] = True  # it is looked at from inside
    box = stage.scene(stage.triangles(cube(2.0)), walls)
    mean, error = looking(box, (1.0, 0.3, 0.2), (0.0, 0.0, 0.0), 3000, bounces=64)
    assert mean == pytest.approx(0.25 / (1.0 - albedo), abs=4.0 * error)
    assert error < 0.02 * mean


def test_shadow_and_no_shadow() -> None:
    lamp = stage.lamps((LightAsset("directional", (1.0, 1.0, 1.0), 1.0), (0.0, 0.0, 0.0), DOWN))
    shapes = stage.join(stage.triangles(plane(20.0)), stage.triangles(uv_sphere(1.0), move=(0.0, 2.0, 0.0)))
    both = stage.scene(shapes, stage.material(**LAMBERT), lamp)
    eye = (4.0, 0.5, 0.0)
    assert looking(both, (0.0, 0.0, 0.0), eye, 8)[0] == 0.0
    assert looking(both, (0.0, 0.0, 0.0), eye, 8, shadows=False)[0] == pytest.approx(0.5 / math.pi)
    assert looking(both, (1.5, 0.0, 0.0), eye, 8)[0] == pytest.approx(0.5 / math.pi)


def camera() -> Camera:
    return Camera(look_at((0.0, 2.0, 4.0), (0.0, 0.0, 0.0)), 0.8)


def lit_ball() -> TracedScene:
    shapes = stage.join(stage.triangles(plane(8.0)), stage.triangles(uv_sphere(1.0), move=(0.0, 1.0, 0.0)))
    around = np.random.default_rng(1).uniform(0.0, 2.0, (6, 8, 8, 3))
    made = stage.scene(shapes, stage.material(base=0.6, specular=1.0, roughness=0.4))
    made.surroundings = Surroundings(around, 0.7)
    return made


def test_chance_falls_with_the_root_of_the_paths() -> None:
    """Squared error halves as paths double; the film's own noise figure says how large it is."""
    ball = lit_ball()
    best = trace(ball, camera(), 16, 12, Settings(2048, seed=5))
    counts, errors, noises = (16, 64, 256), [], []
    for count in counts:
        film = trace(ball, camera(), 16, 12, Settings(count, seed=9))
        assert film is not None
        assert best is not None
        assert film.samples == count
        errors.append(float(np.mean((film.mean - best.mean) ** 2)))
        noises.append(film.noise)
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.25)
    for error, noise in zip(errors[:2], noises[:2], strict=True):
        assert noise == pytest.approx(math.sqrt(error), rel=0.3)


def test_the_seed_makes_the_picture_and_pauses_do_not() -> None:
    ball = lit_ball()
    first, again = (trace(ball, camera(), 16, 12, Settings(8, bounces=3, seed=3)) for _ in range(2))
    other = trace(ball, camera(), 16, 12, Settings(8, bounces=3, seed=4))
    assert first is not None
    assert again is not None
    assert other is not None
    assert (first.mean == again.mean).all()
    assert (first.mean != other.mean).any()
    heard: list[float] = []

    def listen(done: float) -> bool:
        heard.append(done)
        return len(heard) < 2

    assert trace(ball, camera(), 16, 12, Settings(64), listen) is None
    assert len(heard) == 2


def test_turned_surroundings_are_sampled_where_they_are_bright() -> None:
    """One bright texel among dark ones: sampling finds it, evaluation agrees, and the density integrates to 1."""
    faces = np.full((6, 8, 8, 3), 0.01)
    faces[2, 3, 4] = 500.0
    sky = Surroundings(faces, 1.1)
    d = sky.sample(np.random.default_rng(2).random((4000, 3)))
    assert (sky.radiance(d)[:, 0] == 500.0).mean() > 0.8
    everywhere = fibonacci(400_000)
    assert float(sky.density(everywhere).mean()) * 4.0 * math.pi == pytest.approx(1.0, abs=0.02)
    energy = (sky.radiance(d)[:, 0] / sky.density(d)).mean()
    assert energy == pytest.approx(float(sky.radiance(everywhere)[:, 0].mean()) * 4.0 * math.pi, rel=0.05)
