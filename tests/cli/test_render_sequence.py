"""Picture sequences, turntables and videos from the command line."""

from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

import numpy as np
import pytest

from engine.assets.clip import Channel, ClipAsset
from engine.assets.lanim import write_lanim
from engine.assets.lmesh import write_lmesh
from engine.assets.primitives import cube
from engine.assets.scene import MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import write_scene
from engine.core.errors import UsageError
from engine.report.image import load_png
from importers.cli import render
from importers.cli.main import main
from importers.cli.render_sequence import Video, check_arguments, picture_name, sequence


def parse(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    render.add_arguments(parser)
    return parser.parse_args(["scene.json", *words])


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A cube that goes 3 m to the right in a second, and in a second clip up."""
    write_lmesh(tmp_path / "a.lmesh", [cube()], {})
    for name, axis in (("right", 0), ("up", 1)):
        values = np.zeros((2, 3), np.float32)
        values[1, axis] = 3.0
        channel = Channel(0, "translation", "linear", np.array([0.0, 1.0], np.float32), values, "box")
        write_lanim(tmp_path / f"{name}.lanim", ClipAsset(name, [channel]))
    nodes = [NodeAsset("box", mesh=MeshRef("a.lmesh", 0, "cube", [""]))]
    write_scene(tmp_path / "a.scene.json", SceneAsset("a", nodes, clips=["right.lanim", "up.lanim"]))
    return tmp_path / "a.scene.json"


def test_ranges_and_times() -> None:
    plan = sequence(parse("--out", "x.png", "--frames", "2:5", "--fps", "10"), 9.0)
    assert plan is not None
    assert (plan.numbers, plan.turns) == ([2, 3, 4], None)
    np.testing.assert_allclose(plan.times, [0.2, 0.3, 0.4])
    whole = sequence(parse("--out", "x.png", "--frames", "all"), 2.0)
    assert whole is not None
    assert (whole.numbers[0], whole.numbers[-1]) == (0, 47)
    turn = sequence(parse("--out", "x.png", "--turntable", "4", "--time", "0.5"), 2.0)
    assert turn is not None
    assert (turn.times, turn.turns) == ([0.5] * 4, [0.0, 90.0, 180.0, 270.0])
    assert sequence(parse("--out", "x.png"), 2.0) is None


def test_names() -> None:
    assert picture_name(Path("a/walk_%03d.png"), 7) == Path("a/walk_007.png")
    assert picture_name(Path("walk.%d.exr"), 12) == Path("walk.12.exr")
    assert picture_name(Path("walk.png"), 7) == Path("walk_0007.png")


@pytest.mark.parametrize(
    "words",
    [
        "--out x.png --frames 5:2", "--out x.png --frames 5", "--out x.png --frames=-1:2",
        "--out x.png --frames a:b", "--out x.png --frames 0:2 --turntable 3", "--out x.png --frames 0:2 --fps 0",
        "--out x.png --frames 0:2 --fps nan", "--out x.png --turntable -2", "--out x.mp4",
        "--out x.gif --frames 0:2", "--out x", "--out x_%d_%d.png --frames 0:2", "--out x_%s.png --frames 0:2",
        "--out x.png --turntable 4 --camera main", "--out x.png --turntable 4 --eye 1,2,3",
    ],
)  # fmt: skip
def test_nonsense_is_refused_before_anything_is_opened(words: str) -> None:
    with pytest.raises(UsageError):
        check_arguments(parse(*words.split()))


def test_pictures_of_the_chosen_clip(scene: Path, tmp_path: Path, gl_device) -> None:
    out = tmp_path / "p_%02d.png"
    base = ["render", str(scene), "--out", str(out), "--size", "64x64", "--frames", "0:3", "--fps", "3"]
    assert main([*base, "--orbit", "0,0"]) == 0
    pictures = [load_png(tmp_path / f"p_{i:02d}.png") for i in range(3)]
    assert sorted(p.name for p in tmp_path.glob("p_*")) == ["p_00.png", "p_01.png", "p_02.png"]
    assert horizontal(pictures[0]) < horizontal(pictures[1]) < horizontal(pictures[2])
    assert main([*base, "--orbit", "0,0", "--clip", "up"]) == 0
    pictures = [load_png(tmp_path / f"p_{i:02d}.png") for i in range(3)]
    assert abs(horizontal(pictures[0]) - horizontal(pictures[2])) < 2.0
    assert main([*base, "--clip", "down"]) == 1


def test_progress_is_told_in_a_pipe_and_a_stop_says_what_is_there(
    scene: Path, tmp_path: Path, gl_device, capsys, monkeypatch
) -> None:
    base = ["render", str(scene), "--out", str(tmp_path / "q.png"), "--size", "16x16", "--frames", "0:4"]
    assert main(base) == 0
    lines = [line.split()[0] for line in capsys.readouterr().err.splitlines() if " %" in line]
    assert lines == ["1/4", "2/4", "3/4", "4/4"]
    written = []

    def stop(runtime, view, out, **options):
        if len(written) == 2:
            raise KeyboardInterrupt
        written.append(out)
        return whole(runtime, view, out, **options)

    whole = render._write
    monkeypatch.setattr(render, "_write", stop)
    assert main(base) == 130
    assert "2 of 4 pictures were written" in capsys.readouterr().err


def horizontal(picture: np.ndarray) -> float:
    """Where, in pixels from the left, what stands out of the background lies on average."""
    image = picture[:, :, :3].astype(float)
    background = np.median(image, axis=1, keepdims=True)
    off = np.abs(image - background).sum(axis=2)
    return float((off.sum(axis=0) * np.arange(image.shape[1])).sum() / max(off.sum(), 1e-9))


def test_a_turntable_goes_round_at_one_distance(scene: Path, tmp_path: Path, gl_device) -> None:
    words = ["render", str(scene), "--size", "64x64", "--view", "base_color", "--environment", "none"]
    assert main([*words, "--out", str(tmp_path / "t.png"), "--turntable", "4", "--orbit", "0,10"]) == 0
    pictures = [load_png(tmp_path / f"t_{i:04d}.png").astype(float) for i in range(4)]
    # a cube looks the same from all four sides but for its light: its outline stands still
    for picture in pictures[1:]:
        assert abs(horizontal(picture) - horizontal(pictures[0])) < 3.0


def test_a_video_has_every_frame(scene: Path, tmp_path: Path, gl_device) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    out = tmp_path / "v.mp4"
    assert (
        main(
            [
                "render",
                str(scene),
                "--out",
                str(out),
                "--size",
                "64x64",
                "--frames",
                "0:6",
                "--fps",
                "12",
                "--orbit",
                "0,0",
            ]
        )
        == 0
    )
    decode = [ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-i", str(out), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(decode, check=True, capture_output=True).stdout
    frames = np.frombuffer(raw, np.uint8).reshape(-1, 64, 64, 3)
    assert len(frames) == 6
    assert horizontal(frames[0]) < horizontal(frames[3]) < horizontal(frames[5])
    before = out.read_bytes()
    with pytest.raises(RuntimeError, match="stop"):
        stopped_after_one(out, frames[0])
    assert out.read_bytes() == before  # an unfinished video replaces nothing
    assert main(["render", str(scene), "--out", str(tmp_path / "o.mp4"), "--size", "63x64", "--frames", "0:2"]) == 2
    assert not (tmp_path / "o.mp4").exists()
    assert [p.name for p in tmp_path.glob(".*")] == []


def stopped_after_one(out: Path, frame: np.ndarray) -> None:
    with Video(out, 12.0, (64, 64)) as video:
        video.add(frame)
        raise RuntimeError("stop")
