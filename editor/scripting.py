"""What was done as lines of a script: edits and operations that `lucarna run` and the console do again. No imgui.

    edit("nodes", "translation", ["lid"], [(1.0, 2.0, 3.0)])      one column of some rows
    select("lid"); run("edit.duplicate")                          an operation on the selection

Nodes are named where their name is theirs alone when the line is written, else numbered by row: a script begins with
the file it was made on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from editor.commands.command import VIEW_TABLE, Command, Edit

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session


@contextmanager
def doing(session: Session, line: str) -> Iterator[None]:
    """While an operation runs: structural edits are said to be made by `line`. The outermost counts."""
    document = session.document
    if document is None or document.doing:
        yield
        return
    document.doing = line
    try:
        yield
    finally:
        document.doing = ""


def call(session: Session, id: str, given: Mapping[str, Any]) -> str:
    """The line that runs an operation as it is run now, with the selection it finds."""
    words = [repr(id), *(f"{name}={literal(value)}" for name, value in given.items())]
    line = f"run({', '.join(words)})"
    document = session.document
    if document is not None and document.selection and id.split(".")[0] in SELECTED and id not in ALONE:
        line = f"select({', '.join(nodes(document, document.selection))}); {line}"
    return line


#: the first part of the ids of operations that look at the selection
SELECTED = ("edit", "add", "material", "shader", "prefab", "light", "animation")
ALONE = ("edit.undo", "edit.redo", "edit.history", "edit.select-all", "edit.show-all", "edit.unlock-all")


def nodes(document: Document, rows: Sequence[int]) -> list[str]:
    """Rows as literals: names that only one living node has, else numbers."""
    table = document.runtime.scene.nodes
    if len(rows) > 50:
        return [repr(int(r)) for r in rows]
    counts = Counter(name for name, alive in zip(table.name, table.alive, strict=False) if alive)
    return [repr(table.name[r]) if table.name[r] and counts[table.name[r]] == 1 else repr(int(r)) for r in rows]


def literal(value: Any) -> str:
    """A value as Python text that gives an equal one."""
    if isinstance(value, Path):
        return repr(value.as_posix())
    if isinstance(value, (list, tuple)):
        inside = ", ".join(literal(v) for v in value)
        if isinstance(value, list):
            return f"[{inside}]"
        return f"({inside},)" if len(value) == 1 else f"({inside})"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{literal(k)}: {literal(v)}" for k, v in value.items()) + "}"
    return repr(value)


def edit_line(entry: Edit) -> str:
    """The line that makes an edit again, or a comment that says which one a script cannot make."""
    if not isinstance(entry, Command):
        return getattr(entry, "line", "") or f"# {entry.describe()}: made by hand, and no operation"
    return f"edit({entry.table!r}, {entry.column!r}, {literal(list(entry.rows))}, {literal(list(entry.after))})"


def history_script(document: Document, entries: Sequence[Edit] | None = None) -> str:
    """The document's undo history as a script: `lucarna run THIS.py FILE` makes the same edits to the same file.

    Begins with the file it was made on; what was undone is not in it."""
    chosen = document.history.entries if entries is None else entries
    head = [
        f'"""{len(chosen)} edit{"s" if len(chosen) != 1 else ""} of {document.name}, as they were made."""',
        "",
        "if not is_open():",
        f"    open_file({document.source.as_posix()!r})",
        "",
    ]
    return "\n".join([*head, *(edit_line(entry) for entry in chosen if entry.target[0] != VIEW_TABLE), ""])
