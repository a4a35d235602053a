"""*.animation.toml: read, resolved against a scene, and every mistake at its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.animation.animation_file import load_animation
from engine.animation.animator import Animator
from engine.app.runtime import Runtime
from engine.assets.animation_toml import condition, parse_animation
from engine.assets.clip import ClipAsset
from engine.assets.lanim import write_lanim
from engine.assets.scene import SceneAsset
from engine.assets.scene_json import write_scene
from engine.core.errors import FormatError, InputError
from engine.core.findings import Findings
from tests.animation.crowd import IDENTITY, chain, channel, slide, still, turning

TEXT = """\
schema = "lucarna.animation/1"
name = "soldier"
start = "idle"

[params]
speed = { default = 0.0 }
armed = { type = "bool", default = false }
jump = { type = "trigger" }

[clips.idle]
[clips.walk]
source = "Walk"
markers = [{ name = "left foot", time = 0.25 }]
[clips.run]
[clips.draw]

[masks.upper]
subtrees = [{ node = "n1", fall_off = 1 }]
nodes = { n2 = 0.5 }

[blends.move]
params = ["speed"]
samples = [{ clip = "walk", at = [1.0] }, { clip = "run", at = [4.0] }]

[states.idle]
clip = "idle"
[states.move]
blend = "move"
speed = 1.5

[[transitions]]
from = "idle"
to = "move"
when = ["speed > 0.1", "!armed"]
fade = 0.2
[[transitions]]
from = "any"
to = "idle"
when = ["jump"]
fade = 0.0

