"""The names that scripts and the Python console have: the session's operations and tables. No imgui.

open_file(path)  save(path=None)  close()     documents; open_file waits until it is there
run(id, **arguments)                          any operation: see operations() and docs/operations.md
select(*nodes)  selection()  node(name)       nodes by name or row
edit(table, column, rows, values)             one undoable edit; rows may be names of nodes
undo()  redo()  document()  scene()  is_open()  operations()  session  animation  np
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from editor.arguments import node_row
from editor.operations import Operations
from editor.session import Session
from engine.core.errors import InputError, UsageError


def script_names(session: Session, operations: Operations, finish: Callable[[], None] | None = None) -> dict[str, Any]:
    """Name -> what it is. `finish` waits for what an operation began and raises what went wrong with it; without it
    a window goes on with that between its frames."""

    def document() -> Any:
        if session.document is None:
            raise InputError("no document is open", hint="open_file(path) opens one")
        return session.document

    def is_open() -> bool:
        return session.document is not None

    def scene() -> Any:
        return document().runtime.scene

    def selection() -> tuple[int, ...]:
        return tuple(document().selection)

    def select(*nodes: str | int) -> None:
        run("select.nodes", nodes=list(nodes))

    def node(name: str) -> int:
        document()
        try:
            return node_row(session, name)
        except UsageError as error:
            raise InputError(error.message.partition(": ")[2], hint=error.hint) from None

    def run(operation: str, **arguments: Any) -> bool:
        done = operations.run(operation, session, **arguments)
        if finish is not None:
            if not done:
                raise UsageError(f"{operation!r} cannot be done now", hint=_why(session, operation))
            finish()
        return done

    def list_operations() -> list[str]:
        return [o.id for o in operations]

    def edit(table: str, column: str, rows: Sequence[int | str], values: Sequence[Any]) -> None:
        chosen = [node_row(session, row) if isinstance(row, str) else row for row in rows]
        document().edit(table, column, chosen, values)

    def open_file(path: str | Path) -> None:
        run("file.open-path", path=path)

    def save(path: str | Path | None = None) -> None:
        if path is None:
            run("file.save")
        else:
            run("file.save-to", path=path)

    def close() -> None:
        run("file.close")

    def undo() -> bool:
        return run("edit.undo")

    def redo() -> bool:
        return run("edit.redo")

    from editor.animating.editing import AnimationEditor

    made = (document, is_open, scene, selection, select, node, run, edit, open_file, save, close, undo, redo)
    return {
        "session": session,
        "np": np,
        "animation": AnimationEditor(session),
        "operations": list_operations,
        **{f.__name__: f for f in made},
    }


def _why(session: Session, operation: str) -> str:
    if session.document is None:
        return "no document is open: open_file(path) opens one"
    if not session.document.selection and operation.split(".")[0] in ("edit", "material"):
        return "nothing is selected: select(name) selects a node"
    return "see what it needs in docs/operations.md"
