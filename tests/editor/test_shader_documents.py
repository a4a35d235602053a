"""Text files in the editor: saving, conflicts, problems, completion; without a window."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from editor.code.completion import candidates, completions, include_names
from editor.code.document import CodeDocument
from editor.code.files import CodeFiles, is_built_in
from editor.code.gestures import Gestures
from editor.code.problems import IGNORED, Problem, all_problems, problems_of
from editor.code.search import Search, after
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


def test_keeps_a_byte_order_mark(path: Path) -> None:
    path.write_bytes(b"\xef\xbb\xbfone\n")
    document = CodeDocument(path)
    assert document.text == "one\n"
    document.edit("two\n")
    document.save()
    assert path.read_bytes() == b"\xef\xbb\xbftwo\n"
    document.edit("three\n")
    document.save()
    assert path.read_bytes() == b"\xef\xbb\xbfthree\n"


@pytest.mark.parametrize(
    ("raw", "edited", "written"),
    [
        (b"a\r\nb\nc\r\nd", "a\nb\nc\nD", b"a\r\nb\nc\r\nD"),
        (b"a\r\nb\nc\r\nd\r\n", "A\nb\nc\nd\n", b"A\r\nb\nc\r\nd\r\n"),
        (b"a\r\nb\nc\r\nd\r\n", "a\nb\nnew\nc\nd\n", b"a\r\nb\nnew\r\nc\r\nd\r\n"),
        (b"a\nb\r\nc\n", "a\nc\n", b"a\nc\n"),
        (b"a\rb\r", "a\nb\nc\n", b"a\rb\rc\r"),
        (b"a\r\nb\n", "", b""),
    ],
)
def test_lines_that_were_not_touched_keep_their_ends(path: Path, raw: bytes, edited: str, written: bytes) -> None:
    path.write_bytes(raw)
    document = CodeDocument(path)
    document.edit(edited)
    document.save()
    assert path.read_bytes() == written


def test_searching_and_replacing() -> None:
    text = "Roughness = roughness;\nroughness_map"
    assert Search("roughness").places(text) == [(0, 0, 9), (0, 12, 21), (1, 0, 9)]
    assert Search("roughness", case=True).places(text) == [(0, 12, 21), (1, 0, 9)]
    assert Search("roughness", word=True).places(text) == [(0, 0, 9), (0, 12, 21)]
    assert Search("").places(text) == []
    assert Search("roughness", r"\1", word=True).replaced(text) == "\\1 = \\1;\nroughness_map"
    places = Search("roughness").places(text)
    assert [after(places, 0, 1, 1), after(places, 1, 1, 1), after(places, 0, 0, -1), after(places, 1, 0, -1)] == [
        1,
        0,
        2,
        1,
    ]


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


@pytest.mark.parametrize(
    ("text", "typed", "first"),
    [
        ('schema = "lucarna.material/1"\nque', "que", "queue"),
        ('schema = "lucarna.material/1"\nqueue = "tr', "tr", "transparent"),
        ('schema = "lucarna.material/1"\n[params]\nrou', "rou", "roughness"),
        ('schema = "lucarna.material/1"\n[textures.normal_map]\nwrap_u = "cl', "cl", "clamp"),
        ('schema = "lucarna.material/1"\nfeatures = ["unl', "unl", "unlit"),
        ('name = "x"\n[params.wetness]\ntype = "color', "color", "color3"),
        ('name = "x"\n[technique.forward]\ndepth = { test = true, compare = "gre', "gre", "greater"),
        ('name = "x"\n[tech', "tech", "technique"),
    ],
)
def test_completion_in_effect_and_material_files(text: str, typed: str, first: str) -> None:
    effect = load_effect(shaders_dir() / "effects/surface.effect.toml")
    line = text.count("\n") + 1
    found = candidates(text.split("\n")[-1], text, line, "toml", [], [effect])
    assert (found[0], found[1][0].name) == (typed, first)


def test_candidates_say_what_they_are() -> None:
    effect = load_effect(shaders_dir() / "effects/surface.effect.toml")
    text = '#include "lib/lights.glsl"\n  sun_l'
    found = candidates("  sun_l", text, 2, "glsl", [], [effect], [shaders_dir()])[1][0]
    assert found.name == "sun_lighting"
    assert found.about.endswith("→ vec3")
    assert "lib/lights.glsl" in found.doc, "a function of what is included"
    clamp = candidates("  clam", "clam", 1, "glsl", [], [effect])[1][0]
    assert clamp.about == "clamp(T x, T low, T high)"
    member = candidates("m.roughn", "m.roughn", 1, "glsl", [], [effect])[1][0]
    assert (member.name, member.about) == ("roughness", "float")
    assert "perceptual" in member.doc


def test_a_large_text_is_searched_and_saved(tmp_path: Path) -> None:
    path = tmp_path / "large.glsl"
    lines = 40_000
    path.write_text("".join(f"float v{i} = {i}.0;\r\n" for i in range(lines)), encoding="utf-8", newline="")
    document = CodeDocument(path)
    assert len(Search("v39999").places(document.text)) == 1
    document.edit(document.text.replace("v39999 ", "last "))
    assert document.save()
    assert path.read_bytes().endswith(b"float last = 39999.0;\r\n")


def test_letters_typed_in_one_go_are_one_step_of_undo() -> None:
    gestures = Gestures(0)
    for i in range(5):
        gestures.edited(i, i + 1, 0.1 * i, typing=True)
    gestures.edited(5, 6, 3.0, typing=True)  # after a pause
    gestures.edited(6, 7, 3.1, typing=False)  # a paste
    gestures.edited(7, 8, 3.2, typing=True)
    assert [gestures.undone_to(index) for index in (7, 6, 5, 4)] == [7, 6, 5, 0]
    assert [gestures.redone_to(index) for index in (1, 6, 7, 8)] == [5, 6, 7, 8]
    gestures.edited(5, 6, 9.0, typing=True)  # another way than what was undone
    assert gestures.undone_to(5) == 5
    assert gestures.redone_to(6) == 6
