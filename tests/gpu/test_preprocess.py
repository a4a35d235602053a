from __future__ import annotations

from pathlib import Path

import pytest

from engine.core.errors import ShaderError, UsageError
from engine.gpu.preprocess import Texts, flatten


def put(root: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return root


def code(text: str) -> list[str]:
    return [line for line in text.splitlines() if line and not line.startswith("#")]


def test_defines_then_prelude_then_files_with_their_lines(tmp_path: Path) -> None:
    put(
        tmp_path,
        {"a.frag": 'float before;\n#include "lib/b.glsl"\nfloat after;\n', "lib/b.glsl": "float b1;\nfloat b2;\n"},
    )
    source = flatten(
        tmp_path / "a.frag", "fragment", search=[tmp_path], prelude="float p;\n", defines={"SHADOWS": 1, "LIGHTS": "4"}
    )
    rows = list(zip(source.text.splitlines(), source.lines, strict=True))
    a, b = str(tmp_path / "a.frag"), str(tmp_path / "lib/b.glsl")
    assert rows == [
        ("#define STAGE_FRAGMENT 1", ("<defines>", 1)),
        ("#define LIGHTS 4", ("<defines>", 2)),
        ("#define SHADOWS 1", ("<defines>", 3)),
        ("float p;", ("<prelude>", 1)),
        ("float before;", (a, 1)),
        ("float b1;", (b, 1)),
        ("float b2;", (b, 2)),
        ("float after;", (a, 3)),
    ]
    assert source.stage == "fragment"


def test_each_file_once_whatever_the_path_to_it(tmp_path: Path) -> None:
    put(tmp_path, {
        "fx/a.frag": '#include "lib/b.glsl"\n#include "lib/c.glsl"\n#include "../lib/c.glsl"\n',
        "lib/b.glsl": '#include "c.glsl"\nfloat b;\n',
        "lib/c.glsl": "float c;\n",
    })  # fmt: skip
    assert code(flatten(tmp_path / "fx/a.frag", "fragment", search=[tmp_path]).text) == ["float c;", "float b;"]


def test_beside_the_including_file_wins_over_search(tmp_path: Path) -> None:
    put(tmp_path, {"fx/a.frag": '#include "x.glsl"\n', "fx/x.glsl": "float near;\n", "x.glsl": "float far;\n"})
    assert code(flatten(tmp_path / "fx/a.frag", "fragment", search=[tmp_path]).text) == ["float near;"]


def test_calls_that_share_texts_see_one_state_of_the_disk(tmp_path: Path) -> None:
    own, theirs = tmp_path / "own", tmp_path / "theirs"
    put(theirs, {"a.frag": '#include "lib.glsl"\n', "lib.glsl": "theirs;\n"})
    own.mkdir()
    texts = Texts()

    def text(texts: Texts) -> str:
        return flatten(theirs / "a.frag", "fragment", search=[own, tmp_path / "more", theirs], texts=texts).text

    before = text(texts)
    assert "theirs;" in before
    (theirs / "lib.glsl").unlink()
    put(own, {"lib.glsl": "own;\n"})
    assert text(texts) == before
    assert "own;" in text(Texts())


def test_include_first_met_inside_an_if_is_still_there_outside(tmp_path: Path) -> None:
    put(tmp_path, {
        "a.frag": '#if SHADOWS\n#include "b.glsl"\n#endif\n#include "b.glsl"\n#include "b.glsl"\n',
        "b.glsl": "float b;\n",
    })  # fmt: skip
    text = flatten(tmp_path / "a.frag", "fragment", search=[]).text
    assert text.splitlines()[1:] == [
        "#if SHADOWS", "#ifndef INCLUDED_0", "#define INCLUDED_0 1", "float b;", "#endif", "#endif",
        "#ifndef INCLUDED_0", "#define INCLUDED_0 1", "float b;", "#endif",
    ]  # fmt: skip


def test_includes_in_comments_are_comments(tmp_path: Path) -> None:
    put(tmp_path, {"a.frag": '// #include "no.glsl"\n/* see\n#include "no.glsl"\n*/ float a; // /*\nfloat b;\n'})
    assert "float b;" in flatten(tmp_path / "a.frag", "fragment", search=[]).text


def test_missing_include_names_place_and_the_likely_file(tmp_path: Path) -> None:
    put(tmp_path, {"a.frag": 'float x;\n  #include "lib/brfd.glsl"\n', "lib/brdf.glsl": ""})
    with pytest.raises(ShaderError) as caught:
        flatten(tmp_path / "a.frag", "fragment", search=[tmp_path])
    assert (caught.value.where.file, caught.value.where.line, caught.value.where.column) == (
        str(tmp_path / "a.frag"), 2, 12,
    )  # fmt: skip
    assert "did you mean 'lib/brdf.glsl'?" in str(caught.value)


def test_missing_file(tmp_path: Path) -> None:
    put(tmp_path, {"surface.frag": ""})
    with pytest.raises(ShaderError, match=r"no such shader file.*did you mean 'surface.frag'"):
        flatten(tmp_path / "surfaces.frag", "fragment", search=[tmp_path])


def test_cycle_names_the_chain(tmp_path: Path) -> None:
    put(tmp_path, {"a.glsl": '#include "b.glsl"\n', "b.glsl": '\n#include "c.glsl"\n', "c.glsl": '#include "b.glsl"\n'})
    with pytest.raises(ShaderError, match=r"c\.glsl:1:10: .*cycle: b\.glsl -> c\.glsl -> b\.glsl"):
        flatten(tmp_path / "a.glsl", "vertex", search=[])
    put(tmp_path, {"self.glsl": '#include "self.glsl"\n'})
    with pytest.raises(ShaderError, match="cycle"):
        flatten(tmp_path / "self.glsl", "vertex", search=[])


def test_conditional_cycle_and_blow_up_are_errors(tmp_path: Path) -> None:
    put(tmp_path, {"a.glsl": '#if 0\n#include "a.glsl"\n#endif\n'})
    with pytest.raises(ShaderError, match="cycle"):
        flatten(tmp_path / "a.glsl", "vertex", search=[])
    files = {f"n{i}.glsl": f'#include "n{i + 1}.glsl"\n#include "n{i + 1}.glsl"\n' for i in range(20)}
    put(tmp_path, {**files, "n20.glsl": "float x;\n", "top.glsl": '#if 1\n#include "n0.glsl"\n#endif\n'})
    with pytest.raises(ShaderError, match="more than 2000 files through #include"):
        flatten(tmp_path / "top.glsl", "vertex", search=[])


@pytest.mark.parametrize("line", ["#include <x.glsl>", "#include x.glsl", '#include "x.glsl', '#include ""'])
def test_malformed_include(tmp_path: Path, line: str) -> None:
    put(tmp_path, {"a.frag": line + "\n"})
    with pytest.raises(ShaderError, match=r"a\.frag:1:1: #include needs a file in double quotes"):
        flatten(tmp_path / "a.frag", "fragment", search=[])


def test_include_outside_the_shader_folders(tmp_path: Path) -> None:
    put(tmp_path, {"secret.txt": "x", "shaders/a.frag": '#include "../secret.txt"\n'})
    with pytest.raises(ShaderError, match="outside the shader folders"):
        flatten(tmp_path / "shaders/a.frag", "fragment", search=[tmp_path / "shaders"])


def test_version_line_is_refused(tmp_path: Path) -> None:
    put(tmp_path, {"a.frag": "// c\n#version 330\n"})
    with pytest.raises(ShaderError, match=r"a\.frag:2:1: #version"):
        flatten(tmp_path / "a.frag", "fragment", search=[])


def test_not_text_and_wrong_stage(tmp_path: Path) -> None:
    (tmp_path / "a.frag").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ShaderError, match="not UTF-8"):
        flatten(tmp_path / "a.frag", "fragment", search=[])
    with pytest.raises(UsageError, match="unknown shader stage"):
        flatten(tmp_path / "a.frag", "pixel", search=[])
