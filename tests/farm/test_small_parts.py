"""The trace of what an import reads, the line of a terminal, flags made from declarations."""

from __future__ import annotations

import argparse
import io
import threading
from pathlib import Path

import pytest

from engine.core.errors import UsageError
from importers.cli.settings_flags import add_settings, given_settings
from importers.farm.job import Job, Outcome
from importers.farm.progress import ProgressLine
from importers.farm.trace import Trace
from importers.settings import declared


def test_a_trace_hears_what_is_read_and_listed(tmp_path: Path) -> None:
    for name in ("read.txt", "passed.txt", "before.txt", "kept/cache.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("x")
    (tmp_path / "before.txt").read_text()
    with Trace((tmp_path / "kept",)) as trace:
        (tmp_path / "read.txt").read_text()
        (tmp_path / "kept" / "cache.txt").read_text()
        (tmp_path / "made.txt").write_text("y")
        list((tmp_path / "kept").parent.iterdir())
        (tmp_path / "passed.txt").stat()
    (tmp_path / "passed.txt").read_text()
    assert list(trace.files) == [str(tmp_path / "read.txt")]
    assert list(trace.folders) == [str(tmp_path)]


@pytest.mark.parametrize("own", [True, False])
def test_a_trace_of_one_thread(tmp_path: Path, own: bool) -> None:
    (tmp_path / "a.txt").write_text("x")
    with Trace(own_thread=own) as trace:
        thread = threading.Thread(target=(tmp_path / "a.txt").read_text)
        thread.start()
        thread.join()
    assert (str(tmp_path / "a.txt") in trace.files) is not own


def test_the_progress_line_tells_counts_rate_and_what_is_slow() -> None:
    line = ProgressLine(10, io.StringIO())
    assert not line.shown
    line._started = 100.0
    slow, quick = Job(Path("a/barn.fbx"), Path("o"), "barn"), Job(Path("a/fox.glb"), Path("o"), "fox")
    line.done(Outcome(Job(Path("x"), Path("o"), "x"), "up to date"))
    line.start(slow)
    line.start(quick)
    line.done(Outcome(quick, "converted"))
    line._running[slow.source] = 101.0
    assert line.text(108.0) == "[2/10]  0.2/s  1 up to date, 1 converted  1:04 left  slow: barn.fbx 7 s"


def parser(**taken: str) -> argparse.ArgumentParser:
    made = argparse.ArgumentParser()
    for flag in taken.values():
        made.add_argument(flag)
    add_settings(made)
    return made


def test_every_setting_has_its_flag() -> None:
    assert given_settings(parser().parse_args([])) == {}
    words = ["--no-compress", "--quality", "high", "--max-texture-size", "64", "--allow-outside"]
    assert given_settings(parser().parse_args(words)) == {
        "compress": False, "quality": "high", "max_texture_size": 64, "allow_outside": True,
    }  # fmt: skip
    text = parser().format_help()
    for info in declared().values():
        if info.flag and info.group != "run":
            assert info.flag[2:] in text


def test_a_flag_that_the_command_has_itself() -> None:
    made = parser(quality="--quality")
    assert given_settings(made.parse_args(["--quality", "x", "--import-quality", "draft"])) == {"quality": "draft"}


def test_a_flag_out_of_range() -> None:
    with pytest.raises(UsageError, match="--max-texture-size: max_texture_size is -1"):
        given_settings(parser().parse_args(["--max-texture-size", "-1"]))
