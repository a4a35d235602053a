"""Text files in the editor: saving, conflicts, problems, completion; without a window."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from editor.code.completion import completions, include_names
from editor.code.document import CodeDocument
from editor.code.files import CodeFiles, is_built_in
from editor.code.problems import IGNORED, Problem, all_problems, problems_of
from engine.core.errors import InputError, OutputError, Place, ShaderError
from engine.core.paths import shaders_dir
from engine.materials.effect import load_effect


def elsewhere(path: Path, text: str) -> None:
    """Another program saves the file."""
    path.write_text(text, encoding="utf-8")
    info = path.stat()
    os.utime(path, ns=(info.st_atime_ns, info.st_mtime_ns + 1_000_000))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    made = tmp_path / "a.frag"
    made.write_text("one\ntwo\n", encoding="utf-8")
    return made


def test_saves_what_was_typed_and_no_more(path: Path) -> None:
    document = CodeDocument(path)
    assert not document.save(), "nothing to do"
    document.edit("one\n2\n")
    assert document.dirty
    assert document.save()
    assert not document.dirty
    assert path.read_bytes() == b"one\n2\n"
    assert not document.look(), "our own save is no change"


def test_keeps_windows_line_ends(path: Path) -> None:
    path.write_bytes(b"one\r\ntwo\r\n")
    document = CodeDocument(path)
    assert document.text == "one\ntwo\n"
    document.edit("one\ntwo\nthree\n")
    document.save()
    assert path.read_bytes() == b"one\r\ntwo\r\nthree\r\n"


def test_a_change_elsewhere_is_taken_over_when_nothing_is_unsaved(path: Path) -> None:
    document = CodeDocument(path)
    elsewhere(path, "new\n")
    assert document.look()
    assert (document.text, document.dirty, document.conflict, document.revision) == ("new\n", False, False, 1)


def test_changes_on_both_sides_are_a_conflict_that_overwrites_nothing(path: Path) -> None:
    document = CodeDocument(path)
    document.edit("mine\n")
    elsewhere(path, "theirs\n")
    assert not document.save()
    assert document.conflict
    assert document.text == "mine\n"
    assert path.read_text(encoding="utf-8") == "theirs\n"
    document.keep_mine()
    assert document.save()
    assert path.read_text(encoding="utf-8") == "mine\n"


def test_theirs_can_be_taken(path: Path) -> None:
    document = CodeDocument(path)
    document.edit("mine\n")
    elsewhere(path, "theirs\n")
    document.look()
    document.take_theirs()
    assert (document.text, document.dirty, document.conflict) == ("theirs\n", False, False)


def test_the_same_change_on_both_sides_is_no_conflict(path: Path) -> None:
    document = CodeDocument(path)
    document.edit("same\n")
    elsewhere(path, "same\n")
    document.look()
    assert not document.conflict
    assert not document.dirty


def test_a_file_that_goes_can_be_written_again(path: Path) -> None:
    document = CodeDocument(path)
    path.unlink()
    assert document.look()
    assert document.gone
    assert document.save()
    assert path.read_text(encoding="utf-8") == "one\ntwo\n"


def test_what_is_no_text_is_refused(path: Path, tmp_path: Path) -> None:
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="not UTF-8"):
        CodeDocument(path)
    with pytest.raises(InputError, match="cannot be read"):
        CodeDocument(tmp_path / "gone.frag")


def test_read_only_documents_do_not_change(path: Path) -> None:
    document = CodeDocument(path, read_only=True)
    document.edit("other\n")
    assert not document.dirty
    with pytest.raises(OutputError, match="copy it into the project"):
        document.save()


def test_files_open_once_and_close(path: Path, tmp_path: Path) -> None:
    files = CodeFiles()
    first = files.open(path)
    other = tmp_path / "b.glsl"
    other.write_text("", encoding="utf-8")
    files.open(other, 3)
    assert files.front is not first
    assert files.cursor == (3, 1)
    assert files.open(path) is first
    files.close(first)
    assert files.front is not None
    assert files.front.path == other.resolve()
    files.close(files.front)
    assert files.front is None


def test_a_built_in_file_is_copied_to_its_place_in_the_project(tmp_path: Path) -> None:
    files = CodeFiles()
    built_in = files.open(shaders_dir() / "lib/color.glsl")
    assert is_built_in(built_in.path)
    copy = files.copy_into(built_in, tmp_path)
    assert copy.path == (tmp_path / "shaders/lib/color.glsl").resolve()
    assert copy.text == built_in.text
    assert files.documents == [copy]
    with pytest.raises(InputError, match="not one of the built-in"):
        files.copy_into(copy, tmp_path)


def test_an_error_of_many_places_is_many_problems() -> None:
    error = ShaderError(
        "`x' undeclared [fragment stage of 'a']\n    x = 1;\n    ^\n"
        "/p/b.glsl:7:3: wrong\n    y\n/p/b.glsl:7:3: so it is\nand 3 more",
        where=Place("/p/a.frag", 4, 5), hint="did you mean 'X'?",
    )  # fmt: skip
    first, second = problems_of(error)
    assert (first.place, first.message) == ("a.frag:4:5", "`x' undeclared")
    assert first.text == "`x' undeclared\n    x = 1;\n    ^\ndid you mean 'X'?"
    assert (second.file, second.line, second.message) == ("/p/b.glsl", 7, "wrong")
    assert "so it is" in second.detail
    assert first.badge == "running previous version: a.frag:4:5  `x' undeclared"


def test_a_count_of_mistakes_is_no_problem_itself() -> None:
    error = ShaderError("2 mistakes\n/p/a.effect.toml:1:1: one\n/p/a.effect.toml:2:1: two", where="/p/a.effect.toml")
    assert [p.message for p in problems_of(error)] == ["one", "two"]


def test_each_place_is_told_once() -> None:
    error = ShaderError("wrong", where=Place("/p/a.frag", 1, 1))
    told = all_problems([("previous", error), (IGNORED, error)])
    assert told == (Problem("/p/a.frag", 1, 1, "wrong"),)


@pytest.mark.parametrize(
    ("before", "typed", "first"),
    [
        ('#include "lib/co', "lib/co", "lib/color.glsl"),
        ("    s.metallic = m.met", "met", "metallic"),
        ("    vec4 t = sample_norm", "sample_norm", "sample_normal_map"),
        ("#if ALPHA", "ALPHA", "ALPHA_TEST"),
        ("    x = smooth", "smooth", "smoothstep"),
        ("    my_l", "my_l", "my_local"),
    ],
)
def test_completion(before: str, typed: str, first: str) -> None:
    effect = load_effect(shaders_dir() / "effects/surface.effect.toml")
    text = f"float my_local = 1.0;\n{before}\n"
    assert completions(before, text, include_names([shaders_dir()]), [effect])[0] == typed
    assert completions(before, text, include_names([shaders_dir()]), [effect])[1][0] == first
