"""Masks and layers: which nodes, how much, and added to what."""

from __future__ import annotations

import numpy as np
import pytest

from engine.animation import mask, poses
from engine.animation.layers import LayerJob
from engine.animation.sampler import ClipSampler
from engine.assets.clip import ClipAsset
from engine.core.errors import InputError
from tests.animation.crowd import IDENTITY, angle, assert_same_pose, channel, random_poses, rig, turning

# n0 ─┬ n1 ─ n2 ─ n3
#     └ n4 ─ n5
BODY = rig(6, [-1, 0, 1, 2, 0, 4])


def lay(base: np.ndarray, layer: np.ndarray, weight: float, over: object = None, **how: object) -> np.ndarray:
    result = base.copy()
    weights = np.full(base.shape[1], weight)
    job = LayerJob(result, layer, weights, np.ones(base.shape[2]) if over is None else np.array(over), **how)
    job.validate()
    job.run()
    return result


def test_a_subtree_with_fall_off() -> None:
    np.testing.assert_array_equal(mask.subtree(BODY, "n1"), [0, 1, 1, 1, 0, 0])
    np.testing.assert_allclose(mask.subtree(BODY, "n1", 0.9, 2), [0, 0.3, 0.6, 0.9, 0, 0])
    both = mask.combine(BODY, [mask.subtree(BODY, "n1"), mask.subtree(BODY, "n4", 0.5)], {"n3": 0.25})
    np.testing.assert_array_equal(both, [0, 1, 1, 0.25, 0.5, 0.5])


def test_what_no_clip_moves_under_a_mask_is_listed() -> None:
    clip = ClipAsset("c", [channel(2, "rotation", [0], [IDENTITY])])
    assert mask.uncovered(BODY, mask.subtree(BODY, "n1"), [ClipSampler(clip, BODY)]) == ["n1", "n3"]


def test_masks_refuse_nonsense() -> None:
    with pytest.raises(InputError, match="no node 'n9'"):
        mask.subtree(BODY, "n9")
    with pytest.raises(InputError, match=r"weight 1\.5"):
        mask.subtree(BODY, "n1", 1.5)
    with pytest.raises(InputError, match="weight -1"):
        mask.combine(BODY, [], {"n1": -1.0})


def test_an_override_replaces_under_the_mask_and_nothing_else() -> None:
    rng = np.random.default_rng(0)
    base, layer = random_poses(rng, 3, 6), random_poses(rng, 3, 6)
    got = lay(base, layer, 1.0, mask.subtree(BODY, "n1"))
    assert_same_pose(got[:, :, 1:4], layer[:, :, 1:4])
    np.testing.assert_array_equal(got[:, :, [0, 4, 5]], base[:, :, [0, 4, 5]])
    np.testing.assert_array_equal(lay(base, layer, 0.0), base)
    np.testing.assert_array_equal(lay(base, layer, np.nan), base)
    half = lay(base, layer, 0.5)
    np.testing.assert_allclose(half[:3], (base[:3] + layer[:3]) / 2, atol=1e-12)
    # between two rotations, half is half for nlerp too
    whole = angle(base[3:7], layer[3:7])
    np.testing.assert_allclose(angle(base[3:7], half[3:7]), whole / 2, atol=1e-9)


def test_adding_the_layer_to_its_own_reference_gives_the_layer() -> None:
    rng = np.random.default_rng(1)
    reference, layer = random_poses(rng, 1, 6), random_poses(rng, 2, 6)
    base = np.repeat(reference, 2, axis=1)
    assert_same_pose(lay(base, layer, 1.0, mode="additive", reference=reference[:, 0]), layer, 1e-9)


def test_adding_the_reference_itself_changes_nothing() -> None:
    rng = np.random.default_rng(2)
    base, reference = random_poses(rng, 2, 6), random_poses(rng, 1, 6)
    layer = np.repeat(reference, 2, axis=1)
    assert_same_pose(lay(base, layer, 1.0, mode="additive", reference=reference[:, 0]), base, 1e-9)


@pytest.mark.parametrize("weight", [-1.0, -0.5, 0.5, 1.0, 2.0])
def test_additive_weights_scale_the_angle_also_back_and_beyond(weight: float) -> None:
    base, layer = poses.resting(rig(1).rest, 1), poses.resting(rig(1).rest, 1)
    base[3:7, 0, 0], layer[3:7, 0, 0] = turning(1, 0.4), turning(1, 0.6)
    layer[0], layer[7] = 2.0, 4.0
    got = lay(base, layer, weight, mode="additive", reference=rig(1).rest)
    assert angle(got[3:7, 0, 0], turning(1, 0.4 + 0.6 * weight)) < 1e-12
    assert got[0, 0, 0] == pytest.approx(2.0 * weight)
    assert got[7, 0, 0] == pytest.approx(4.0**weight)


def test_forth_and_back_cancel() -> None:
    rng = np.random.default_rng(3)
    base, layer, reference = random_poses(rng, 2, 4), random_poses(rng, 2, 4), random_poses(rng, 1, 4)[:, 0]
    layer[7:], reference[7:] = np.abs(layer[7:]) + 0.1, np.abs(reference[7:]) + 0.1
    there = lay(base, layer, 0.7, mode="additive", reference=reference)
    assert_same_pose(lay(there, layer, -0.7, mode="additive", reference=reference), base, 1e-9)


@pytest.mark.parametrize("scale", [(0.0, 1.0), (1.0, 0.0), (0.0, 0.0), (-1.0, 1.0), (1.0, -1.0), (1e-4, 1e6)])
def test_the_row_zero_scale_and_mirrored_bones_stay_finite(scale: tuple[float, float]) -> None:
    base, layer = poses.resting(rig(1).rest, 1), poses.resting(rig(1).rest, 1)
    reference = rig(1).rest.copy()
    reference[7:], layer[7:] = scale[0], scale[1]
    for weight in (-1.0, 0.5, 1.0):
        if scale[1] == 0.0 and weight < 0.0:
            continue  # away from a flat pose there is no way back
        assert np.isfinite(lay(base, layer, weight, mode="additive", reference=reference)).all()


def test_a_job_says_what_does_not_fit() -> None:
    base = poses.resting(BODY.rest, 2)
    one, full = np.ones(2), np.ones(6)
    for job, words in (
        (LayerJob(base, base[:, :1], one, full), "layer: shape"),
        (LayerJob(base, base, np.ones(3), full), r"weights \(3,\)"),
        (LayerJob(base, base, one, full * 2.0), r"must be in \[0, 1\]"),
        (LayerJob(base, base, one, full, "multiply"), "unknown layer mode"),  # type: ignore[arg-type]  # wrong on purpose
        (LayerJob(base, base, one, full, "additive"), "needs a reference"),
    ):
        with pytest.raises(InputError, match=words):
            job.validate()
