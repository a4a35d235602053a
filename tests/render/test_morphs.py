"""Morph targets in the picture: the GPU draws what the CPU's twin computes, bounds hold it."""

from __future__ import annotations

import numpy as np
import pytest

from engine.animation.morph import morphed, target_reach
from engine.app.posed import posed_positions
from engine.assets.material import MaterialAsset
from engine.assets.mesh import MorphTarget, Skeleton
from engine.assets.primitives import card, cube
from engine.assets.scene import EnvironmentAsset, SceneAsset
from tests.support.stage import surface

LIT = {"kind": "sky", "sun_illuminance": 1.0, "background": "color", "background_color": (0, 0, 0)}


def _give_targets(stage, node: int, mesh, weights=()) -> None:
    names = [t.name for t in mesh.morphs]
    stage.runtime.scene.morphs.add(node, names, target_reach(mesh.morphs), weights)
    stage.runtime.update()


def _targets(mesh, *offsets) -> list[MorphTarget]:
    count = mesh.vertex_count
    return [
        MorphTarget(f"t{i}", {"position": np.broadcast_to(np.asarray(o, "<f4"), (count, 3)).copy()})
        for i, o in enumerate(offsets)
    ]


def _baked(mesh, weights):
    """The mesh with its morphs applied: what the picture must look like."""
    base, normals = mesh.streams["position"], mesh.streams["normal"]
    out = cube() if mesh.name == "cube" else card()
    out.streams = dict(mesh.streams)
    out.streams["position"] = morphed(base, mesh.morphs, weights).astype("<f4")
    bent = morphed(normals[:, :3] / 32767.0, mesh.morphs, weights, "normal")
    bent /= np.linalg.norm(bent, axis=1, keepdims=True)
    out.streams["normal"] = np.rint(np.append(bent, np.zeros((len(bent), 1)), axis=1) * 32767.0).astype("<i2")
    return out


@pytest.mark.gl
def test_the_picture_is_that_of_the_mesh_with_its_targets_applied(stage) -> None:
    """Two targets, of positions and normals, the second mesh of its arena: offsets must be found by base vertex."""
    stage.look(**LIT)
    stage.add(card(), None, (0.0, 0.0, -5.0), 0.1)
    rng = np.random.default_rng(3)
    mesh = cube()
    count = mesh.vertex_count
    for i in range(2):
        # a function of place, so that seams stay shut
        streams = {"position": (mesh.streams["position"] @ rng.normal(size=(3, 3))).astype("<f4") * 0.5}
        if i:
            streams["normal"] = rng.normal(size=(count, 3)).astype("<f4") * 0.3
        mesh.morphs.append(MorphTarget(f"t{i}", streams))
    chalk = surface(metallic=0.0, roughness=1.0)
    node = stage.add(mesh, chalk)
    _give_targets(stage, node, mesh)
    camera = stage.view().camera
    still = stage.hdr(camera=camera)
    assert not any("morph" in v.features for v in stage.runtime.residency.effects.variants())
    stage.runtime.scene.morphs.set_node(node, [0.7, -0.4])
    moved = stage.hdr(camera=camera)
    assert any("morph" in v.features for v in stage.runtime.residency.effects.variants())
    stage.runtime.scene.nodes.set_visible([node], [False])
    stage.add(_baked(mesh, [0.7, -0.4]), chalk)
    truth = stage.hdr(camera=camera)
    assert np.abs(truth - still).max() > 0.1  # the test would see it
    assert np.abs(moved - truth).max() < 2e-3  # normals of 16 bits
    np.testing.assert_allclose(
        posed_positions(stage.runtime.scene, stage.runtime.residency, 1),
        morphed(mesh.streams["position"], mesh.morphs, [0.7, -0.4]), atol=1e-6,
    )  # fmt: skip


