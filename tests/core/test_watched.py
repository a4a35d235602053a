"""Which files changed, by mtime and size."""

from __future__ import annotations

import os
from pathlib import Path

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
