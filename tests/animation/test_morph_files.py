"""Morph targets of glTF, FBX and Ogre files play: the scene's vertices are those of the CPU's own evaluation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.animation.morph import WeightPlayer
from engine.animation.pose import pose_meshes, pose_nodes
from engine.app.posed import posed_positions
from engine.app.runtime import Runtime
from engine.assets.clip import Channel, ClipAsset
from engine.scene.scene import Scene
from importers.convert import convert
from importers.settings import ImportSettings

FILES = (
    "gltf/AnimatedMorphCube/glTF-Binary/AnimatedMorphCube.glb",
    "fbx_ufbx/blender440_shape_weight_anim_7400_binary.fbx",
)


@pytest.mark.parametrize("name", FILES)
def test_vertices_follow_the_weights(name: str, shared_assets: Path, tmp_path: Path, null_device) -> None:
    if not (shared_assets / name).is_file():
        pytest.skip(f"no {name}")
    scene = convert(shared_assets / name, tmp_path / "out", ImportSettings(quality="draft")).scene
    runtime = Runtime(null_device)
    try:
        runtime.open(scene)
        morphs = runtime.scene.morphs
        assert len(morphs) > 0
        clip = runtime.clips[0] if runtime.clips else None
        length = clip.duration if clip is not None else 0.0
        table, moved = runtime.scene.instances, []
        for time in (0.0, 0.37 * length, 0.8 * length):
            runtime.play(*([0] if clip is not None else []), mode="once")
            runtime.update(time)
            pose = pose_nodes(runtime.asset.nodes, clip, time)
            meshes = [info.asset for info in runtime.residency.meshes]
            for posed in pose_meshes(runtime.asset.nodes, meshes, pose):
                row = int(runtime.node_rows[posed.node])
                instance = int(np.flatnonzero(table.node == row)[0])
                ours = posed_positions(runtime.scene, runtime.residency, instance)
                np.testing.assert_allclose(ours, posed.positions, atol=1e-6 * max(1.0, np.abs(ours).max()))
                center, radius = table.world_center[instance], table.world_radius[instance]
                assert np.linalg.norm(ours - center, axis=1).max() <= radius * (1 + 1e-6)
                moved.append(morphs.of_node(row).copy())
        assert any(w.any() for w in moved if len(w)), "some target has a weight at some time"
    finally:
        runtime.close()


def test_weights_of_several_channels_are_played_and_odd_ones_left_out() -> None:
    scene = Scene()
    nodes = scene.nodes.add_many(["a", "b", "c"])
    scene.morphs.add(int(nodes[0]), ["x", "y"], [1.0, 1.0])
    scene.morphs.add(int(nodes[2]), ["z"], [1.0])

    def channel(node: int, values: object, times: object = (0.0, 2.0), kind: str = "linear") -> Channel:
        return Channel(node, "weights", kind, np.array(times, "f4"), np.array(values, "f4"))

    clip = ClipAsset(
        "c",
        [
            channel(0, [[0, 1], [1, 0]]), channel(2, [[0.25], [0.75]], kind="step"), channel(1, [[0], [1]]),
            channel(2, [[1, 2], [3, 4]]), channel(0, [[0, 0], [1, 1]], (1.0, 1.0)), channel(7, [[0], [1]]),
        ],
    )  # fmt: skip
    player = WeightPlayer(clip, np.arange(3), scene.morphs)
    scene.morphs.set(player.numbers, player.sample(0.5))
    np.testing.assert_allclose(scene.morphs.weights, [0.25, 0.75, 0.25])
    assert player.duration == 2.0
    scene.morphs.set(player.numbers, np.full(3, np.nan))
    assert not scene.morphs.weights.any()
