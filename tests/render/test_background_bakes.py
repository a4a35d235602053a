"""Surroundings baked behind the picture: what was shown stays until they are there."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from engine.assets.scene import EnvironmentAsset
from engine.core.errors import InputError
from engine.core.paths import shaders_dir
from engine.gpu.types import Device
from engine.render.background_bakes import BackgroundBakes
from engine.render.environments import Environments


def test_the_last_surroundings_stay_until_the_new_ones_are_there(null_device: Device) -> None:
    go, told = threading.Event(), threading.Event()
    environments = Environments(null_device)

    def bake(environment: EnvironmentAsset) -> Path:
        go.wait(10)
        return shaders_dir() / "data" / "studio.env.dds"

    environments.baker, environments.told = bake, told.set
    uniform = environments.get(EnvironmentAsset("uniform", color=(1.0, 0.0, 0.0)))
    sky = EnvironmentAsset("sky")
    assert environments.get(sky) is uniform
    assert (environments.baking, environments.baked) == (1, 0)
    assert environments.get(sky) is uniform, "and it is baked once"
    go.set()
    assert told.wait(10)
    assert (environments.baking, environments.baked) == (0, 1)
    made = environments.get(sky)
    assert made is not uniform
    assert environments.get(sky) is made
    environments.release()


def test_without_a_picture_before_it_is_the_studio_and_a_failure_is_a_finding(null_device: Device) -> None:
    told = threading.Event()
    environments = Environments(null_device)

    def bake(environment: EnvironmentAsset) -> Path:
        raise InputError("is no panorama")

    environments.baker, environments.told = bake, told.set
    shown = environments.get(EnvironmentAsset("image", path="a.hdr"))
    assert told.wait(10)
    assert shown is not None
    environments.get(EnvironmentAsset("image", path="a.hdr"))
    assert [f.message for f in environments.findings] == ["is no panorama"]
    environments.release()


def test_what_was_baked_before_comes_at_once_and_other_mistakes_are_told() -> None:
    bakes = BackgroundBakes(lambda: None)
    assert bakes.get("a", lambda: Path("there")) == Path("there")

    def wrong() -> Path:
        raise OSError("the disk is full")

    with pytest.raises(InputError, match="the disk is full"):
        bakes.get("b", wrong)
