"""Scene files: exact round trip, one line a node, and complaints that say where."""

from __future__ import annotations

import json
import math
import random
from pathlib import Path
from typing import Any

import pytest

from engine.assets.scene import (
    CameraAsset,
    EnvironmentAsset,
    LightAsset,
    LookAsset,
    MeshRef,
    NodeAsset,
    SceneAsset,
)
from engine.assets.scene_json import format_scene, parse_scene, read_scene, write_scene
from engine.core.errors import FormatError, LucarnaError
from engine.core.findings import Findings


def make_scene() -> SceneAsset:
    half = math.sqrt(0.5)
    return SceneAsset(
        "demo",
        [
            NodeAsset("root", extras={"b": 1, "a": [None, "ü"]}),
            NodeAsset("lamp", 0, (0.1, 1e-7, 3.0), (half, 0.0, 0.0, half), light=LightAsset("spot", (1.0, 0.5, 0.25))),
            NodeAsset("eye", 0, camera=CameraAsset("orthographic", ymag=2.0)),
            NodeAsset(
                "skin", 1, (1 / 3, 0.0, 0.0), scale=(2.0, 2.0, 2.0), visible=False, joints=[0, 1], weights=[0.5],
                mesh=MeshRef("a.lmesh", 3, "m", ["x.material.toml", ""]), matrix=tuple(float(i) for i in range(16)),
            ),
        ],
        ["walk.lanim"],
        EnvironmentAsset("sky", turbidity=4.0),
        LookAsset(1.5, "agx"),
        2,
        {"source": "demo.glb"},
    )  # fmt: skip


def test_round_trip_and_same_text(tmp_path: Path) -> None:
    scene = make_scene()
    write_scene(tmp_path / "d.scene.json", scene)
    assert read_scene(tmp_path / "d.scene.json") == scene
    text = (tmp_path / "d.scene.json").read_text(encoding="utf-8")
    assert format_scene(parse_scene(text, "d")) == text


def test_layout_of_the_file() -> None:
    lines = format_scene(make_scene()).splitlines()
    nodes = lines[lines.index('"nodes": [') + 1 : lines.index("],")]
    assert len(nodes) == 4
    assert nodes[0] == '{"extras": {"a": [null, "ü"], "b": 1}, "name": "root"},'
    keys = [line.split('"')[1] for line in lines if line.startswith('"') and line != '"nodes": [']
    assert keys == sorted(keys)
    assert '"translation": [0.3333333333333333, 0.0, 0.0]' in nodes[3]


def test_whole_numbers_and_floats_give_the_same_text() -> None:
    a, b = SceneAsset("s", [NodeAsset("n", translation=(1, 2, 3))]), SceneAsset("s", [NodeAsset("n")])
    b.nodes[0].translation = (1.0, 2.0, 3.0)
    assert format_scene(a) == format_scene(b)


def test_rotation_is_normalised_with_a_finding() -> None:
    text = '{"schema": "lucarna.scene/1", "name": "s", "nodes": [{"name": "n", "rotation": [0, 3, 0, 4]}]}'
    findings = Findings("s")
    scene = parse_scene(text, "s", findings)
    assert scene.nodes[0].rotation == pytest.approx((0.0, 0.6, 0.0, 0.8))
    assert [f.code for f in findings] == ["scene.rotation"]
    assert "nodes[0].rotation" in str(next(iter(findings)))


def broken(**node: Any) -> str:
    return json.dumps({"schema": "lucarna.scene/1", "name": "s", "nodes": [{"name": "n", **node}]})


