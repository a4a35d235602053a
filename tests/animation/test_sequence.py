"""Timelines: blocks blend and fade as they say, tracks lie over each other, root motion adds up, markers occur."""

from __future__ import annotations

import numpy as np
import pytest

from engine.animation.events import Marker
from engine.animation.graph import ClipUse
from engine.animation.poses import R, T
from engine.animation.root_motion import extract
from engine.animation.sampler import ClipSampler
from engine.animation.sequence import Block, Sequence, Track
from engine.assets.clip import ClipAsset
from tests.animation.crowd import angle, channel, rig, sampler, slide, still, turning


def _x(sequence: Sequence, times: list[float]) -> np.ndarray:
    return sequence.pose(times)[0, :, 0]


def _one(*blocks: Block, clips: list[ClipAsset], markers: list[list[Marker]] | None = None) -> Sequence:
    marks = markers or [[] for _ in clips]
    uses = [ClipUse(sampler(c), m) for c, m in zip(clips, marks, strict=True)]
    return Sequence(rig(1), uses, [Track("t", list(blocks), np.ones(1))])


def test_a_block_plays_its_clip_from_its_offset_at_its_speed_and_rests_outside() -> None:
    sequence = _one(Block(0, 1.0, 2.0, offset=0.25, speed=0.5, play="once"), clips=[slide(1.0, 1.0)])
    assert _x(sequence, [0.9, 1.0, 1.5, 2.5, 3.0, 3.1]) == pytest.approx([0.0, 0.25, 0.5, 1.0, 1.0, 0.0])
    assert sequence.duration == 3.0


def test_what_happens_past_a_clips_end() -> None:
    for play, expected in (("loop", [0.25, 0.75]), ("ping-pong", [0.75, 0.25]), ("once", [1.0, 1.0])):
        sequence = _one(Block(0, 0.0, 4.0, play=play), clips=[slide(1.0, 1.0)])
        assert _x(sequence, [1.25, 1.75]) == pytest.approx(expected), play


@pytest.mark.parametrize("curve", ["linear", "smooth", "ease_in"])
def test_a_cross_fade_goes_from_one_block_to_the_other(curve: str) -> None:
    from engine.animation.blend import fade

    sequence = _one(
        Block(0, 0.0, 2.0, fade_out=1.0, curve=curve),
        Block(1, 1.0, 2.0, fade_in=1.0, curve=curve), clips=[still(0.0), still(1.0)],
    )  # fmt: skip
    assert _x(sequence, [0.5, 1.3, 2.5]) == pytest.approx([0.0, float(fade(0.3, curve)), 1.0])


def test_a_cross_fade_by_two_curves_does_not_dip_to_rest() -> None:
    """Out by ease_in's complement, in by ease_in and by ease_out: their levels do not sum to 1 by themselves."""
    for out, into in (("ease_out", "ease_in"), ("linear", "smoother"), ("ease_in", "ease_out")):
        sequence = _one(
            Block(0, 0.0, 2.0, fade_out=1.0, curve=out), Block(1, 1.0, 2.0, fade_in=1.0, curve=into),
            clips=[still(1.0), still(1.0)],
        )  # fmt: skip
        times = np.linspace(0.0, 3.0, 61)
        np.testing.assert_allclose(_x(sequence, list(times)), 1.0, atol=1e-12)
        heard = sequence.audible([1.4])
        assert sum(level for *_, level, _ in heard) >= 1.0 - 1e-12
    # a fade out that began before the other block: what lies below shows, without a jump
    partly = _one(
        Block(0, 0.0, 2.0, fade_out=1.0, curve="linear"), Block(1, 1.5, 2.0, fade_in=0.5, curve="linear"),
        clips=[still(1.0), still(1.0)],
    )  # fmt: skip
    assert _x(partly, [1.25, 1.5 - 1e-9, 1.5]) == pytest.approx([0.75, 0.5, 0.5])


def test_a_fade_with_nothing_below_goes_to_rest() -> None:
    sequence = _one(Block(0, 0.0, 2.0, fade_out=1.0, curve="linear"), clips=[still(1.0)])
    assert _x(sequence, [0.5, 1.25, 2.0]) == pytest.approx([1.0, 0.75, 0.0])


def test_synced_blocks_stay_in_step_through_the_fade() -> None:
    """Walk takes 2 s a cycle, run 1 s: before the fade the phase runs at 1/2 a second, after it at 1, and in between
    both clips are at the same phase."""
    walk, run = slide(2.0, 1.0, "walk"), slide(1.0, 1.0, "run")
    sequence = _one(
        Block(0, 0.0, 3.0, fade_out=1.0, sync=True), Block(1, 2.0, 3.0, fade_in=1.0, sync=True), clips=[walk, run]
    )
    track = sequence.tracks[0]
    times = np.linspace(2.0, 3.0, 7)
    phase = [
        sequence.clip_time(track, block, times) / length for block, length in zip(track.blocks, (2.0, 1.0), strict=True)
    ]
    np.testing.assert_allclose(phase[0], phase[1], atol=1e-12)
    before, after = (sequence.phase(track, track.blocks[1], np.array([t, t + 0.5])) for t in (0.5, 4.0))
    assert np.diff(before)[0] == pytest.approx(0.25, rel=1e-6)
    assert np.diff(after)[0] == pytest.approx(0.5, rel=1e-6)