@pytest.mark.gl
def test_each_node_has_its_own_weights_and_zero_brings_the_mesh_back(stage) -> None:
    mesh = card()
    mesh.morphs = _targets(mesh, (0.0, 5.0, 0.0))
    node = stage.add(mesh)
    _give_targets(stage, node, mesh)
    camera = stage.view().camera
    stage.look(**LIT)
    left, right = stage.add(mesh), stage.add(mesh)
    for n in (left, right):
        _give_targets(stage, n, mesh)
    both = stage.hdr(camera=camera)
    stage.runtime.scene.morphs.set_node(left, [1.0])
    one = stage.hdr(camera=camera)
    assert np.array_equal(one, both)  # the other one still covers the same pixels
    stage.runtime.scene.morphs.set_node(right, [1.0])
    assert stage.hdr(camera=camera)[..., :3].sum() != one[..., :3].sum()
    stage.runtime.scene.morphs.set_node(left, [0.0])
    assert np.array_equal(stage.hdr(camera=camera), both)


def test_bounds_follow_the_weights(null_stage) -> None:
    mesh = cube()
    mesh.morphs = _targets(mesh, (3.0, 0.0, 0.0), (0.0, 4.0, 0.0))
    node = null_stage.add(mesh, scale=2.0)
    _give_targets(null_stage, node, mesh, [0.0, 0.0])
    table = null_stage.runtime.scene.instances
    small = float(table.world_radius[0])
    null_stage.runtime.scene.morphs.set_node(node, [1.0, 0.5])
    null_stage.runtime.update()
    assert table.world_radius[0] == pytest.approx(small + 2.0 * (3.0 + 2.0), rel=1e-6)
    points = posed_positions(null_stage.runtime.scene, null_stage.runtime.residency, 0)
    assert (np.linalg.norm(points - table.world_center[0], axis=1) <= table.world_radius[0]).all()
    null_stage.runtime.scene.morphs.set_node(node, [0.0, 0.0])
    null_stage.runtime.update()
    assert table.world_radius[0] == pytest.approx(small, rel=1e-6)


def test_bounds_of_a_skinned_mesh_follow_too(null_stage) -> None:
    mesh = cube()
    mesh.streams |= {"joints": np.zeros((24, 4), "<u2"), "weights": np.tile(np.array([65535, 0, 0, 0], "<u2"), (24, 1))}
    mesh.skeleton = Skeleton(["a"], np.array([-1], np.int32), np.eye(4, dtype="<f4")[None])
    mesh.morphs = _targets(mesh, (3.0, 0.0, 0.0))
    scene = null_stage.runtime.scene
    joint = scene.nodes.add("joint", translation=(1.0, 0.0, 0.0), scale=(2.0, 2.0, 2.0))
    node = null_stage.add(mesh)
    scene.skins.add(node, [joint], mesh.skeleton.inverse_bind, [1.0])
    _give_targets(null_stage, node, mesh)
    scene.morphs.set_node(node, [1.0])
    scene.update()
    points = posed_positions(scene, null_stage.runtime.residency, 0)
    table = scene.instances
    assert np.linalg.norm(points - table.world_center[0], axis=1).max() <= table.world_radius[0]
    assert points[:, 0].max() == pytest.approx(1.0 + 2.0 * 3.5)


def test_a_removed_node_takes_its_weights_along_and_brings_them_back(null_stage) -> None:
    from engine.scene.patch import difference, put, remember

    mesh = cube()
    mesh.morphs = _targets(mesh, (3.0, 0.0, 0.0))
    scene = null_stage.runtime.scene
    node = null_stage.add(mesh)
    _give_targets(null_stage, node, mesh, [0.5])
    before = remember(scene)
    scene.remove([node])
    patch = difference(scene, before)
    again = scene.nodes.add("other")
    assert again == node
    assert len(scene.morphs.of_node(again)) == 0
    scene.remove([again])
    put(scene, patch.before)
    assert scene.morphs.of_node(node).tolist() == [0.5]


