"""What nobody sees is not sampled: time goes on, and it is found again when it comes into view."""

from __future__ import annotations

import numpy as np
import pytest

from engine.animation.sample import ClipPlayer
from engine.app.clip_deck import ClipDeck, Seers
from engine.assets.clip import Channel, ClipAsset
from engine.scene.nodes import NodeTable


def _clip(node: int, name: str) -> ClipAsset:
    values = np.array([[0, 0, 0], [1, 0, 0]], "f4")
    return ClipAsset(name, [Channel(node, "translation", "linear", np.array([0, 1], "f4"), values, name)])


@pytest.fixture
def stage() -> tuple[NodeTable, ClipDeck, Seers]:
    """Two bodies with a mesh each, the second's below the node that moves; and a light that moves."""
    nodes = NodeTable()
    nodes.add_many(["a", "b", "b mesh", "lamp"], batch_parents=[-1, -1, 1, -1])
    clips = [_clip(0, "a"), _clip(1, "b"), _clip(3, "lamp")]
    deck = ClipDeck(nodes, clips, [ClipPlayer(c, np.arange(4)) for c in clips])
    deck.play("a", "b", "lamp")
    return nodes, deck, Seers(nodes.parent, [0, 2], [])


def test_what_is_out_of_sight_sleeps_and_what_carries_no_mesh_does_not(stage) -> None:
    nodes, deck, seers = stage
    deck.apply(0.5, np.array([True, False]), seers)
    assert nodes.translation[[0, 1, 3], 0].tolist() == [0.5, 0.0, 0.5]
    assert deck.asleep == 1
    deck.apply(0.75, np.array([True, True]), seers)
    assert nodes.translation[[0, 1, 3], 0].tolist() == [0.75, 0.75, 0.75]
    assert deck.asleep == 0
    deck.apply(0.25)
    assert nodes.translation[1, 0] == 0.25


def test_a_skin_is_seen_by_its_joints(stage) -> None:
    nodes, _, _ = stage
    seers = Seers(nodes.parent, [3], [(3, np.array([1]))])
    assert seers.sees(np.array([1]), np.array([True]))
    assert not seers.sees(np.array([1]), np.array([False]))
    assert seers.sees(np.array([0]), np.array([False])), "moves nothing that is drawn: perhaps a camera"


def test_a_picture_without_the_character_leaves_it_asleep_until_it_is_looked_at(null_device) -> None:
    from engine.app.framing import frame_bounds
    from engine.assets.primitives import cube
    from tests.support.stage import Stage

    null_stage = Stage(null_device)
    runtime = null_stage.runtime
    node = null_stage.add(cube())
    clip = _clip(node, "walk")
    runtime.clips.append(clip)
    runtime.players.append(ClipPlayer(clip, np.arange(node + 1)))
    runtime.deck = ClipDeck(runtime.scene.nodes, runtime.clips, runtime.players)
    runtime.deck.play("walk")
    runtime.sleepy = True
    here = null_stage.view(camera=frame_bounds(np.full(3, -1.0), np.full(3, 1.0), 1.0))
    away = null_stage.view(
        camera=frame_bounds(np.array([0.0, 999.0, 0.0]), np.array([1.0, 1000.0, 1.0]), 1.0, elevation=0.0)
    )
    runtime.render(away)
    runtime.update(0.5)
    assert runtime.scene.nodes.translation[node, 0] == 0.0
    counters = runtime.render(here).stats.counters
    assert (counters["animations"], counters["animations_asleep"]) == (1, 1)
    runtime.update(0.6)
    assert runtime.scene.nodes.translation[node, 0] == pytest.approx(0.6)
    assert runtime.render(here).stats.counters["animations_asleep"] == 0
    null_stage.close()