[[layers]]
name = "draw"
clip = "draw"
mask = "upper"
weight = "armed"
[[layers]]
name = "breathe"
clip = "idle"
mode = "additive"
weight = 0.5
"""


def clips() -> list[ClipAsset]:
    turn = [channel(n, "rotation", [0, 1], [IDENTITY, turning(2, 1.0)]) for n in (1, 2)]
    return [still(0.0, name="idle"), slide(1.0, 1.0, "Walk"), slide(0.5, 2.0, "run"), ClipAsset("draw", turn)]


def load(text: str, folder: Path, findings: Findings | None = None):
    path = folder / "soldier.animation.toml"
    path.write_text(text, encoding="utf-8")
    return load_animation(path, chain(4), clips(), findings)


def test_a_whole_file(tmp_path: Path) -> None:
    graph = load(TEXT, tmp_path)
    assert graph.rig.names == ("n0", "n1", "n2")  # n3 never moves
    assert [s.name for s in graph.states] == ["idle", "move"]
    assert graph.marker_names == ["left foot"]
    np.testing.assert_array_equal(graph.layers[0].mask, [0.0, 0.5, 0.5])
    assert [(layer.mode, layer.weight, layer.constant) for layer in graph.layers] == [
        ("override", 1, 1.0), ("additive", -1, 0.5),
    ]  # fmt: skip
    animator = Animator(graph)
    animator.set("speed", 1.0)
    animator.update(0.1)
    assert animator.machine.state_names() == ["move"]
    log = [animator.marker_names[m] for _ in range(100) for m in animator.update(0.01).marker]
    assert log == ["left foot"] * 2  # 1.1 s at speed 1.5 are 1.65 runs
    animator.set("jump", 1.0)
    animator.update(0.1)
    assert animator.machine.state_names() == ["idle"]


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ('name = "soldier"', 'nme = "soldier"', 2, "unknown key 'nme'"),
        ("fade = 0.2", 'fade = "slow"', 35, "valid number"),
        ("fade = 0.2", "fade = -1.0", 35, "greater than or equal to 0"),
        ("fade = 0.2", "fade = nan", 35, "finite"),
        ('source = "Walk"', 'source = "Wlk"', 12, "no clip 'Wlk' (did you mean 'Walk'"),
        ('to = "move"', 'to = "mve"', 33, "no state 'mve' (did you mean 'move'"),
        ('"speed > 0.1"', '"sped > 0.1"', 34, "no parameter 'sped' (did you mean 'speed'"),
        ('"speed > 0.1"', '"speed > > 1"', 34, "is no condition"),
        ('"speed > 0.1"', '"speed > 1.2.3"', 34, "is no condition"),
        ('node = "n1"', 'node = "n9"', 18, "no node 'n9'"),
        ("n2 = 0.5", "nn2 = 0.5", 19, "no node 'nn2'"),
        ("n2 = 0.5", "n2 = 1.5", 19, "less than or equal to 1"),
        ("at = [4.0]", "at = [4.0, 1.0]", 23, "2 numbers for 1 parameters"),
        ('clip = "idle"\n[states', 'clip = "idle"\nblend = "move"\n[states', 25, "either a clip or a blend"),
        ('mask = "upper"', 'mask = "lower"', 45, "no mask 'lower'"),
        ('weight = "armed"', 'weight = "arm"', 46, "no parameter 'arm'"),
        ('start = "idle"', 'start = "idl"', 3, "no state 'idl'"),
        ("time = 0.25", "time = -0.25", 13, "greater than or equal to 0"),
        ('schema = "lucarna.animation/1"', 'schema = "lucarna.animation/2"', 1, "lucarna.animation/1"),
        ('mode = "additive"', 'mode = "add"', 50, "override"),
        ('type = "bool"', 'type = "boole"', 7, "bool"),
        ("speed = 1.5", "spead = 1.5", 29, "unknown key 'spead' (did you mean 'speed'"),
    ],
)
def test_mistakes_stand_at_their_line(old: str, new: str, line: int, words: str, tmp_path: Path) -> None:
    assert TEXT.count(old) >= 1
    with pytest.raises(FormatError) as caught:
        load(TEXT.replace(old, new, 1), tmp_path)
    message = str(caught.value)
    assert caught.value.where.line == line, message
    assert all(part in message for part in words.split(" (")), message
    assert "^" in message


def test_what_a_layer_leaves_uncovered_is_noted(tmp_path: Path) -> None:
    findings = Findings()
    load(TEXT.replace('clip = "draw"\nmask', 'clip = "run"\nmask'), tmp_path, findings)
    assert [f.code for f in findings] == ["layer.uncovered"]
    assert "n1, n2" in str(next(iter(findings)))


def test_conditions() -> None:
    assert condition("speed >= 1e-3") == ("speed", ">=", 1e-3)
    assert condition(" armed ") == ("armed", "!=", 0.0)
    assert condition("! armed") == ("armed", "==", 0.0)
    assert condition("armed == true") == ("armed", "==", 1.0)
    assert condition("a and b") is None


def test_an_empty_file_and_no_file_say_so(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="'schema' is missing"):
        parse_animation("", "x.animation.toml")
    with pytest.raises(InputError, match="cannot read"):
        load_animation(tmp_path / "none.toml", [], [])


def test_root_motion_carries_the_top_node_and_a_removed_node_is_left_alone(tmp_path: Path, null_device) -> None:
    nodes = chain(3)
    nodes[0].translation, nodes[0].rotation = (5.0, 0.0, 0.0), tuple(turning(1, np.pi / 2))
    walk = ClipAsset("walk", [channel(1, "translation", [0, 1], [[0, 1, 0], [0, 1, 2]])])
    walk.channels.append(channel(2, "rotation", [0, 1], [IDENTITY, turning(0, 1.0)]))
    write_lanim(tmp_path / "walk.lanim", walk)
    write_scene(tmp_path / "a.scene.json", SceneAsset("a", nodes, clips=["walk.lanim"]))
    text = 'schema = "lucarna.animation/1"\nname = "w"\nroot = "n1"\n[clips.walk]\n[states.walk]\nclip = "walk"\n'
    (tmp_path / "w.animation.toml").write_text(text, encoding="utf-8")
    runtime = Runtime(null_device)
    try:
        runtime.open(tmp_path / "a.scene.json")
        table, rows = runtime.scene.nodes, runtime.node_rows
        runtime.animate(tmp_path / "w.animation.toml")
        for i in range(26):
            runtime.update(0.1 * i)
        # forward for n1 is +X in the world; 2.5 s are 5 m, in the pose itself n1 stands still
        np.testing.assert_allclose(table.world[rows[0], :, 3], [10.0, 0.0, 0.0], atol=1e-9)
        np.testing.assert_allclose(table.world[rows[1], :, 3], [10.0, 1.0, 0.0], atol=1e-9)
        runtime.scene.nodes.remove(int(rows[2]))
        runtime.update(3.0)
        np.testing.assert_allclose(table.world[rows[1], :, 3], [11.0, 1.0, 0.0], atol=1e-9)
        runtime.play()
        runtime.update(4.0)
        np.testing.assert_allclose(table.world[rows[1], :, 3], [5.0, 1.0, 0.0], atol=1e-9)
    finally:
        runtime.close()


def test_a_runtime_plays_one_clip_or_the_file(tmp_path: Path, null_device) -> None:
    names = []
    for clip in clips():
        write_lanim(tmp_path / f"{clip.name}.lanim", clip)
        names.append(f"{clip.name}.lanim")
    write_scene(tmp_path / "a.scene.json", SceneAsset("a", chain(4), clips=names))
    (tmp_path / "a.animation.toml").write_text(TEXT, encoding="utf-8")
    runtime = Runtime(null_device)
    try:
        runtime.open(tmp_path / "a.scene.json")
        nodes, row = runtime.scene.nodes, int(runtime.node_rows[0])
        assert runtime.duration == 1.0
        runtime.update(0.5)
        assert nodes.translation[row, 0] == 0.0  # the first clip, and no other
        runtime.play("run", speed=0.5)
        assert runtime.duration == 0.5
        runtime.update(0.5)
        assert nodes.translation[row, 0] == 1.0
        runtime.play("draw")
        runtime.update(0.5)
        assert nodes.translation[row, 0] == 0.0  # back where it stood
        assert nodes.rotation[int(runtime.node_rows[1]), 2] > 0.1
        runtime.play(1, 3)
        runtime.update(0.5)
        assert nodes.translation[row, 0] == 0.5
        animator = runtime.animate(tmp_path / "a.animation.toml")
        animator.set("speed", 1.0)
        runtime.update(1.0)
        runtime.update(1.1)
        assert 0.0 < nodes.translation[row, 0] < 1.0
        assert nodes.world[row, 0, 3] == nodes.translation[row, 0]
        runtime.play()
        runtime.update(2.0)
        np.testing.assert_array_equal(nodes.translation[row], 0.0)
        assert runtime.duration == 0.0
        with pytest.raises(InputError, match="did you mean 'run'"):
            runtime.play("rn")
        with pytest.raises(InputError, match="no clip 9"):
            runtime.play(9)
        with pytest.raises(InputError, match="speed of nan"):
            runtime.play("run", speed=float("nan"))
    finally:
        runtime.close()
