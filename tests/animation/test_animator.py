"""The animator as a whole: states, fades, phases, layers, root motion, sleeping characters, writing to nodes."""

from __future__ import annotations

import numpy as np
import pytest

from engine.animation import poses
from engine.animation.animator import Animator
from engine.animation.blend_space import BlendSpace
from engine.animation.events import Marker
from engine.animation.graph import (
    AnimationGraph,
    ClipUse,
    Condition,
    LayerUse,
    Motion,
    Param,
    State,
    Transition,
    single,
)
from engine.animation.sampler import ClipSampler
from engine.animation.state_machine import FROZEN, NO_FADE
from engine.assets.clip import ClipAsset
from engine.core.errors import InputError
from engine.math.transform import compose
from engine.scene.nodes import NodeTable
from tests.animation.crowd import (
    IDENTITY,
    angle,
    assert_same_pose,
    channel,
    random_clip,
    rig,
    sampler,
    slide,
    still,
    turning,
)


def x(animator: Animator) -> list[float]:
    return [round(float(v), 9) for v in animator.poses[0, :, 0]]


def two_states(**how: object) -> AnimationGraph:
    """At 1 while `speed` <= 0.5, at 3 above; `hit` from anywhere to 9."""
    return AnimationGraph(
        rig(1),
        [ClipUse(sampler(still(v, name=f"at {v}"))) for v in (1.0, 3.0, 9.0)],
        [State(n, Motion((i,))) for i, n in enumerate(("slow", "fast", "hit"))],
        [Param("speed"), Param("hit", "trigger")],
        [
            Transition(0, 1, (Condition(0, ">", 0.5),), 1.0, "linear"),
            Transition(1, 0, (Condition(0, "<=", 0.5),), 1.0, "linear"),
            Transition(-1, 2, (Condition(1, "!=", 0.0),), 1.0, "linear"),
        ],
        **how,  # type: ignore[arg-type]  # the fields of AnimationGraph
    )


def test_a_cross_fade_by_hand() -> None:
    animator = Animator(two_states(), 2)
    animator.set("speed", 1.0, [1])
    seen = []
    for _ in range(5):
        seen.append(x(animator))
        animator.update(0.25)
    assert seen == [[1, 1], [1, 1.5], [1, 2.0], [1, 2.5], [1, 3.0]]
    assert animator.machine.state_names() == ["slow", "fast"]
    assert animator.machine.source.tolist() == [NO_FADE, NO_FADE]


def test_a_fade_cut_short_goes_on_from_where_it_was() -> None:
    animator = Animator(two_states(), 1)
    animator.set("speed", 1.0)
    animator.update(0.5)
    assert x(animator) == [2.0]
    animator.set("speed", 0.0)
    animator.update(0.0)
    assert animator.machine.source[0] == FROZEN
    assert x(animator) == [2.0]  # no jump
    animator.update(0.5)
    assert x(animator) == [1.5]
    animator.update(0.5)
    assert x(animator) == [1.0]


def test_a_trigger_fires_one_transition() -> None:
    animator = Animator(two_states(), 2)
    animator.set("hit", 1.0, [0])
    animator.update(1.0)
    assert animator.machine.state_names() == ["hit", "slow"]
    assert animator.machine.values[1].tolist() == [0.0, 0.0]
    assert x(animator) == [9.0, 1.0]


def test_an_exit_phase_waits_for_the_clip() -> None:
    graph = two_states()
    graph.transitions = [Transition(0, 1, (), 0.0, "linear", 0.75)]
    animator = Animator(graph)
    states = []
    for _ in range(5):
        animator.update(0.2)
        states.append(animator.machine.state_names()[0])
    assert states == ["slow", "slow", "slow", "slow", "fast"]


def test_clips_of_a_blend_space_run_in_step() -> None:
    # 1 s to 10 m and 3 s to 30 m: at half weights a run takes 2 s, and both are half through after one
    graph = AnimationGraph(
        rig(1), [ClipUse(sampler(slide(1.0, 10.0))), ClipUse(sampler(slide(3.0, 30.0)))],
        [State("move", Motion((0, 1), BlendSpace([0.0, 1.0]), (0,)), mode="once")], [Param("speed")],
    )  # fmt: skip
    animator = Animator(graph, 3)
    animator.set("speed", [0.0, 0.5, 1.0])
    animator.update(1.0)
    np.testing.assert_allclose(animator.machine.heads.phase, [1.0, 0.5, 1.0 / 3.0])
    np.testing.assert_allclose(animator.poses[0, :, 0], [10.0, 0.5 * 5.0 + 0.5 * 15.0, 10.0])


