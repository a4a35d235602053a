"""`lucarna export`: OBJ out of sources and converted scenes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.assets.clip import ClipAsset
from engine.core.errors import UsageError
from importers.cli.main import main
from importers.export.obj import find_clip, load_geometry, obj_bytes, time_of_frame
from importers.settings import ImportSettings
from tests.support.fbx_builder import QUAD, FbxBuilder

UV = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


@pytest.fixture
def source(tmp_path: Path) -> Path:
    fbx = FbxBuilder()
    node = fbx.node("plate one")
    fbx.mesh(node, QUAD, ((0, 1, 2, 3),), UV)
    fbx.material(node, "paint")
    fbx.curve(fbx.stack("Rig|Slide", 1.0, 2.0), node, "Lcl Translation", "d|X", [(1.0, 0.0), (2.0, 100.0)])
    return fbx.write(tmp_path / "a.fbx")


def lines(path: Path, kind: str) -> list[str]:
    return [line for line in path.read_text(encoding="utf-8").splitlines() if line.split(" ")[0] == kind]


def vertices(path: Path) -> np.ndarray:
    return np.array([line.split()[1:] for line in lines(path, "v")], float)


def test_static(source: Path, tmp_path: Path) -> None:
    out = tmp_path / "x.obj"
    assert main(["export", str(source), "--out", str(out), "--quiet"]) == 0
    np.testing.assert_allclose(vertices(out), [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]], atol=1e-7)
    assert lines(out, "o") == ["o plate_one"]
    assert lines(out, "usemtl") == ["usemtl paint"]
    assert lines(out, "vn") == ["vn 0 0 1"]
    assert lines(out, "vt") == ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]  # as in the source, v upwards
    assert lines(out, "f") == ["f 1/1/1 2/2/1 3/3/1", "f 1/1/1 3/3/1 4/4/1"]


@pytest.mark.parametrize(
    ("words", "x"),
    [
        (["--clip", "Rig|Slide", "--time", "0.5"], 0.5),
        (["--clip", "slide", "--frame", "36"], 0.5),  # 1.5 s in the file's own time
        (["--frame", "30"], 0.25),
        (["--time", "9"], 1.0),
        (["--clip", "slide"], 0.0),
    ],
)
def test_posed(source: Path, tmp_path: Path, words: list[str], x: float) -> None:
    out = tmp_path / "x.obj"
    assert main(["export", str(source), "--out", str(out), "--quiet", *words]) == 0
    assert vertices(out)[0, 0] == pytest.approx(x, abs=1e-6)


def test_a_converted_scene_gives_the_same(source: Path, tmp_path: Path) -> None:
    assert main(["convert", str(source), "--out", str(tmp_path / "out")]) == 0
    direct, scene = tmp_path / "direct.obj", tmp_path / "scene.obj"
    frame = ["--quiet", "--clip", "slide", "--frame", "36"]
    assert main(["export", str(source), "--out", str(direct), *frame]) == 0
    assert main(["export", str(tmp_path / "out" / "a.scene.json"), "--out", str(scene), *frame]) == 0
    np.testing.assert_array_equal(vertices(direct), vertices(scene))
    assert lines(direct, "f") == lines(scene, "f")


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["a.fbx", "--out", "x.fbx"], 2, "only .glb and .obj"),
        (["a.fbx", "--out", "x.obj", "--clip", "none"], 2, "'Rig|Slide'"),
        (["nothing.fbx", "--out", "x.obj"], 1, "no such file"),
        (["a.fbx", "--out", "x.obj", "--time", "1", "--frame", "2"], 2, "not allowed"),
    ],
)
def test_refusals(
    source: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: list[str], code: int,
    message: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(source.parent)
    assert main(["export", *words]) == code
    assert message in capsys.readouterr().err
    assert not (source.parent / "x.obj").exists()


def test_clip_names() -> None:
    clips = [ClipAsset("Rig|Walk"), ClipAsset("walk"), ClipAsset("Run", start=0.5, frame_rate=25.0)]
    assert find_clip(clips, "walk") is clips[1]
    assert find_clip(clips, "rig|walk") is clips[0]
    assert find_clip(clips, "RUN") is clips[2]
    with pytest.raises(UsageError):
        find_clip(clips, "jump")
    assert time_of_frame(clips[2], 25) == pytest.approx(0.5)
    assert time_of_frame(clips[0], 15) == pytest.approx(0.5)


def test_the_same_scene_gives_the_same_bytes(source: Path) -> None:
    first, second = (obj_bytes(load_geometry(source, ImportSettings())) for _ in range(2))
    assert first == second
