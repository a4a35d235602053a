"""A material on a stage of its own, drawn with an open runtime's materials."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.app.framing import frame_bounds
from engine.app.material_stage import MaterialStage
from engine.app.runtime import Runtime
from engine.assets.material import MaterialAsset
from engine.assets.scene import EnvironmentAsset, LookAsset, SceneAsset
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View

WHITE = EnvironmentAsset("uniform", color=(1.0, 1.0, 1.0), background="color", sun_illuminance=0.0)


@pytest.fixture
def stage(gl_device: Device) -> Iterator[MaterialStage]:
    runtime = Runtime(gl_device, profile=False)
    runtime.load(SceneAsset("empty", environment=WHITE), Path())
    stage = MaterialStage(runtime)
    stage.surround(WHITE, LookAsset(tone_map="none"))
    yield stage
    stage.release()
    runtime.close()


def picture(stage: MaterialStage, **settings: float) -> NDArray[np.uint8]:
    camera = frame_bounds(*stage.bounds(), 1.0, azimuth=0.0, elevation=0.0)
    view = View(camera, 48, 48, RenderSettings(samples=1, shadows=False, **settings))
    return np.asarray(stage.render(view).color.read(), np.uint8)


def test_a_diffuse_white_sphere_under_white_light_is_white_and_an_edit_shows(stage: MaterialStage) -> None:
    residency = stage.runtime.residency
    params = {"metallic": 0.0, "specular": 0.0, "base_color": (0.5, 0.5, 0.5, 1.0)}
    material = residency.add_material(MaterialAsset("paint", params=params), Path())
    stage.show(stage.shape("sphere"), material)
    # a Lambertian surface of albedo 0.5 in a uniform radiance of 1 sends 0.5: sRGB 188
    assert abs(int(picture(stage)[24, 24, 0]) - 188) <= 1
    residency.set_material_param(material, "base_color", (1.0, 0.0, 0.0, 1.0))
    assert picture(stage)[24, 24, :3].tolist() == [255, 0, 0], "the row is the runtime's own"


def test_other_shapes_and_materials_take_the_place_of_those_before(stage: MaterialStage) -> None:
    residency = stage.runtime.residency
    unlit = {"features": ["unlit"]}
    red = residency.add_material(MaterialAsset("red", params={"base_color": (1.0, 0.0, 0.0, 1.0)}, **unlit), Path())
    blue = residency.add_material(MaterialAsset("blue", params={"base_color": (0.0, 0.0, 1.0, 1.0)}, **unlit), Path())
    stage.show(stage.shape("sphere"), red)
    round_one = (picture(stage)[..., 0] > 200).sum()
    stage.show(stage.shape("plane"), blue)
    flat = picture(stage)
    assert (flat[..., 2] > 200).sum() > round_one, "a square fills more than a disc"
    assert not ((flat[..., 0] > 200) & (flat[..., 2] < 50)).any(), "nothing of the first is left"


def test_the_runtime_keeps_its_surroundings_when_the_stage_goes(gl_device: Device) -> None:
    runtime = Runtime(gl_device, profile=False)
    runtime.load(SceneAsset("empty", environment=WHITE), Path())
    before = runtime.renderer.environments.get(WHITE)
    stage = MaterialStage(runtime)
    stage.surround(WHITE, LookAsset())
    stage.show(stage.shape("cube"), runtime.residency.default_material)
    picture(stage)
    assert stage.renderer.environments is runtime.renderer.environments
    stage.release()
    assert runtime.renderer.environments.get(WHITE) is before
    runtime.close()