@pytest.mark.parametrize(("mode", "expected"), [("loop", 2.5), ("once", 10.0), ("ping-pong", 7.5)])
def test_modes_speeds_and_going_back(mode: str, expected: float) -> None:
    animator = Animator(single(sampler(slide(1.0, 10.0)), mode), 2)
    animator.speed[1] = 2.0
    animator.update(0.625)
    assert x(animator)[0] == 6.25
    animator.update(0.625)
    assert x(animator) == [expected, {"loop": 5.0, "once": 10.0, "ping-pong": 5.0}[mode]]
    if mode != "once":
        animator.update(-1.25)
        assert x(animator) == [0.0, 0.0]


def test_the_row_zero_duration_and_time_not_a_number() -> None:
    pose = ClipAsset("pose", [channel(0, "translation", [0.0], [[4, 0, 0]])])
    animator = Animator(single(sampler(pose)), 1)
    for dt in (0.1, np.nan, np.inf, -np.inf, 1e12, -1e300):
        assert len(animator.update(dt)) == 0
        assert x(animator) == [4.0]
    animator.seek(np.nan)
    animator.update(0.0)
    assert x(animator) == [4.0]


def test_events_come_once_each_with_their_names() -> None:
    use = ClipUse(sampler(slide(1.0, 1.0)), [Marker("left", 0.25), Marker("right", 0.75)])
    graph = AnimationGraph(use.sampler.rig, [use], [State("walk", Motion((0,)))])
    animator = Animator(graph, 2)
    animator.speed[1] = 100.0
    log: list[tuple[int, str]] = []
    for _ in range(600):
        fired = animator.update(1.0 / 60.0)
        log += [(int(c), animator.marker_names[m]) for c, m in zip(fired.character, fired.marker, strict=True)]
    assert [name for c, name in log if c == 0] == ["left", "right"] * 10
    assert [name for c, name in log if c == 1] == ["left", "right"] * 1000


def test_sleeping_characters_keep_their_pose_but_not_their_time() -> None:
    use = ClipUse(sampler(slide(1.0, 10.0)), [Marker("step", 0.5)])
    animator = Animator(AnimationGraph(use.sampler.rig, [use], [State("walk", Motion((0,)))]), 2)
    fired = animator.update(0.6, awake=[True, False])
    assert x(animator) == [6.0, 0.0]
    assert fired.character.tolist() == [0, 1]
    animator.update(0.1)
    assert x(animator) == [7.0, 7.0]


def test_layers_by_parameter_and_mask() -> None:
    nodes = rig(2, [-1, 0])
    base = ClipSampler(ClipAsset("base", [channel(0, "rotation", [0, 1], [IDENTITY] * 2)]), nodes)
    wave = ClipSampler(
        ClipAsset("wave", [channel(n, "rotation", [0, 1], [turning(2, 1.0)] * 2) for n in (0, 1)]), nodes
    )
    graph = AnimationGraph(
        nodes, [ClipUse(base), ClipUse(wave)], [State("stand", Motion((0,)))], [Param("wave")],
        layers=[LayerUse("wave", Motion((1,)), np.array([0.0, 1.0]), weight=0)],
    )  # fmt: skip
    animator = Animator(graph, 3)
    animator.set("wave", [0.0, 0.5, 1.0])
    animator.update(0.1)
    animator.update(0.1)  # a layer must not pile up
    got = animator.poses[3:7]
    np.testing.assert_allclose(angle(got[:, :, 0], np.repeat(IDENTITY[:, None], 3, 1)), 0.0, atol=1e-12)
    np.testing.assert_allclose(angle(got[:, :, 1], np.repeat(IDENTITY[:, None], 3, 1)), [0.0, 0.5, 1.0], atol=1e-9)