def test_a_masked_track_lies_over_the_one_below_and_a_muted_one_does_not() -> None:
    turn = ClipAsset("turn", [channel(n, "rotation", [0.0, 1.0], [turning(1, 1.0)] * 2) for n in range(3)])
    move = ClipAsset("move", [channel(n, "translation", [0.0, 1.0], [[1, 0, 0]] * 2) for n in range(3)])
    body = rig(3)
    uses = [ClipUse(ClipSampler(c, body)) for c in (move, turn)]
    tracks = [
        Track("legs", [Block(0, 0.0, 1.0)], np.ones(3)),
        Track("arms", [Block(1, 0.0, 1.0)], np.array([0.0, 0.5, 1.0])),
    ]
    pose = Sequence(body, uses, tracks).pose([0.5])
    assert pose[T][0, 0].tolist() == pytest.approx([1.0, 0.5, 0.0])  # an override covers what lies below
    turned = angle(pose[R][:, 0], np.tile([[0.0], [0.0], [0.0], [1.0]], (1, 3)))
    np.testing.assert_allclose(turned, [0.0, 0.5, 1.0], atol=2e-3)  # nlerp
    tracks[1].muted = True
    assert Sequence(body, uses, tracks).pose([0.5])[T][0, 0].tolist() == [1.0, 1.0, 1.0]


def test_an_additive_track_adds_its_way_from_the_reference() -> None:
    reference = np.zeros((10, 1))
    reference[0], reference[6], reference[7:10] = 2.0, 1.0, 1.0
    body = rig(1)
    uses = [ClipUse(sampler(c)) for c in (still(1.0), still(2.5))]
    tracks = [
        Track("base", [Block(0, 0.0, 1.0)], np.ones(1)),
        Track("more", [Block(1, 0.0, 1.0)], np.ones(1), "additive", 2.0, reference=reference),
    ]
    assert _x(Sequence(body, uses, tracks), [0.5]) == pytest.approx([1.0 + 2.0 * 0.5])


def test_clips_of_two_characters_leave_each_other_alone() -> None:
    first = ClipAsset("a", [channel(0, "translation", [0.0, 1.0], [[1, 0, 0]] * 2)])
    second = ClipAsset("b", [channel(1, "translation", [0.0, 1.0], [[2, 0, 0]] * 2)])
    both = rig(2, [-1, -1])
    uses = [ClipUse(ClipSampler(c, both)) for c in (first, second)]
    tracks = [Track(str(i), [Block(i, 0.0, 1.0)], np.ones(2)) for i in range(2)]
    assert Sequence(both, uses, tracks).pose([0.5])[0, 0].tolist() == [1.0, 2.0]


def test_root_motion_goes_on_over_loops_and_is_taken_out_of_the_pose() -> None:
    walk = sampler(slide(1.0, 1.5))
    use = ClipUse(walk)
    sequence = Sequence(
        rig(1), [use], [Track("t", [Block(0, 0.0, 4.0)], np.ones(1))], ways=[extract(walk, 0)]
    )  # fmt: skip
    times = [0.0, 0.5, 1.0, 3.25]
    np.testing.assert_allclose(sequence.way(times)[:, 0], [0.0, 0.75, 1.5, 4.875], atol=1e-9)
    np.testing.assert_allclose(_x(sequence, times), 0.0, atol=1e-9)


def test_root_motion_of_a_cross_fade_is_that_of_the_blend() -> None:
    """From 1 m/s to 3 m/s over a second, smoothly: 1 s at 1, 1 s at 2 on average, 1 s at 3."""
    clips = [slide(1.0, 1.0), slide(1.0, 3.0)]
    uses = [ClipUse(sampler(c)) for c in clips]
    blocks = [Block(0, 0.0, 2.0, fade_out=1.0), Block(1, 1.0, 2.0, fade_in=1.0)]
    sequence = Sequence(rig(1), uses, [Track("t", blocks, np.ones(1))], ways=[extract(u.sampler, 0) for u in uses])
    assert sequence.way([3.0])[0, 0] == pytest.approx(6.0, abs=1e-3)


@pytest.mark.parametrize(
    ("block", "expected"),
    [
        (Block(0, 1.0, 2.0), [1.25, 2.25]),
        (Block(0, 1.0, 2.0, offset=0.5), [1.75, 2.75]),
        (Block(0, 0.0, 1.0, speed=2.0), [0.125, 0.625]),
        (Block(0, 0.0, 2.0, speed=-1.0), [0.75, 1.75]),
        (Block(0, 0.0, 2.0, play="once"), [0.25]),
        (Block(0, 0.0, 2.0, play="ping-pong"), [0.25, 1.75]),
        (Block(0, 0.0, 1.25), [0.25]),  # the end is another's beginning
    ],
)
def test_markers_of_a_clip_stand_where_its_block_passes_them(block: Block, expected: list[float]) -> None:
    sequence = _one(block, clips=[slide(1.0, 1.0)], markers=[[Marker("step", 0.25)]])
    times, names = sequence.occurrences()
    np.testing.assert_allclose(times, expected, atol=1e-12)
    assert set(names) == {"step"}


def test_nothing_to_play_and_clips_without_length_are_no_trouble() -> None:
    assert _one(clips=[]).duration == 0.0
    assert np.isfinite(_one(clips=[]).pose([0.0, 1e12, float("nan")])).all()
    sequence = _one(Block(0, 0.0, 1.0), clips=[ClipAsset("pose", [channel(0, "translation", [0.0], [[3, 0, 0]])])])
    assert _x(sequence, [0.5]) == pytest.approx([3.0])
