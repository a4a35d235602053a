"""The catalogue itself: every row has a test that exists, or says what it waits for."""

from __future__ import annotations

import ast

from tests.stability.rows import ROOT, ROWS, scan


def test_every_row_is_guarded_or_says_why_not() -> None:
    bare = [row.key for row in scan() if not (row.tests or row.elsewhere or row.waits)]
    assert not bare, f"no test covers {bare}"


def test_no_row_waits_for_what_is_there() -> None:
    both = [row.key for row in scan() if row.waits and (row.tests or row.elsewhere)]
    assert not both, f"covered, but said to wait: {both}"


def test_keys_are_unique() -> None:
    keys = [row.key for row in ROWS]
    assert len(set(keys)) == len(keys)


def test_guards_in_other_packages_exist() -> None:
    for row in ROWS:
        for name in row.elsewhere:
            file, function = name.split("::")
            tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
            assert any(isinstance(n, ast.FunctionDef) and n.name == function for n in ast.walk(tree)), name
