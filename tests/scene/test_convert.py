from __future__ import annotations

import math

import numpy as np
import pytest

from engine.assets.scene import CameraAsset, EnvironmentAsset, LightAsset, LookAsset, MeshRef, NodeAsset, SceneAsset
from engine.scene.scene import Scene


@pytest.fixture
def asset() -> SceneAsset:
    shear = (1.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 4.0, 5.0, 6.0, 1.0)
    return SceneAsset(
        "s",
        [
            NodeAsset("root", translation=(1.0, 0.0, 0.0)),
            NodeAsset("mesh", 0, mesh=MeshRef("a.lmesh", 2, "m", ["x"]), joints=[0, 3], weights=[0.5], extras={"k": 1}),
            NodeAsset("sun", 0, light=LightAsset("directional", (1.0, 0.5, 0.25), 2.0)),
            NodeAsset("sheared", 1, translation=(4.0, 5.0, 6.0), matrix=shear),
            NodeAsset("eye", -1, camera=CameraAsset(yfov=0.5), visible=False),
        ],
        clips=["walk.lanim"],
        environment=EnvironmentAsset("uniform", intensity=2.0),
        look=LookAsset(1.0, "agx"),
        active_camera=4,
        provenance={"source": "x.glb"},
    )


def test_loads_what_the_asset_says(asset: SceneAsset) -> None:
    scene = Scene.from_asset(asset)
    assert len(scene.findings) == 0
    assert scene.row_of_node.tolist() == [0, 1, 2, 3, 4]
    assert np.allclose(scene.nodes.world_matrix(3)[0], [1, 0.5, 0, 5])
    assert scene.lights.world()["radiant"][0].tolist() == [2.0, 1.0, 0.5]
    assert scene.active_camera == 4
    assert not scene.nodes.visible_world[4]
    assert scene.look == LookAsset(1.0, "agx")
    assert scene.look is not asset.look


def test_saves_what_it_loaded(asset: SceneAsset) -> None:
    back = Scene.from_asset(asset).to_asset(asset)
    assert back.nodes[3].matrix == pytest.approx(asset.nodes[3].matrix)
    for node in (*back.nodes, *asset.nodes):
        node.matrix = None
    trs = back.nodes[3]
    asset.nodes[3].rotation, asset.nodes[3].scale = trs.rotation, trs.scale
    assert back == asset


def test_edits_are_saved_and_indices_follow(asset: SceneAsset) -> None:
    scene = Scene.from_asset(asset)
    scene.nodes.set_translation(0, [7, 8, 9])
    new = scene.nodes.add("new")
    scene.nodes.reparent(0, new)
    scene.remove(2)
    scene.update()
    back = scene.to_asset(asset)
    names = [n.name for n in back.nodes]
    assert sorted(names) == ["eye", "mesh", "new", "root", "sheared"]
    for index, node in enumerate(back.nodes):
        assert -1 <= node.parent < index
    by_name = {n.name: n for n in back.nodes}
    assert back.nodes[by_name["root"].parent].name == "new"
    assert by_name["root"].translation == (7.0, 8.0, 9.0)
    assert [names[j] for j in by_name["mesh"].joints] == ["root", "sheared"]
    assert names[back.active_camera] == "eye"
    assert scene.row_of_node.tolist() == [0, 1, -1, 3, 4]
    assert Scene.from_asset(back).to_asset(back) == back


def test_nonsense_is_mended_and_noted() -> None:
    asset = SceneAsset(
        "bad",
        [
            NodeAsset("a", 5, translation=(math.nan, 0.0, 0.0)),
            NodeAsset("b", 0, rotation=(0.0, 0.0, 0.0, 0.0), scale=(math.inf, 1.0, 1.0)),
            NodeAsset("c", 1, matrix=(1.0, 2.0)),
            NodeAsset("d", 3, light=LightAsset("laser", intensity=-1.0)),
        ],
        active_camera=99,
    )
    scene = Scene.from_asset(asset)
    assert np.isfinite(scene.nodes.world).all()
    assert np.allclose(scene.nodes.world, np.eye(3, 4))
    assert scene.nodes.parent.tolist() == [-1, 0, 1, -1]
    codes = sorted(f.code for f in scene.findings)
    assert codes.count("scene.parent") == 2
    assert codes.count("scene.number") == 2
    assert {"scene.rotation", "scene.matrix", "light.type", "light.range-of-value"} <= set(codes)
    assert all(f.where.path.startswith("nodes[") for f in scene.findings)


def test_empty_scene_round_trip() -> None:
    asset = SceneAsset("empty")
    assert Scene.from_asset(asset).to_asset() == asset
