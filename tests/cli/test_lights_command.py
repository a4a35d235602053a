"""`lucarna lights` and `lucarna new --sample`: what they write can be opened, what is wrong is said."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from engine.app.project import load_project
from engine.assets.clip_nodes import clip_nodes
from engine.assets.lanim import read_lanim
from engine.assets.samples.sample import make_sample, write_sample
from engine.assets.scene_json import read_scene
from importers.cli.main import main

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return write_sample(make_sample("poles", lights=0), tmp_path)


def test_scattered_over_what_is_drawn(scene: Path, capsys: Capture) -> None:
    out = scene.with_name("lit.scene.json")
    words = ["lights", str(scene), "--out", str(out), "--scatter", "30", "--drift", "0.5", "--set", "range=2", "--json"]
    assert main(words) == 0
    told = json.loads(capsys.readouterr().out)
    assert told == {"lights": 30, "written": [str(scene.with_name("lit.drift.lanim")), str(out)]}
    made = read_scene(out)
    lamps = [node for node in made.nodes if node.light is not None]
    assert len(lamps) == 30
    assert all(abs(n.translation[0]) <= 22.0 and -0.2 <= n.translation[1] <= 6.0 for n in lamps)
    assert all(n.light.range == 2.0 for n in lamps if n.light)
    clip = read_lanim(scene.with_name(made.clips[0]))
    assert [c.target for c in clip.channels] == [n.name for n in lamps]
    assert [made.nodes[c.node].name for c in clip.channels] == [n.name for n in lamps]


def test_in_a_box(scene: Path) -> None:
    out = scene.with_name("lit.scene.json")
    box = ["--box", "0", "1", "2", "0", "1", "2"]
    assert main(["lights", str(scene), "--out", str(out), "--scatter", "3", "--kind", "disk", *box]) == 0
    lamps = [node for node in read_scene(out).nodes if node.light is not None]
    assert {node.translation for node in lamps} == {(0.0, 1.0, 2.0)}
    assert {node.light.type for node in lamps if node.light} == {"disk"}


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--out", "elsewhere/x.scene.json"], "beside the old one"),
        (["--out", "x.json"], "ends in .scene.json"),
        (["--out", "x.scene.json", "--kind", "laser"], "laser"),
        (["--out", "x.scene.json", "--set", "rnage=3"], "did you mean 'range'"),
        (["--out", "x.scene.json", "--scatter", "0"], "count"),
    ],
)
def test_what_is_refused(scene: Path, words: list[str], complaint: str, capsys: Capture) -> None:
    words = [str(scene.parent / w) if w.endswith("json") else w for w in words]
    assert main(["lights", str(scene), *words]) == 2
    assert complaint in capsys.readouterr().err
    assert sorted(p.name for p in scene.parent.iterdir() if p.name.startswith("x")) == []


@pytest.mark.parametrize("name", ["atrium", "poles"])
def test_a_project_from_a_sample(name: str, tmp_path: Path, capsys: Capture) -> None:
    assert main(["new", str(tmp_path / "mine"), "--sample", name, "--lights", "12"]) == 0
    assert f"--out {name}.png" in capsys.readouterr().out
    project = load_project(tmp_path / "mine")
    assert project.name == "mine"
    assert sum(node.light is not None for node in read_scene(project.start).nodes) == 12
    assert not [p for p in tmp_path.iterdir() if p.name != "mine"]


def test_samples_that_there_are_not(tmp_path: Path, capsys: Capture) -> None:
    assert main(["new", str(tmp_path / "mine"), "--sample", "atrum"]) == 2
    assert "did you mean 'atrium'" in capsys.readouterr().err
    assert main(["new", str(tmp_path / "mine"), "--lights", "3"]) == 2
    assert main(["new", str(tmp_path / "mine"), "--sample", "atrium", "--lights", "999999"]) == 2
    assert not list(tmp_path.iterdir())


def test_drift_beside_what_moves_already(tmp_path: Path) -> None:
    """Clips know nodes by number: those of a second scatter must be none of the first one's."""
    first = write_sample(make_sample("poles", lights=0), tmp_path)
    second, third = first.with_name("two.scene.json"), first.with_name("three.scene.json")
    words = ["--scatter", "3", "--drift", "0.5", "--box", "0", "1", "0", "9", "2", "9"]
    assert main(["lights", str(first), "--out", str(second), *words]) == 0
    assert main(["lights", str(second), "--out", str(third), *words, "--seed", "2"]) == 0
    made = read_scene(third)
    assert made.clips == ["two.drift.lanim", "three.drift.lanim"]
    bind = clip_nodes(made.nodes)
    assert bind is not None
    moved = [c.node for file in made.clips for c in bind.bind(read_lanim(third.with_name(file))).channels]
    assert moved == [i for i, node in enumerate(made.nodes) if node.light is not None]


def test_an_array_of_a_node(scene: Path, capsys: Capture) -> None:
    one, ring = scene.with_name("one.scene.json"), scene.with_name("ring.scene.json")
    box = ["--box", "0", "1", "2", "0", "1", "2"]
    assert main(["lights", str(scene), "--out", str(one), "--scatter", "1", *box]) == 0
    words = ["lights", str(one), "--out", str(ring), "--array", "Point light 1", "--json"]
    capsys.readouterr()
    assert main([*words, "--set", "shape=ring", "--set", "count=4", "--set", "radius=2"]) == 0
    assert json.loads(capsys.readouterr().out)["nodes"] == 3
    lamps = [node for node in read_scene(ring).nodes if node.light is not None]
    assert [node.name for node in lamps] == [f"Point light {i}" for i in (1, 2, 3, 4)]
    places = np.array([node.translation for node in lamps])
    # about +Y, from +X over -Z: the middle lies two metres along -X of the first
    assert np.allclose(places, [[0, 1, 2], [-2, 1, 0], [-4, 1, 2], [-2, 1, 4]], atol=1e-9)
    assert main([*words[:5], "Point lihgt 1"]) == 2
    assert "did you mean 'Point light 1'" in capsys.readouterr().err
