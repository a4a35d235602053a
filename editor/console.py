"""The Python console's interpreter: the session's operations and tables by name. No imgui.

The names there are those of scripts (see script_names); what they do can be undone like any other edit.
"""

from __future__ import annotations

import code
import contextlib
import io
from dataclasses import dataclass
from typing import Any

from editor.operations import Operations
from editor.script_names import script_names
from editor.session import Session

LIMIT = 2000
#: so many words are written down of those that a start may become
OFFERED = 40


@dataclass(frozen=True, slots=True)
class Line:
    """`kind`: in (what was typed), out, error, did (what was done in the window)."""

    kind: str
    text: str


class Console:
    """`lines`: what stands in it. An unfinished block (`for …:`) is kept in `pending` until an empty line ends it."""

    def __init__(self, session: Session, operations: Operations) -> None:
        self.session = session
        self.operations = operations
        self.lines: list[Line] = []
        self.entered: list[str] = []
        self.pending: list[str] = []
        self._logged = operations.logged
        self._interpreter = code.InteractiveInterpreter(self._names())

    def push(self, text: str) -> None:
        """Take one line and run it, or the block that it ends. Never raises: what goes wrong is written down."""
        self.follow()
        self._say("in", text)
        if text.strip():
            self.entered.append(text)
        self.pending.append(text)
        source = "\n".join(self.pending)
        if not source.strip():
            self.pending.clear()
            return
        out, problems = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(problems):
            try:
                unfinished = self._interpreter.runsource(source, "<console>")
            except SystemExit:
                unfinished = False
                print("close the window to leave", file=problems)
        if not unfinished:
            self.pending.clear()
            self.session.end_gesture()
        self._logged = self.operations.logged  # what is typed here stands here already
        for kind, written in (("out", out.getvalue()), ("error", problems.getvalue())):
            for line in written.splitlines():
                self._say(kind, line)

    def follow(self) -> None:
        """Write down what was done in the window since, as lines that do it again."""
        new = self.operations.logged - self._logged
        for line in list(self.operations.log)[len(self.operations.log) - min(new, len(self.operations.log)) :]:
            self._say("did", line)
        self._logged = self.operations.logged

    def complete(self, word: str) -> list[str]:
        """Names and attributes that begin with `word`, such as `scene().no`, and after a quote operations and nodes;
        nothing is called to find them."""
        if word[:1] in ("'", '"'):
            known = {operation.id for operation in self.operations} | set(self._nodes())
            return [word[0] + name for name in sorted(known) if name.startswith(word[1:])]
        stem, dot, start = word.rpartition(".")
        names: dict[str, Any] = self._interpreter.locals
        if not dot:
            return sorted(n for n in names if n.startswith(start) and not n.startswith("__"))
        if not stem.isidentifier() or stem not in names:
            return []
        return sorted(f"{stem}.{n}" for n in dir(names[stem]) if n.startswith(start) and not n.startswith("_"))

    def offer(self, found: list[str]) -> None:
        """Write down what a word may become."""
        more = f" and {len(found) - OFFERED} more" if len(found) > OFFERED else ""
        self._say("did", "   ".join(found[:OFFERED]) + more)

    def _nodes(self) -> list[str]:
        document = self.session.document
        return [name for name in document.runtime.scene.nodes.name if name] if document is not None else []

    def clear(self) -> None:
        self.lines.clear()
        self.pending.clear()

    def _say(self, kind: str, text: str) -> None:
        self.lines.append(Line(kind, text))
        del self.lines[:-LIMIT]

    def _names(self) -> dict[str, Any]:
        return {"__name__": "console", **script_names(self.session, self.operations)}
