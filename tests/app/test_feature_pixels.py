"""Features that change no pixel are found, those that do are not blamed, and all is as before."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from engine.app.feature_pixels import FeatureEffect, feature_effects, idle_features, measured, views_of
from engine.app.headless import render_hdr
from engine.app.runtime import Runtime
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.primitives import cube, uv_sphere
from engine.assets.scene import EnvironmentAsset, SceneAsset
from engine.gpu.types import Device

SIZE = (48, 32)


@pytest.fixture
def runtime(gl_device: Device) -> Iterator[Runtime]:
    """A sphere, closed, `double_sided` for nothing; a cube, unlit; a sphere with a texture that is plain white."""
    made = Runtime(gl_device, profile=False)
    look = EnvironmentAsset("uniform", color=(0.3, 0.4, 0.5), background="color", sun_illuminance=2.0)
    made.load(SceneAsset("features", environment=look), Path())
    meshes = made.residency.add_meshes([uv_sphere(), cube()])
    assets = (
        (0, MaterialAsset("ball", features=["double_sided"])),
        (1, MaterialAsset("sign", features=["unlit"], params={"base_color": (0.5, 0.1, 0.1, 1.0)})),
        (0, MaterialAsset("missing", textures={"occlusion_map": TextureRef("")})),
    )
    for i, (mesh, asset) in enumerate(assets):
        node = made.scene.nodes.add(asset.name, -1, (1.3 * i, 0.0, 0.0))
        made.add_instances([(node, meshes[mesh], 0, made.residency.add_material(asset, Path()))])
    made.update()
    yield made
    made.close()


def test_each_feature_gets_its_verdict(runtime: Runtime) -> None:
    views = views_of(runtime, size=SIZE)
    before = [np.array(render_hdr(runtime, view)[0]) for view in views]
    known = runtime.residency.effects.variants()
    found = measured(runtime, views)
    verdicts = {(item.materials, item.feature): item.verdict for item in found}
    assert verdicts == {
        (("ball",), "double_sided"): "never changes a pixel",
        (("sign",), "unlit"): "changes pixels",
        (("missing",), "occlusion_map"): "never changes a pixel",
    }
    assert all(item.covered > 100 for item in found)
    unlit = next(item for item in found if item.feature == "unlit")
    assert 0 < unlit.changed <= unlit.covered
    assert unlit.largest > 0.01
    assert idle_features(found) == {"surface": ["double_sided", "occlusion_map"]}
    assert runtime.residency.effects.variants() == known
    after = [np.array(render_hdr(runtime, view)[0]) for view in views]
    np.testing.assert_array_equal(after, before)


def test_called_off_midway_all_is_as_before(runtime: Runtime) -> None:
    views = views_of(runtime, size=SIZE)[:1]
    before = np.array(render_hdr(runtime, views[0])[0])
    run = feature_effects(runtime, views)
    for _ in range(3):
        fraction, text = next(run)
    assert 0.0 < fraction < 1.0
    assert text
    run.close()
    np.testing.assert_array_equal(np.array(render_hdr(runtime, views[0])[0]), before)


def test_what_is_not_seen_is_not_judged() -> None:
    hidden = FeatureEffect("surface", frozenset({"a", "b"}), "a", ("m",), 0)
    assert hidden.verdict == "not seen"
    shown = FeatureEffect("surface", frozenset({"a"}), "a", ("n",), 50, 3, 0.1)
    broken = FeatureEffect("surface", frozenset({"b"}), "b", ("o",), 50, 0, 0.0, "it does not compile")
    assert idle_features([hidden]) == {}
    assert idle_features([hidden, shown, broken]) == {}
    assert broken.verdict == "cannot be drawn without it"