def test_many_characters_equal_each_alone() -> None:
    rng = np.random.default_rng(8)
    nodes = rig(6)
    clips = [ClipUse(ClipSampler(random_clip(rng, 6, shared=i == 0), nodes)) for i in range(3)]
    graph = AnimationGraph(
        nodes, clips, [State("mix", Motion((0, 1, 2), BlendSpace(rng.normal(size=(3, 2))), (0, 1)))],
        [Param("a"), Param("b")],
    )  # fmt: skip
    count = 300  # more than one block
    a, b, t = rng.normal(size=count), rng.normal(size=count), rng.uniform(0, 2, count)
    crowd = Animator(graph, count)
    crowd.set("a", a)
    crowd.set("b", b)
    crowd.seek(t)
    crowd.update(0.3)
    for i in (0, 255, 256, 299):
        one = Animator(graph)
        one.set("a", a[i])
        one.set("b", b[i])
        one.seek(t[i])
        one.update(0.3)
        assert_same_pose(one.poses[:, 0], crowd.poses[:, i], 1e-9)


def test_writing_leaves_alone_what_no_clip_moves() -> None:
    nodes = NodeTable()
    rows = nodes.add_many(["a", "b"], translations=[[7, 7, 7], [8, 8, 8]], scales=[[2, 2, 2], [3, 3, 3]])
    animator = Animator(single(sampler(slide(1.0, 10.0))), 2)
    animator.update(0.5)
    animator.write(nodes, rows[:, None], only=[False, True])
    np.testing.assert_array_equal(nodes.translation, [[7, 7, 7], [5, 0, 0]])
    np.testing.assert_array_equal(nodes.scale, [[2, 2, 2], [3, 3, 3]])
    animator.write(nodes, np.array([[-1], [0]]))
    np.testing.assert_array_equal(nodes.translation[0], [5, 0, 0])


def test_root_motion_carries_the_character_and_leaves_the_pose_in_place() -> None:
    graph = single(sampler(slide(1.0, 2.0)))
    graph.root = 0
    animator = Animator(graph, 3)
    animator.speed[:] = [1.0, -1.0, 100.0]
    for _ in range(30):
        animator.update(0.1)
    np.testing.assert_allclose(animator.travel[:, 0], [6.0, -6.0, 600.0], atol=1e-9)
    np.testing.assert_allclose(animator.travel[:, 1:], 0.0, atol=1e-9)
    np.testing.assert_allclose(animator.poses[0:3, :, 0], 0.0, atol=1e-9)


def test_root_motion_turns_with_the_root() -> None:
    # a quarter turn left (about +Y) per second and 1 m forward (+Z) before it: four loops close a square
    clip = ClipAsset(
        "corner",
        [
            channel(0, "translation", [0, 0.5, 1], [[0, 0, 0], [0, 0, 1], [0, 0, 1]]),
            channel(0, "rotation", [0, 0.5, 1], [IDENTITY, IDENTITY, turning(1, np.pi / 2)]),
        ],
    )
    graph = single(sampler(clip))
    graph.root = 0
    small, large = Animator(graph), Animator(graph)
    corners = []
    for _ in range(40):
        small.update(0.1)
        if round(float(small.machine.heads.phase[0]), 9) in (0.0, 1.0):
            corners.append(small.travel[0].copy())
    large.update(4.0)
    np.testing.assert_allclose(large.travel[0], [0.0, 0.0, 2.0 * np.pi], atol=1e-9)
    np.testing.assert_allclose(small.travel[0], [0.0, 0.0, 2.0 * np.pi], atol=1e-9)
    two = Animator(graph)
    two.update(2.0)
    np.testing.assert_allclose(two.travel[0], [1.0, 1.0, np.pi], atol=1e-9)
    nodes = NodeTable()
    row = nodes.add_many(["mover"])
    mover = Animator(graph)
    for _ in range(2):
        mover.update(1.0)
        mover.move(nodes, row)
    np.testing.assert_allclose(nodes.translation[0], [1.0, 0.0, 1.0], atol=1e-9)
    # and the root itself stays where the clip starts, looking where it starts
    for phase in (0.2, 0.6, 0.9):
        two.seek(phase)
        two.update(0.0)
        np.testing.assert_allclose(two.poses[0:3, 0, 0], 0.0, atol=1e-9)
        assert angle(two.poses[3:7, 0, 0], IDENTITY) < 1e-3  # the way is sampled 60 times a second


