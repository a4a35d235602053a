"""Scattered lights: where, how even, the same each time, and the clip that moves them."""

from __future__ import annotations

import numpy as np
import pytest

from engine.animation.sample import ClipPlayer
from engine.core.errors import InputError, UsageError
from engine.scene.drift import drift_clip
from engine.scene.scatter import KINDS, ScatterSettings, scatter_lights
from engine.scene.scene import Scene

LOW, HIGH = (-1.0, 0.0, 2.0), (3.0, 1.0, 4.0)


def scattered(**values: object) -> Scene:
    scene = Scene()
    scatter_lights(scene, ScatterSettings(**values), LOW, HIGH)
    scene.update()
    return scene


@pytest.mark.parametrize("kind", KINDS)
def test_they_lie_in_the_box_and_shine(kind: str) -> None:
    world = scattered(kind=kind, count=200, intensity=4.0, spread=0.5, range=3.0).lights.world()
    assert len(world) == 200
    assert ((world["position"] >= LOW) & (world["position"] <= HIGH)).all()
    strength = world["radiant"].max(axis=1)
    assert strength.max() <= 4.0
    assert strength.min() > 0.0
    assert np.allclose(world["direction"], [0, -1, 0], atol=1e-6)


def test_every_eighth_of_the_box_has_its_share() -> None:
    position = scattered(count=800).lights.world()["position"]
    octant = ((position > np.add(LOW, HIGH) / 2) * [1, 2, 4]).sum(axis=1)
    assert np.bincount(octant, minlength=8).min() > 85, "100 each, and no clumps"


def test_the_same_settings_give_the_same_lights() -> None:
    one, two, other = (scattered(count=50, seed=s, all_hues=True).lights.world() for s in (1, 1, 2))
    assert one.tobytes() == two.tobytes()
    assert one.tobytes() != other.tobytes()


def test_random_aim_is_all_around() -> None:
    direction = scattered(kind="spot", count=500, aim="random").lights.world()["direction"]
    assert np.abs(direction.mean(axis=0)).max() < 0.12


def test_what_cannot_be() -> None:
    with pytest.raises(UsageError, match="count"):
        ScatterSettings(count=0)
    with pytest.raises(InputError, match="no size"):
        scatter_lights(Scene(), ScatterSettings(), (np.nan, 0, 0), HIGH)


def test_a_box_of_no_size_puts_all_in_one_place() -> None:
    scene = Scene()
    scatter_lights(scene, ScatterSettings(count=5), LOW, LOW)
    scene.update()
    assert np.allclose(scene.lights.world()["position"], LOW)


def test_drifting_lights_circle_and_come_back() -> None:
    scene = Scene()
    top = scatter_lights(scene, ScatterSettings(count=20), LOW, HIGH)
    clip = drift_clip(scene, top, 0.5, 1)
    assert len(clip.channels) == 20
    player = ClipPlayer(clip, np.arange(len(scene.nodes)))
    found = []
    for time in (0.0, 4.0, 16.0 - 1e-6):
        player.apply(scene.nodes, time)
        scene.update()
        found.append(scene.lights.world()["position"].copy())
    assert np.abs(found[0] - found[2]).max() < 1e-4
    assert np.linalg.norm(found[1] - found[0], axis=1).min() > 0.3
