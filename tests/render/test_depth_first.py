"""Depth drawn before anything is shaded: the same bits, on every path, and no surface shaded in vain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine.assets.primitives import card, uv_sphere
from engine.assets.scene import LightAsset
from engine.gpu.types import Device
from engine.render.lighting import PATHS
from tests.support.stage import Stage


def crowd(stage: Stage, surface) -> None:
    stage.look(kind="uniform", color=(0.4, 0.5, 0.6), sun_illuminance=2.0)
    for i in range(4):
        material = surface(base_color=(0.9, 0.3 * i, 0.2, 1.0), roughness=0.4)
        material.queue = ("opaque", "alpha_test", "opaque", "transparent")[i]
        stage.add(uv_sphere(16, 8) if i % 2 else card(1.5), material, (0.2 * i, 0.1 * i, -0.5 * i))
    stage.lamp(LightAsset("point", intensity=4.0, range=9.0), (0.2, 0.0, 1.0))


@pytest.mark.gl
@pytest.mark.parametrize("settings", [*({"path": path} for path in PATHS), {"path": "forward", "samples": 4}], ids=str)
def test_the_picture_is_the_same(stage, surface, settings) -> None:
    crowd(stage, surface)
    plain = stage.ldr(**settings)
    assert len(np.unique(plain)) > 20
    assert np.array_equal(stage.ldr(depth_first=True, **settings), plain)


@pytest.mark.gl
def test_it_is_there_for_who_asks(stage, surface) -> None:
    crowd(stage, surface)
    taken = {
        asked: {item.name for item in stage.runtime.render(stage.view(depth_first=asked, path="forward")).graph.passes}
        for asked in (False, True)
    }
    assert taken[True] - taken[False] == {"depth_prepass"}
    hidden = stage.view(depth_first=True, view="overdraw")
    assert "depth_prepass" not in {item.name for item in stage.runtime.render(hidden).graph.passes}, (
        "it shows all of it"
    )


def test_programs_beside_the_picture_are_wanted_ahead(null_device: Device, surface) -> None:
    """All that a frame asks of the library was wanted before: depth, how far things moved, layers, tints."""
    stage = Stage(null_device)
    crowd(stage, surface)
    renderer, scene = stage.runtime.renderer, stage.runtime.scene
    view = replace(
        stage.view(antialias="taa", gi="one", translucent_shadows=True, shadow_size=64, depth_first=True), seconds=0.02
    )
    for step in range(2):
        scene.nodes.set_translation([1], [(0.1 * step, 0.0, 0.0)])
        frame = renderer.render(scene, view)
    assert frame.facts.moving
    roles = {variant.request.role for variant in stage.runtime.residency.effects.variants()}
    assert {"motion", "layer", "tint", "depth"} <= roles
    wanted = set(renderer.variants.wanted(frame.facts))
    asked = {variant.request for variant in stage.runtime.residency.effects.variants()}
    missing = {request for request in asked - wanted if request.role in roles - {"forward", "shadow"}}
    assert not missing
    stage.close()