def test_a_turned_armature_walks_on_the_ground() -> None:
    # Z-up inside: the root goes along its parent's -Y, which the parent turns to +Z
    above = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0]])
    clip = ClipAsset("walk", [channel(0, "translation", [0, 1], [[0, 0, 5], [0, -2, 5]])])
    graph = single(sampler(clip))
    graph.root = 0
    animator = Animator(graph, above=above)
    animator.update(0.5)
    np.testing.assert_allclose(animator.travel[0], [0.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(animator.poses[0:3, 0, 0], [0.0, 0.0, 5.0], atol=1e-12)


@pytest.mark.parametrize("speed", [1.0, -1.7, 23.0])
def test_the_way_and_the_pose_in_place_make_up_the_clip(speed: float) -> None:
    rng = np.random.default_rng(6)
    times = np.linspace(0.0, 1.0, 13)  # at 60 a second the way is sampled at these keys too
    yaw = 0.7 + np.cumsum(rng.uniform(-0.6, 0.6, 13))
    clip = ClipAsset(
        "wander",
        [
            channel(0, "translation", times, rng.normal(size=(13, 3)) + 2.0),
            channel(0, "rotation", times, [turning(1, a) for a in yaw]),
        ],
    )
    above = np.array([[0.0, 0.0, 1.0, 3.0], [0.0, 1.0, 0.0, 0.5], [-1.0, 0.0, 0.0, -2.0]])
    plain, moving = Animator(single(sampler(clip))), single(sampler(clip))
    moving.root = 0
    animator = Animator(moving, above=above)

    def world(pose: np.ndarray) -> np.ndarray:
        m = np.eye(4)
        m[:3] = above
        return m @ compose(pose[0:3, 0, 0], pose[3:7, 0, 0], np.ones(3))

    # one run through the clip: the planar motion from its first root to its last
    ends = poses.resting(rig(1).rest, 2)
    sampler(clip).sample([0.0, 1.0], ends)
    first, last = world(ends[:, :1]), world(ends[:, 1:])
    lap = compose(np.zeros(3), turning(1, yaw[-1] - yaw[0]), np.ones(3))
    lap[[0, 2], 3] = last[[0, 2], 3] - (lap @ first)[[0, 2], 3]
    for _ in range(40):
        plain.update(0.0317 * speed)
        animator.update(0.0317 * speed)
        x_, z_, angle_ = animator.travel[0]
        carried = compose([x_, 0.0, z_], turning(1, angle_), np.ones(3)) @ world(animator.poses)
        turns = int(plain.machine.heads.turn[0])
        expected = np.linalg.matrix_power(lap, turns) @ world(plain.poses)
        np.testing.assert_allclose(carried, expected, atol=1e-5)  # float32 keys, 29 laps
    assert abs(turns) >= 1


def test_bad_graphs_and_names_say_so() -> None:
    clip = ClipUse(sampler(still(1.0)))
    good = State("a", Motion((0,)))
    for graph, words in (
        (AnimationGraph(rig(1), [clip], []), "needs a state"),
        (AnimationGraph(rig(1), [clip], [State("a", Motion((1,)))]), "of 1"),
        (AnimationGraph(rig(1), [clip], [State("a", Motion((0, 0)))]), "blend space"),
        (AnimationGraph(rig(1), [clip], [good], transitions=[Transition(0, 4)]), "of 1 states"),
        (AnimationGraph(rig(1), [clip], [good], transitions=[Transition(0, 0, seconds=np.inf)]), "takes inf s"),
        (AnimationGraph(rig(1), [clip], [good], layers=[LayerUse("l", Motion((0,)), np.ones(3))]), "mask"),
    ):
        with pytest.raises(InputError, match=words):
            Animator(graph)
    animator = Animator(two_states())
    with pytest.raises(InputError, match="did you mean 'speed'"):
        animator.set("sped", 1.0)
    with pytest.raises(InputError, match="did you mean 'slow'"):
        animator.enter("slo")
    animator.enter("fast")
    animator.update(0.0)
    assert x(animator) == [3.0] or animator.machine.source[0] != NO_FADE
