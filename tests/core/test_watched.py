"""Which files changed, by mtime and size."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from engine.core.watched import Watched


def touch(path: Path, text: str, when: int) -> None:
    path.write_text(text, encoding="utf-8")
    os.utime(path, ns=(when, when))


def test_changed_gone_new_and_looked_at(tmp_path: Path) -> None:
    a, b, c = (tmp_path / name for name in "abc")
    touch(a, "1", 10)
    touch(b, "1", 10)
    watched = Watched()
    watched.add([a, b, c])
    assert watched.changed() == set()
    touch(a, "2", 11)
    b.unlink()
    touch(c, "new", 10)
    assert watched.changed() == {a, b, c}
    assert watched.take() == {a, b, c}
    assert watched.changed() == set()


def test_the_size_counts_where_the_clock_is_coarse(tmp_path: Path) -> None:
    path = tmp_path / "a"
    touch(path, "1", 10)
    watched = Watched()
    watched.add([path])
    touch(path, "12", 10)
    assert watched.changed() == {path}


def test_a_path_watched_twice_keeps_its_first_stamp(tmp_path: Path) -> None:
    path = tmp_path / "a"
    touch(path, "1", 10)
    watched = Watched()
    watched.add([path])
    touch(path, "2", 11)
    watched.add([path])
    assert watched.take() == {path}
    watched.invalidate()
    assert watched.changed() == {path}


def test_a_save_by_rename_counts_though_clock_and_size_say_nothing(tmp_path: Path) -> None:
    """As on FAT, or after `git checkout` of a file of equal length within one tick."""
    path, other = tmp_path / "a", tmp_path / "a.tmp"
    touch(path, "1", 2_000_000_000)
    watched = Watched()
    watched.add([path])
    deadline = path.stat().st_ctime_ns
    while True:  # until the clock of this file system has ticked
        touch(other, "2", 2_000_000_000)
        if other.stat().st_ctime_ns != deadline:
            break
    other.replace(path)
    assert watched.take() == {path}
    assert watched.changed() == set()


def test_a_mount_that_does_not_answer_for_a_while(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A stale handle reads as "gone"; when it answers again the file is as it was, and is looked at once more."""
    path = tmp_path / "a"
    touch(path, "1", 10)
    watched = Watched()
    watched.add([path])
    with monkeypatch.context() as mount:
        mount.setattr(Path, "stat", _stale)
        assert watched.take() == {path}
        assert watched.changed() == set()
    assert watched.take() == {path}
    assert watched.changed() == set()


def _stale(path: Path, **_: object) -> os.stat_result:
    raise OSError(errno.ESTALE, "Stale file handle", str(path))


def test_a_folder_tells_of_what_comes_into_it(tmp_path: Path) -> None:
    os.utime(tmp_path, ns=(0, 0))
    watched = Watched()
    watched.add([tmp_path])
    (tmp_path / "new").write_text("1", encoding="utf-8")
    assert watched.take() == {tmp_path}
