"""Key reduction and quantisation stay within the error that they were given, measured at the skin."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.animation import poses
from engine.animation.compress import clip_nbytes, coding_error, compress, compress_channel
from engine.animation.key_reduction import reduce_channel, reduce_clip, skin_budget
from engine.animation.reach import joint_reach
from engine.animation.rig import rig_of
from engine.animation.sampler import ClipSampler
from engine.assets.clip import ClipAsset
from engine.assets.key_codes import BOX, LARGEST, WITHOUT, candidates, decode_largest, encode_largest
from engine.assets.lanim import read_lanim, write_lanim
from engine.assets.lmesh import read_lmesh
from engine.assets.scene_json import read_scene
from engine.core.errors import InputError
from engine.math import quat
from engine.math.transform import compose
from importers.convert import convert
from importers.settings import ImportSettings
from tests.animation.crowd import angle, channel, random_clip, random_rotations, rig, turning

#: radians that 15-bit components may turn a rotation by: 2 |dq|, three components half a step of sqrt(2)/32767 off
#: each, the fourth up to three times one of them
LARGEST_ERROR = 2.0 * np.sqrt(3.0 + 9.0) * 0.5 * np.sqrt(2.0) / 32767.0


def test_rotations_in_six_bytes() -> None:
    q = random_rotations(np.random.default_rng(0), 200_000).T
    q = np.concatenate([q, np.eye(4), -np.eye(4), np.full((1, 4), 0.5), np.array([[1, 1, 0, 0]]) / np.sqrt(2.0)])
    off = quat.angle_between(q, decode_largest(encode_largest(q)))
    assert off.max() <= LARGEST_ERROR
    assert off.max() > 0.2 * LARGEST_ERROR  # the bound is no fairy tale
    assert encode_largest(q).nbytes == 6 * len(q)


def test_each_coding_is_off_by_what_it_says_and_near_rotations_by_far_less() -> None:
    rng = np.random.default_rng(3)
    for spread, kinds in ((0.05, (WITHOUT + 3, LARGEST, BOX)), (3.0, (LARGEST, BOX))):
        q = quat.normalize(rng.normal(size=(500, 4)) * spread + np.array([0.0, 0.0, 0.0, 1.0]))
        q[::3] *= -1.0  # the same rotations
        found = {c.coding: c for c in candidates(q)}
        assert tuple(found) == kinds
        for codes in found.values():
            told = coding_error(codes, q)
            true = quat.angle_between(q, quat.normalize(codes.decode()))
            assert (told >= true - 1e-12).all()
            assert (told <= true * 1.01 + 1e-7).all()
            assert told.max() <= (LARGEST_ERROR if codes.coding == LARGEST else 1e-5 if spread < 1.0 else 1e-4)
    values = rng.normal(size=(300, 3)) * [1e-3, 5.0, 0.0] + [100.0, 0.0, -7.0]
    (box,) = candidates(values)
    off = coding_error(box, values)
    assert 0.0 < off.max() <= 0.5 * 10.0 * 3.5 / 65535.0 + 100.0 * 2.0**-23
    assert (box.decode()[:, 2] == -7.0).all()


def test_exact_where_the_budget_does_not_allow_16_bits() -> None:
    times = np.linspace(0, 4, 200)
    channel_ = channel(0, "rotation", times, random_rotations(np.random.default_rng(4), 200).T)
    exact = compress_channel(channel_, 1e-9)
    assert exact.codes is None
    np.testing.assert_array_equal(exact.values, channel_.values)
    coded = compress_channel(channel_, 1e-3)
    assert coded.codes is not None
    assert coded.codes.nbytes < 0.5 * channel_.values.nbytes
    few = channel(0, "scale", [0.0, 1.0], [[1, 1, 1], [2, 2, 2]])
    assert compress_channel(few, 1e-2).codes is None  # a box's range would be more than it saves


@pytest.mark.parametrize("tolerance", [1e-3, 1e-2, 0.1])
@pytest.mark.parametrize(("path", "width"), [("translation", 3), ("rotation", 4), ("scale", 3)])
def test_a_reduced_channel_stays_within_its_tolerance(path: str, width: int, tolerance: float) -> None:
    rng = np.random.default_rng(1)
    times = np.sort(rng.uniform(0, 4, 200))
    values = np.cumsum(rng.normal(size=(200, width)) * 0.02, axis=0) + 1.0
    before = channel(0, path, times, values)
    after = reduce_channel(before, tolerance)
    assert after.times[0] == before.times[0]
    assert after.times[-1] == before.times[-1]
    a, b = poses.resting(rig(1).rest, 3000), poses.resting(rig(1).rest, 3000)
    dense = np.linspace(0, 4, 3000)
    ClipSampler(ClipAsset("a", [before]), rig(1)).sample(dense, a)
    ClipSampler(ClipAsset("b", [after]), rig(1)).sample(dense, b)
    if path == "rotation":
        off = angle(a[3:7], b[3:7])
    else:
        off = np.linalg.norm(a[poses.ROWS[path]] - b[poses.ROWS[path]], axis=0)
    assert off.max() <= tolerance * 1.01
    if tolerance == 0.1:
        assert len(after.times) < 100


def test_straight_ways_keep_their_ends_only() -> None:
    times = np.linspace(0, 1, 50)
    line = channel(0, "translation", times, times[:, None] * np.array([1.0, 2.0, 3.0]))
    turn = channel(0, "rotation", times, [turning(1, 2.0 * t) for t in times])
    assert len(reduce_channel(line, 1e-5).times) == 2
    assert len(reduce_channel(turn, 1e-5).times) == 2
    still = channel(0, "scale", times, np.ones((50, 3)))
    assert len(reduce_channel(still, 1e-5).times) == 1
    assert len(reduce_channel(still, 1e-5, keep_last=True).times) == 2
    steps = channel(0, "translation", times, np.repeat([[0, 0, 0], [1, 0, 0]], 25, axis=0), "step")
    assert reduce_channel(steps, 1e-5).times.tolist() == [times[0], np.float32(times[25]), times[-1]]


def test_the_length_stays_and_cubic_and_weights_are_left_alone() -> None:
    clip = random_clip(np.random.default_rng(2), 3, shared=False, interpolation="cubic")
    clip.channels.append(channel(0, "weights", [0.0, 1.0], [[0.0], [1.0]]))
    budget = {(c.node, c.path): 0.1 for c in clip.channels}
    for made in (reduce_clip(clip, budget), compress(clip, budget)):
        for a, b in zip(clip.channels, made.channels, strict=True):
            np.testing.assert_array_equal(a.values, b.values)
            np.testing.assert_array_equal(a.times, b.times)
    still = ClipAsset("still", [channel(0, "scale", [0.0, 2.0], np.ones((2, 3)))])
    assert reduce_clip(still, {(0, "scale"): 0.1}).duration == 2.0
    assert compress(still, {(0, "scale"): 0.1}).duration == 2.0


def test_a_budget_needs_an_error() -> None:
    for bad in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match="at the skin"):
            skin_budget(ClipAsset("c"), [], [], [], [], bad)


@pytest.mark.parametrize("name", ["CesiumMan", "BrainStem", "RiggedFigure"])
def test_no_vertex_is_off_by_more_than_was_asked(name: str, shared_assets: Path, tmp_path: Path) -> None:
    source = shared_assets / "gltf" / name / "glTF-Binary" / f"{name}.glb"
    if not source.is_file():
        pytest.skip(f"no {name}")
    path = convert(source, tmp_path / "out", ImportSettings(quality="draft", key_error_mm=0.0)).scene
    asset = read_scene(path)
    clip = read_lanim(path.parent / asset.clips[0])
    meshes = read_lmesh(path.parent / next(n.mesh.file for n in asset.nodes if n.mesh))
    skinned = [(n, meshes[n.mesh.index]) for n in asset.nodes if n.mesh and n.joints]
    reach = np.zeros(len(asset.nodes))
    for node, mesh in skinned:
        own = joint_reach(
            mesh.streams["position"], mesh.streams["joints"], mesh.streams["weights"], mesh.skeleton.inverse_bind
        )
        np.maximum.at(reach, node.joints, own)
    everything = rig_of(asset.nodes)
    times = np.linspace(0.0, clip.duration, 150)
    truth = skin(everything, ClipSampler(clip, everything), times, skinned)
    for error in (1e-2, 1e-3, 1e-4):
        budget = skin_budget(
            clip, [n.parent for n in asset.nodes], everything.rest[0:3].T, everything.rest[7:10].T, reach, error
        )
        packed = compress(clip, budget)
        write_lanim(tmp_path / "packed.lanim", packed)
        off = skin(everything, ClipSampler(read_lanim(tmp_path / "packed.lanim"), everything), times, skinned) - truth
        worst = float(np.linalg.norm(off, axis=-1).max())
        assert worst <= error
        assert clip_nbytes(packed) < clip_nbytes(clip)


def skin(rig_, sampler: ClipSampler, times: np.ndarray, skinned: list) -> np.ndarray:
    """f8[times, vertices, 3]: every eleventh vertex, in float64."""
    pose = poses.resting(rig_.rest, len(times))
    sampler.sample(times, pose)
    local = compose(np.moveaxis(pose[0:3], 0, -1), np.moveaxis(pose[3:7], 0, -1), np.moveaxis(pose[7:10], 0, -1))
    world = local.copy()
    for i, parent in enumerate(rig_.parent):
        if parent >= 0:
            world[:, i] = world[:, parent] @ local[:, i]
    parts = []
    for node, mesh in skinned:
        pick = slice(None, None, 11)
        joints, weights = mesh.streams["joints"][pick].astype(int), mesh.streams["weights"][pick] / 65535.0
        matrices = world[:, node.joints] @ mesh.skeleton.inverse_bind
        place = np.concatenate([mesh.streams["position"][pick], np.ones((len(joints), 1))], axis=1)
        posed = np.zeros((len(times), len(joints), 4))
        for k in range(joints.shape[1]):
            posed += weights[:, k, None] * np.einsum("tnij,nj->tni", matrices[:, joints[:, k]], place)
        parts.append(posed[..., :3])
    return np.concatenate(parts, axis=1)
