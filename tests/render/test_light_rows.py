"""The light table on the device: nothing is done for lights at rest, bounds hold what they say."""

from __future__ import annotations

import numpy as np

from engine.assets.scene import EnvironmentAsset, LightAsset
from engine.gpu.types import Device
from engine.math import quat
from engine.render.light_rows import MAX_SUNS, LightRows
from engine.scene.scene import Scene

DARK = EnvironmentAsset("none", sun_illuminance=0.0)
HERE = np.zeros(3)


def scene_of(*lights: LightAsset) -> Scene:
    scene = Scene()
    for k, light in enumerate(lights):
        turn = quat.from_axis_angle([1, 0, 0], 0.1 * k)
        scene.lights.add(scene.nodes.add(f"l{k}", translation=[float(k), 0, 0], rotation=turn), light)
    scene.update()
    return scene


def test_lights_at_rest_are_not_uploaded_again(null_device: Device) -> None:
    scene = scene_of(LightAsset("point"), LightAsset("spot"))
    other = scene.nodes.add("other")
    scene.update()
    rows = LightRows(null_device)
    rows.update(scene, DARK, HERE, 1.0, 0.0)
    bounds, calls = rows.bounds, len(null_device.calls)  # type: ignore[attr-defined]  # a null device records
    for step in range(3):
        scene.nodes.set_translation(other, [float(step), 0, 0])
        scene.update()
        rows.update(scene, DARK, HERE, 1.0, 0.0)
    assert rows.bounds is bounds
    assert len(null_device.calls) == calls  # type: ignore[attr-defined]
    rows.update(scene, DARK, HERE + 1.0, 1.0, 0.0)
    assert rows.bounds is not bounds
    assert np.array_equal(np.sort(rows.bounds.center[:, 0]), [-1.0, 0.0]), "relative to the origin"


def test_bounds() -> None:
    from engine.gpu import open_device

    scene = scene_of(
        LightAsset("point", range=2.0), LightAsset("point"), LightAsset("spot", range=3.0, outer_angle=0.5),
        LightAsset("rectangle", range=1.0, width=6.0, height=8.0), LightAsset("disk", width=1e6, height=1e6),
    )  # fmt: skip
    rows = LightRows(open_device("null"))
    rows.update(scene, DARK, HERE, 1.0, 0.0)
    order = np.argsort(rows.bounds.center[:, 0])
    assert np.allclose(rows.bounds.radius[order], [2.0, np.inf, 3.0, 6.0, np.inf], rtol=1e-4)
    assert (rows.bounds.radius[order][[0, 2, 3]] >= [2.0, 3.0, 6.0]).all(), "never less than they reach"
    assert np.allclose(rows.bounds.cos_angle[order], [-1, -1, np.cos(0.5), -1, -1], atol=1e-4)
    assert rows.bounds.cos_angle[order][2] <= np.cos(0.5)


def test_suns_beyond_the_block_go_into_the_buffer(null_device: Device) -> None:
    many = [LightAsset("directional", intensity=1.0 + k) for k in range(MAX_SUNS + 2)]
    rows = LightRows(null_device)
    for sun, own in ((0.0, MAX_SUNS), (2.0, MAX_SUNS - 1)):
        rows.update(scene_of(*many), EnvironmentAsset("none", sun_illuminance=sun), HERE, 1.0, 0.0)
        assert (rows.sun_count, rows.count) == (MAX_SUNS, len(many) - own)
        assert np.isinf(rows.bounds.radius).all()


def test_a_light_beyond_float32_is_finite(null_device: Device) -> None:
    scene = scene_of(LightAsset("point"))
    scene.nodes.set_translation(0, [1e300, 0, 0])
    scene.update()
    rows = LightRows(null_device)
    rows.update(scene, DARK, HERE, 1.0, 0.0)
    assert np.isfinite(rows.bounds.center).all()