@pytest.mark.gl
@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_dual_quaternions_on_the_gpu_are_those_of_the_cpu(stage, mirror: float) -> None:
    """A bar twisted by 150 degrees: linear blending collapses its middle, dual quaternions keep it; and the twin."""
    from engine.animation.reach import joint_reach
    from engine.math import quat

    stage.look(**LIT)
    mesh = cube()
    right = np.asarray(mesh.streams["position"])[:, 0] > 0
    weights = np.zeros((24, 4), "<u2")
    weights[:, 1] = np.where(right, 39321, 26214)
    weights[:, 0] = 65535 - weights[:, 1]
    joints = np.zeros((24, 4), "<u2")
    joints[:, 1] = 1
    mesh.streams |= {"joints": joints, "weights": weights}
    mesh.skeleton = Skeleton(["a", "b"], np.array([-1, 0], np.int32), np.tile(np.eye(4, dtype="<f4"), (2, 1, 1)))
    scene = stage.runtime.scene
    nodes = [scene.nodes.add("a", scale=(mirror, 1.0, 1.0)), scene.nodes.add("b", translation=(0.1, 0.2, 0.0))]
    scene.nodes.set_rotation([nodes[1]], [quat.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.radians(150.0))])
    scene.nodes.set_scale([nodes[1]], [(mirror, 1.5, 1.0)])
    node = stage.add(mesh)
    bind = mesh.skeleton.inverse_bind
    skin = scene.skins.add(node, nodes, bind, joint_reach(mesh.streams["position"], joints, weights, bind))
    stage.runtime.update()
    camera = stage.view().camera
    linear = stage.hdr(camera=camera)
    scene.skins.set_method(skin, "dual_quaternion")
    dual = stage.hdr(camera=camera)
    points = posed_positions(scene, stage.runtime.residency, 0)
    assert np.abs(dual - linear).max() > 0.1
    scene.nodes.set_visible([node], [False])
    twin = cube()
    twin.streams["position"] = points.astype("<f4")
    stage.add(twin)
    if mirror < 0.0:
        twin.indices = twin.indices.reshape(-1, 3)[:, ::-1].reshape(-1).copy()
    covered = stage.hdr(camera=camera)[..., :3].sum(axis=2) > 0
    assert np.count_nonzero(covered != (dual[..., :3].sum(axis=2) > 0)) <= 2


def _twisted(stage, material=None) -> int:
    """A cube between two joints, the second turned by 150 degrees; its skin."""
    from engine.animation.reach import joint_reach
    from engine.math import quat

    mesh = cube()
    right = np.asarray(mesh.streams["position"])[:, 0] > 0
    weights, joints = np.zeros((24, 4), "<u2"), np.zeros((24, 4), "<u2")
    weights[:, 1] = np.where(right, 39321, 26214)
    weights[:, 0], joints[:, 1] = 65535 - weights[:, 1], 1
    mesh.streams |= {"joints": joints, "weights": weights}
    mesh.skeleton = Skeleton(["a", "b"], np.array([-1, 0], np.int32), np.tile(np.eye(4, dtype="<f4"), (2, 1, 1)))
    scene = stage.runtime.scene
    nodes = [scene.nodes.add("a"), scene.nodes.add("b")]
    scene.nodes.set_rotation([nodes[1]], [quat.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.radians(150.0))])
    bind = mesh.skeleton.inverse_bind
    reach = joint_reach(mesh.streams["position"], joints, weights, bind)
    skin = scene.skins.add(stage.add(mesh, material), nodes, bind, reach)
    stage.runtime.update()
    return skin


