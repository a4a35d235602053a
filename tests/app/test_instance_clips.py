"""Clips of prefabs play on their instances: of the file and placed later, nested, blended on a timeline."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from engine.app.runtime import Runtime
from engine.assets.clip import Channel, ClipAsset
from engine.assets.lanim import write_lanim
from engine.assets.prefab import ROOT, instance_nodes
from engine.assets.prefab_clips import prefab_clips
from engine.assets.scene import NodeAsset, SceneAsset
from engine.assets.scene_json import read_scene, write_scene
from engine.core.findings import Findings
from engine.gpu import open_device


def ramp(name: str, node: int, end: tuple[float, float, float], seconds: float) -> ClipAsset:
    """A clip that moves a node from the origin to `end`."""
    times, values = np.array([0.0, seconds], np.float32), np.array([(0.0, 0.0, 0.0), end], np.float32)
    return ClipAsset(name, [Channel(node, "translation", "linear", times, values, "arm")])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """hero: two clips that move `arm`; pair: two heroes; level: two heroes, a pair, a door with a clip of its own."""
    for clip in (ramp("wave", 1, (0.0, 2.0, 0.0), 2.0), ramp("reach", 1, (4.0, 0.0, 0.0), 4.0)):
        write_lanim(tmp_path / f"hero.{clip.name}.lanim", clip)
    write_scene(
        tmp_path / "hero.scene.json",
        SceneAsset("hero", [NodeAsset("body"), NodeAsset("arm", 0)], ["hero.wave.lanim", "hero.reach.lanim"]),
    )
    pair = [n for i in range(2) for n in shifted(instance_nodes(tmp_path / "hero.scene.json", tmp_path), 3 * i)]
    write_scene(tmp_path / "pair.scene.json", SceneAsset("pair", pair))
    write_lanim(tmp_path / "open.lanim", ramp("open", 0, (0.0, 0.0, 1.0), 1.0))
    nodes = [NodeAsset("door")]
    for name in ("hero", "hero", "pair"):
        nodes += shifted(instance_nodes(tmp_path / f"{name}.scene.json", tmp_path), len(nodes))
    write_scene(tmp_path / "level.scene.json", SceneAsset("level", nodes, ["open.lanim"]))
    return tmp_path


def shifted(nodes: list[NodeAsset], by: int) -> list[NodeAsset]:
    for node in nodes:
        node.parent += by if node.parent >= 0 else 0
    return nodes


@pytest.fixture
def level(folder: Path) -> Iterator[Runtime]:
    runtime = Runtime(open_device("null"))
    runtime.open(folder / "level.scene.json")
    yield runtime
    runtime.close()


def arms(runtime: Runtime) -> list[list[float]]:
    nodes = runtime.scene.nodes
    return [nodes.translation[r].tolist() for r in nodes.alive_rows().tolist() if nodes.name[r] == "arm"]


def test_each_prefab_plays_its_first_clip_beside_that_of_the_scene(level: Runtime) -> None:
    assert [c.name for c in level.clips] == ["open", "hero/wave", "hero/reach", "pair/hero/wave", "pair/hero/reach"]
    assert [level.clips[i].name for i in level.deck.active] == ["open", "hero/wave", "pair/hero/wave"]
    level.update(0.5)
    assert arms(level) == [[0.0, 0.5, 0.0]] * 4
    assert level.scene.nodes.translation[0].tolist() == [0.0, 0.0, 0.5]
    assert level.duration == 2.0


def test_another_clip_of_a_prefab_replaces_its_own_only(level: Runtime) -> None:
    level.instance_clips.play("hero/reach")
    level.update(1.0)
    assert arms(level) == [[1.0, 0.0, 0.0]] * 2 + [[0.0, 1.0, 0.0]] * 2
    assert [level.clips[i].name for i in level.deck.active] == ["hero/reach", "open", "pair/hero/wave"]
    level.play("open")
    level.update(0.25)
    assert arms(level) == [[0.0] * 3] * 4, "what plays no more rests, copies too"


def test_a_timeline_blends_clips_of_a_prefab_and_the_others_play_on(level: Runtime) -> None:
    level.set_animation(
        'schema = "lucarna.animation/1"\nname = "x"\n'
        '[clips."hero/wave"]\n[clips."hero/reach"]\n[[tracks]]\nname = "a"\n'
        'blocks = [{ clip = "hero/wave", start = 0.0, length = 4.0, weight = 1.0 }, '
        '{ clip = "hero/reach", start = 0.0, length = 4.0, weight = 1.0 }]\n',
        drive="timeline",
    )
    level.update(1.0)
    found = np.array(arms(level))
    assert np.allclose(found[:2], [0.5, 0.5, 0.0]), "half of each"
    assert np.allclose(found[2:], [0.0, 1.0, 0.0]), "a prefab that is not on the timeline goes on as it was"
    level.set_drive("clips")
    level.update(0.5)
    assert arms(level) == [[0.0, 0.5, 0.0]] * 4


def test_instances_placed_later_play_and_go_with_their_prefab(folder: Path) -> None:
    write_scene(folder / "empty.scene.json", SceneAsset("empty", [NodeAsset("ground")]))
    runtime = Runtime(open_device("null"))
    runtime.open(folder / "empty.scene.json")
    assert runtime.duration == 0.0
    hero = instance_nodes(folder / "hero.scene.json", folder)
    first = runtime.add_nodes(hero, folder)
    runtime.follow_structure()
    assert runtime.duration == 2.0
    runtime.update(1.0)
    second = runtime.add_nodes(instance_nodes(folder / "hero.scene.json", folder), folder)
    runtime.update(1.5)
    assert arms(runtime) == [[0.0, 1.5, 0.0]] * 2
    runtime.set_animation(
        'schema = "lucarna.animation/1"\nname = "x"\n[clips."hero/reach"]\n[[tracks]]\nname = "a"\n'
        'blocks = [{ clip = "hero/reach", start = 0.0, length = 4.0 }]\n',
        drive="timeline",
    )
    runtime.update(2.0)
    assert arms(runtime) == [[2.0, 0.0, 0.0]] * 2, "an animation file knows them too"
    runtime.set_drive("clips")
    runtime.scene.remove([int(first[0])])
    runtime.update(1.0)
    assert arms(runtime) == [[0.0, 1.0, 0.0]], "without the one that led"
    runtime.scene.remove([int(second[0])])
    lamp = runtime.add_nodes([NodeAsset("lamp"), NodeAsset("wick", 0), NodeAsset("flame", 1)], folder)
    runtime.update(1.5)
    assert runtime.duration == 0.0
    assert not any(runtime.instance_clips.stands(i) for i in range(2))
    assert not runtime.scene.nodes.translation[lamp].any(), "other nodes in the rows of those that went stay put"
    runtime.add_nodes(instance_nodes(folder / "hero.scene.json", folder), folder)
    runtime.update(0.5)
    assert arms(runtime) == [[0.0, 0.5, 0.0]]
    assert not runtime.scene.nodes.translation[lamp].any()
    runtime.close()


def test_a_prefab_within_counts_its_nodes_by_the_keys_outside(folder: Path) -> None:
    notes = Findings()
    found = prefab_clips(folder / "pair.scene.json", notes)
    wave = found.clips[0]
    assert wave.name == "pair/hero/wave"
    assert [found.keys[c.node] for c in wave.channels] == ["hero/body/arm", "hero#2/body/arm"]
    (folder / "hero.wave.lanim").write_bytes(b"no clip")
    found = prefab_clips(folder / "pair.scene.json", notes)
    assert [clip.name for clip in found.clips] == ["pair/hero/reach"]
    assert [f.code for f in notes.items] == ["clip.unreadable"]


def test_a_lost_prefab_leaves_its_instance_at_rest(folder: Path) -> None:
    (folder / "hero.scene.json").unlink()
    runtime = Runtime(open_device("null"))
    runtime.open(folder / "level.scene.json")
    assert [clip.name for clip in runtime.clips] == ["open"]
    assert "prefab.unreadable" in [f.code for f in runtime.findings]
    assert sum(ROOT in n.extras for n in runtime.asset.nodes) == 5
    runtime.close()


def test_an_export_has_them_too(folder: Path) -> None:
    from importers.export.source import load_source
    from importers.settings import ImportSettings

    source = load_source(folder / "level.scene.json", ImportSettings())
    assert [c.name for c in source.clips] == ["open", "hero/wave", "hero/reach", "pair/hero/wave", "pair/hero/reach"]
    moved = [[source.nodes[channel.node].name for channel in clip.channels] for clip in source.clips]
    assert moved == [["door"], ["arm", "arm"], ["arm", "arm"], ["arm", "arm"], ["arm", "arm"]]


BLEND = """schema = "lucarna.animation/1"
name = "hero"
[clips.wave]
[clips.reach]
"""
TRACKS = """[[tracks]]
name = "base"
blocks = [{ clip = "wave", start = 0.0, length = 4.0 }, { clip = "reach", start = 0.0, length = 4.0 }]
"""
STATES = """[states.reaching]
clip = "reach"
"""


@pytest.mark.parametrize(
    ("text", "drive", "half"), [(TRACKS, "timeline", [0.5, 0.5, 0.0]), (STATES, "states", [1.0, 0.0, 0.0])]
)
def test_a_prefab_that_blends_its_clips_blends_them_in_its_instances(
    folder: Path, text: str, drive: str, half: list[float]
) -> None:
    (folder / "hero.animation.toml").write_text(BLEND + text)
    hero = read_scene(folder / "hero.scene.json")
    hero.animation, hero.drive = "hero.animation.toml", drive
    write_scene(folder / "hero.scene.json", hero)
    runtime = Runtime(open_device("null"))
    runtime.open(folder / "level.scene.json")
    assert not runtime.findings.items
    assert [runtime.clips[i].name for i in runtime.deck.active] == ["open", "pair/hero/wave"]
    runtime.update(1.0)
    found = np.array(arms(runtime))
    assert np.allclose(found[:2], half), "both instances, by the prefab's own file"
    assert np.allclose(found[2:], [0.0, 1.0, 0.0])
    ((path, plays),) = runtime.instance_clips.animations().items()
    assert plays
    runtime.instance_clips.play("hero/wave")
    runtime.update(1.5)
    assert np.allclose(arms(runtime)[0], [0.0, 1.5, 0.0]), "a clip instead"
    assert runtime.instance_clips.animations() == {path: False}
    runtime.instance_clips.play_animation(path)
    runtime.update(1.0)
    assert np.allclose(arms(runtime)[1], half)
    runtime.play("open")
    runtime.update(0.5)
    assert not np.array(arms(runtime)).any(), "everybody rests but the door"
    runtime.close()


def test_an_animation_file_of_a_prefab_that_is_wrong_is_a_finding_and_its_clip_plays(folder: Path) -> None:
    (folder / "hero.animation.toml").write_text("what = ")
    hero = read_scene(folder / "hero.scene.json")
    hero.animation = "hero.animation.toml"
    write_scene(folder / "hero.scene.json", hero)
    runtime = Runtime(open_device("null"))
    runtime.open(folder / "level.scene.json")
    assert [f.code for f in runtime.findings] == ["animation.unreadable"]
    runtime.update(0.5)
    assert arms(runtime) == [[0.0, 0.5, 0.0]] * 4
    runtime.close()
