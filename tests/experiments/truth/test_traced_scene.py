"""A runtime scene as the tracer sees it, against the rasteriser: same places, surfaces, lights, holes, textures."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("embreex")

from engine.assets.primitives import card, cube
from engine.assets.scene import LightAsset
from engine.experiments.harness.samples import DOWN, build, environment, surface
from engine.experiments.harness.scenes import MadeScene
from engine.experiments.truth.path_tracer import Settings, trace
from engine.experiments.truth.reference import content_hash, picture
from engine.experiments.truth.traced_scene import camera_rays, traced
from engine.gpu.types import Device
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.metrics import is_blank, rmse

pytestmark = pytest.mark.gl

W, H = 48, 32


def both(scene: MadeScene, samples: int = 32, **how: bool) -> tuple[np.ndarray, np.ndarray, float]:
    view = View(scene.camera(W / H), W, H, RenderSettings(samples=4, background="color", tone_map="none", **how))
    hdr = scene.render(view, hdr=True).hdr
    assert hdr is not None
    ours = np.asarray(hdr.read(), np.float64)[..., :3]
    film = trace(traced(scene, view.settings), view.camera, W, H, Settings(samples, shadows=how.get("shadows", True)))
    assert film is not None
    return ours, film.mean, film.noise


def test_lambert_under_lamps_is_the_same_picture(gl_device: Device) -> None:
    """Diffuse, lamps without extent, no shadows: nothing is approximated, only edges differ by their samples."""
    scene = MadeScene("test", gl_device)
    try:
        environment(scene, "none")
        matt = surface(base_color=(0.6, 0.4, 0.2, 1.0), metallic=0.0, roughness=0.7, specular=0.0)
        turned = quat.from_axis_angle((0.3, 1.0, 0.2), 0.6)
        scene.add(cube(1.0), matt, (-0.6, 0.0, 0.0), turned, (1.0, 1.4, 0.5))
        scene.add(cube(1.0), matt, (0.7, 0.1, -0.3), turned, (-0.8, 0.8, 0.8))  # mirrored
        scene.lamp(LightAsset("point", (1.0, 0.8, 0.6), 6.0), (1.0, 1.5, 2.0))
        scene.lamp(LightAsset("spot", (0.6, 0.8, 1.0), 9.0, inner_angle=0.3, outer_angle=0.6), (-0.6, 2.5, 0.2), DOWN)
        scene.lamp(LightAsset("directional", (0.2, 0.3, 0.2), 2.0), rotation=quat.from_axis_angle((1, 0, 0), -0.5))
        scene.view_from = Camera(look_at((0.4, 0.8, 3.4), (0.0, 0.0, 0.0)), 0.6)
        ours, truth, noise = both(scene, 96, shadows=False)
        assert not is_blank(ours)
        inside = (np.abs(ours - truth) < 0.02 * truth.max()).all(axis=-1)
        assert inside.mean() > 0.94, "all but edges"
        assert rmse(ours[inside], truth[inside]) < 0.004 * truth.max() + noise
    finally:
        scene.close()


def test_textures_and_holes_are_where_the_rasteriser_has_them(gl_device: Device) -> None:
    scene = build("leaves", gl_device)
    try:
        ours, truth, _ = both(scene, 64, shadows=False)
        green = [image[..., 1] > 1.3 * image[..., 2] for image in (ours, truth)]
        assert 0.1 < green[1].mean() < 0.6
        assert (green[0] == green[1]).mean() > 0.97
    finally:
        scene.close()


def test_backs_are_seen_through_and_cards_cast(gl_device: Device) -> None:
    """The camera does not see the back of a one-sided card; the floor behind it is in its shadow all the same."""
    scene = MadeScene("test", gl_device)
    try:
        environment(scene, "none")
        white = surface(base_color=(0.9, 0.9, 0.9, 1.0), metallic=0.0, roughness=1.0, specular=0.0)
        scene.add(card(4.0), white)
        scene.add(card(1.0), white, (0.0, 0.0, 1.0), quat.from_axis_angle((0.0, 1.0, 0.0), np.pi))
        scene.lamp(LightAsset("directional", (1.0, 1.0, 1.0), 3.0))
        scene.view_from = Camera(look_at((0.0, 0.0, 4.0), (0.0, 0.0, 0.0)), 0.6)
        _, truth, _ = both(scene, 8)
        assert truth[H // 2, W // 2].max() == 0.0, "in the shadow"
        assert truth[2, 2].min() > 0.5
        _, free, _ = both(scene, 8, shadows=False)
        assert free[H // 2, W // 2].min() > 0.5, "seen through"
    finally:
        scene.close()


def test_rays_are_the_cameras(gl_device: Device) -> None:
    for camera in (Camera(look_at((1.0, 2.0, 3.0), (0.0, 0.5, 0.0)), 0.9), Camera(np.eye(4), ymag=1.5)):
        start, d = camera_rays(camera, W, H, np.array([0, W * H - 1]), np.full((2, 2), 0.5))
        clip = np.concatenate([start + 2.0 * d, np.ones((2, 1))], axis=1) @ camera.clip_from_world(W / H).T
        ndc = clip[:, :2] / clip[:, 3:]
        np.testing.assert_allclose(ndc, [[-1 + 1 / W, 1 - 1 / H], [1 - 1 / W, -1 + 1 / H]], atol=1e-9)


def test_references_are_made_once_and_know_their_scene(gl_device: Device, quick: object) -> None:
    ctx = quick()  # type: ignore[operator]  # a fixture that is a factory
    scene = build("ball", gl_device)
    try:
        world, camera = traced(scene), scene.camera(1.5)
        first = list(picture(ctx, "test-ball", world, camera, 12, 8, Settings(8)))
        again = list(picture(ctx, "test-ball", world, camera, 12, 8, Settings(8)))
        assert first
        assert not again, "out of the cache"
        known = content_hash(world)
        scene.residency.set_material_param(0, "roughness", 0.9)
        scene.residency.materials.records[0].asset.params["roughness"] = 0.9
        assert content_hash(traced(scene)) != known
    finally:
        scene.close()
