"""TomlSource: every key and value has a line and a column, and errors show them."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from engine.core.errors import FormatError, InputError, LucarnaError
from engine.core.toml_source import dotted, load_toml, parse_toml

TEXT = """\
# a comment with [brackets] = "and quotes
name = "surface"
"quoted.key" = 'a # b'
a.b.c = 1

[features.normal_map]
doc = \"\"\"many
lines \\\"\"\" and ]\"\"\"
list = [1, [2, 3],
  # inside
  { x = 1, "y" = [4] },
]
[[technique]]
id = 1
[technique.depth]
test = true
[[technique]]
id = 2
depth = { compare = "gequal", write = true }
"""


@pytest.mark.parametrize(
    ("keypath", "line", "column", "value"),
    [
        (("name",), 2, 1, False),
        (("name",), 2, 8, True),
        (("quoted.key",), 3, 1, False),
        (("a", "b", "c"), 4, 5, False),
        (("features", "normal_map"), 6, 1, False),
        (("features", "normal_map", "doc"), 7, 1, False),
        (("features", "normal_map", "list", 1, 1), 9, 16, False),
        (("features", "normal_map", "list", 2, "y", 0), 11, 19, False),
        (("technique", 0, "id"), 14, 1, False),
        (("technique", 0, "depth", "test"), 16, 1, False),
        (("technique", 1), 17, 1, False),
        (("technique", 1, "depth", "write"), 19, 31, False),
        (("technique", 1, "depth", "write"), 19, 39, True),
    ],
)
def test_places(keypath: tuple[str | int, ...], line: int, column: int, value: bool) -> None:
    place = parse_toml(TEXT, "f.toml").place(keypath, value=value)
    assert (place.line, place.column) == (line, column)
    assert place.path == dotted(keypath)


def test_unknown_key_falls_back_to_its_parent() -> None:
    place = parse_toml(TEXT, "f.toml").place("features.normal_map.nope")
    assert (place.line, place.column, place.path) == (6, 1, "features.normal_map.nope")


def test_error_shows_line_and_caret() -> None:
    error = parse_toml(TEXT, "f.toml").error(("a", "b", "c"), "wrong", hint="fix it")
    assert str(error) == "f.toml:4:5: a.b.c: wrong\n    a.b.c = 1\n        ^ (fix it)"


def test_syntax_error_has_place_and_caret() -> None:
    with pytest.raises(FormatError) as info:
        parse_toml("a = 1\nb = = 2\n", "f.toml")
    assert (info.value.where.line, info.value.where.column) == (2, 5)
    assert str(info.value).endswith("    b = = 2\n        ^")


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        load_toml(tmp_path / "absent.toml")
    with pytest.raises(InputError):
        load_toml(tmp_path)
    (tmp_path / "latin.toml").write_bytes(b"a = 1\nb = '\xe9'\n")
    with pytest.raises(FormatError) as info:
        load_toml(tmp_path / "latin.toml")
    assert (info.value.where.line, info.value.where.column) == (2, 6)


def test_deep_nesting_is_a_format_error() -> None:
    with pytest.raises(FormatError):
        parse_toml("a = " + "[" * 100_000, "f.toml")


def test_mutated_text_raises_only_our_errors() -> None:
    rng = random.Random(1)
    for _ in range(300):
        text = list(TEXT)
        for _ in range(rng.randint(1, 4)):
            text[rng.randrange(len(text))] = rng.choice("[]{}=.,\"'#\n\\ a1")
        try:
            source = parse_toml("".join(text), "f.toml")
            source.place(("features", "normal_map", "list"))
        except LucarnaError:
            continue