@pytest.mark.gl
def test_an_effect_without_dual_quaternions_skins_linearly_and_says_so(stage, tmp_path) -> None:
    from engine.core.paths import shaders_dir

    text = (shaders_dir() / "effects/surface.effect.toml").read_text()
    begin = text.index("[features.dual_quaternion]")
    text = text[:begin] + text[text.index("[features.morph]") :]
    (tmp_path / "effects").mkdir()
    own = text.replace(', "dual_quaternion"', "").replace('name = "surface"', 'name = "own"')
    (tmp_path / "effects/own.effect.toml").write_text(own)
    asset = SceneAsset("stage", environment=EnvironmentAsset(**LIT))
    asset.look.tone_map = "none"
    stage.runtime.load(asset, tmp_path, shaders=[tmp_path])
    skin = _twisted(stage, MaterialAsset("own", effect="own"))
    scene, renderer = stage.runtime.scene, stage.runtime.renderer
    camera = stage.view().camera
    linear = stage.hdr(camera=camera)
    assert not list(renderer.skin_findings)
    scene.skins.set_method(skin, "dual_quaternion")
    asked = stage.hdr(camera=camera)
    assert [f.code for f in renderer.skin_findings] == ["skin.effect"]
    assert np.array_equal(asked, linear)
    assert linear[..., :3].max() > 0.05
    points = posed_positions(scene, stage.runtime.residency, 0)
    scene.skins.set_method(skin, "linear")
    np.testing.assert_array_equal(points, posed_positions(scene, stage.runtime.residency, 0))
    # the built-in effect blends as it is told
    stage.look(**LIT)
    skin = _twisted(stage)
    linear = stage.hdr(camera=camera)
    stage.runtime.scene.skins.set_method(skin, "dual_quaternion")
    assert np.abs(stage.hdr(camera=camera) - linear).max() > 0.05
    assert not list(stage.runtime.renderer.skin_findings)


@pytest.mark.gl
def test_force_all_morphs_what_rests_to_the_same_bits(stage) -> None:
    """Targets of positions and normals that never had a weight: pruned, no shader knows of them; forced, all do."""
    stage.look(**LIT)
    mesh, rng = cube(), np.random.default_rng(1)
    offsets = {name: rng.normal(size=(24, 3)).astype("<f4") for name in ("position", "normal")}
    mesh.morphs = [MorphTarget("t", offsets)]
    node = stage.add(mesh, surface(metallic=0.0, roughness=0.5))
    _give_targets(stage, node, mesh)
    camera = stage.view().camera
    pruned = stage.hdr(camera=camera)
    effects = stage.runtime.residency.effects
    assert not any("morph" in v.features for v in effects.variants())
    forced = stage.hdr(camera=camera, force_all=True)
    assert any("morph" in v.features for v in effects.variants())
    assert np.ptp(pruned[..., :3]) > 0.1
    assert np.array_equal(forced, pruned)
    stage.runtime.scene.morphs.set_node(node, [0.5])
    bent = stage.hdr(camera=camera)
    assert not np.array_equal(bent, pruned)
    assert np.array_equal(stage.hdr(camera=camera, force_all=True), bent)
    stage.runtime.scene.morphs.set_node(node, [0.0])
    assert np.array_equal(stage.hdr(camera=camera), pruned)


@pytest.mark.gl
def test_the_views_of_weights_colour_bones_and_counts(stage) -> None:
    """Left half on joint 0 alone, right half on two: other colours for each, grey where there is no skin."""
    stage.look(**LIT)
    mesh = card()
    right = np.asarray(mesh.streams["position"])[:, 0] > 0
    weights, joints = np.zeros((len(right), 4), "<u2"), np.zeros((len(right), 4), "<u2")
    weights[:, 0], weights[:, 1], joints[:, 1] = np.where(right, 32768, 65535), np.where(right, 32767, 0), 1
    mesh.streams |= {"joints": joints, "weights": weights}
    mesh.skeleton = Skeleton(["a", "b"], np.array([-1, 0], np.int32), np.tile(np.eye(4, dtype="<f4"), (2, 1, 1)))
    scene = stage.runtime.scene
    nodes = [scene.nodes.add("a"), scene.nodes.add("b")]
    node = stage.add(mesh)
    camera = stage.view().camera
    grey = stage.hdr(camera=camera, view="weights")[32, 32, :3]
    assert np.ptp(grey) < 1e-3
    scene.skins.add(node, nodes, mesh.skeleton.inverse_bind, [1.0, 1.0])
    counts = stage.hdr(camera=camera, view="influences")
    left, far = counts[32, 12, :3], counts[32, 52, :3]
    assert left[2] > left[1]  # one joint: blue
    assert far[1] > far[2]  # two: green
    bones = stage.hdr(camera=camera, view="weights")
    assert np.abs(bones[32, 12, :3] - bones[32, 52, :3]).max() > 0.05