@pytest.mark.parametrize(
    ("text", "where", "message"),
    [
        (broken(parent=0), "nodes[0].parent", "before node 0"),
        (broken(parent=-2), "nodes[0].parent", "whole number"),
        (broken(parent=True), "nodes[0].parent", "whole number"),
        (broken(traslation=[0, 0, 0]), "nodes[0].traslation", "did you mean 'translation'"),
        (broken(translation=[0, 0]), "nodes[0].translation", "array of 3"),
        (broken(translation=[0, 0, "x"]), "nodes[0].translation[2]", "a string"),
        (broken(translation=[0, 0, math.inf]), "nodes[0].translation[2]", "finite"),
        (broken(translation=[0, 0, 10**400]), "nodes[0].translation[2]", "finite"),
        (broken(rotation=[0, 0, 0, 0]), "nodes[0].rotation", "length zero"),
        (broken(camera={"type": "perspektive"}), "nodes[0].camera.type", "did you mean 'perspective'"),
        (broken(camera={"yfov": 0}), "nodes[0].camera.yfov", "outside"),
        (broken(light={"color": [1, 1, -1]}), "nodes[0].light.color[2]", "outside"),
        (broken(mesh={"file": "a"}), "nodes[0].mesh", "'index' is missing"),
        (broken(joints=[1]), "nodes[0].joints", "outside the 1 nodes"),
        (broken(matrix=[1, 2]), "nodes[0].matrix", "array of 16"),
        ('{"schema": "lucarna.scene/9", "name": "s"}', "schema", "lucarna.scene/9"),
        ("[]", "schema", "None"),
        ('{"schema": "lucarna.scene/1", "name": "s", "active_camera": 0}', "active_camera", "outside"),
        (broken()[:-1] + ', "active_camera": 0}', "active_camera", "no camera"),
        (broken()[:-1] + ', "look": {"tone_map": "agX"}}', "look.tone_map", "agx"),
    ],
)
def test_wrong_values_say_where(text: str, where: str, message: str) -> None:
    with pytest.raises(FormatError) as info:
        parse_scene(text, "s.scene.json")
    assert info.value.where.path == where
    assert message in str(info.value)


def test_wrong_numbers_name_the_node_and_the_remedy() -> None:
    for text, remedy in ((broken(scale=[1, math.nan, 1]), "give a number"), (broken(rotation=[0] * 4), "[0, 0, 0, 1]")):
        with pytest.raises(FormatError, match="node 'n'") as info:
            parse_scene(text, "s")
        assert remedy in info.value.hint
    findings = Findings()
    parse_scene(broken(rotation=[0, 0, 0, 3]), "s", findings)
    assert "node 'n'" in findings.items[0].message
    assert findings.items[0].hint


def test_syntax_errors_have_line_and_column() -> None:
    with pytest.raises(FormatError) as info:
        parse_scene('{\n"name": "s",\n"nodes" []\n}', "s")
    assert (info.value.where.line, info.value.where.column) == (3, 9)
    with pytest.raises(FormatError):
        parse_scene("[" * 100_000, "s")
    with pytest.raises(FormatError):
        parse_scene(b"\xff\xfe\x00", "s")


def test_bad_scenes_are_not_written(tmp_path: Path) -> None:
    scene = make_scene()
    scene.nodes[1].translation = (0.0, math.nan, 0.0)
    with pytest.raises(FormatError, match=r"nodes\[1\]\.translation\[1\]"):
        write_scene(tmp_path / "x.scene.json", scene)
    assert not list(tmp_path.iterdir())


def test_damaged_text_raises_only_our_errors() -> None:
    good = format_scene(make_scene())
    rng = random.Random(11)
    for _ in range(400):
        text = list(good)
        for _ in range(rng.randint(1, 3)):
            text[rng.randrange(len(text))] = rng.choice('0129-.,:"[]{}eatn')
        try:
            parse_scene("".join(text), "s")
        except LucarnaError:
            continue


def test_lights_of_every_kind_come_back(tmp_path: Path) -> None:
    lights = [
        LightAsset("rectangle", (1.0, 0.5, 0.0), 3.0, 2.0, width=0.25, height=4.0, two_sided=True),
        LightAsset("disk", width=0.0), LightAsset("spot", temperature=2700.0, profile="lamps/a.ies"),
    ]  # fmt: skip
    scene = SceneAsset("s", [NodeAsset(f"n{k}", light=light) for k, light in enumerate(lights)])
    write_scene(tmp_path / "s.scene.json", scene)
    assert [node.light for node in read_scene(tmp_path / "s.scene.json").nodes] == lights
    spot = next(line for line in (tmp_path / "s.scene.json").read_text("utf-8").splitlines() if '"n2"' in line)
    assert '"width"' not in spot, "defaults are left out"
