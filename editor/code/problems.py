"""Problems: an error of the engine may name several places; each becomes a marker and a stop of "next error"."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from engine.core.errors import LucarnaError

#: what compile errors end with: of use in a log of many shaders, not at the line itself
_STAGE = re.compile(r" \[\w+ stage(?: of '[^']*')?\]$")
_FURTHER = re.compile(r"^(?P<file>\S.*?):(?P<line>\d+)(?::(?P<column>\d+))?: (?P<text>.*)$")

#: what the picture shows meanwhile
PREVIOUS, MAGENTA, IGNORED, BUILT_IN, NONFINITE = "previous", "magenta", "ignored", "built-in", "nonfinite"
STATES = {
    PREVIOUS: "running previous version",
    MAGENTA: "drawn in magenta",
    IGNORED: "left out",
    BUILT_IN: "running the built-in version",
    NONFINITE: "not finite",
}


@dataclass(frozen=True, slots=True)
class Problem:
    """`line`, `column` count from 1, 0 = unknown. `detail`: the source line with a caret; `hint`: what to do."""

    file: str
    line: int
    column: int
    message: str
    detail: str = ""
    hint: str = ""
    state: str = PREVIOUS

    @property
    def place(self) -> str:
        """`surface.frag:41:9`."""
        numbers = [str(n) for n in (self.line, self.column) if n]
        return ":".join([Path(self.file).name, *numbers]) if self.file else ""

    @property
    def badge(self) -> str:
        """One line for the viewport."""
        return f"{STATES[self.state]}: {self.place + '  ' if self.place else ''}{self.message}"

    @property
    def text(self) -> str:
        return "\n".join(part for part in (self.message, self.detail, self.hint) if part)

    def is_in(self, path: Path) -> bool:
        """Whether it is to be marked in the file `path`."""
        return bool(self.file) and Path(self.file).name == path.name and Path(self.file).resolve() == path.resolve()


def problems_of(error: LucarnaError, state: str = PREVIOUS) -> list[Problem]:
    """One problem for each place that the error names, in its order."""
    where = error.where
    found: list[tuple[str, int, int, list[str]]] = []
    first, *rest = error.message.split("\n")
    found.append((where.file, where.line, where.column, [first]))
    for line in rest:
        further = _FURTHER.match(line)
        column = int(further["column"] or 0) if further else 0
        last = found[-1]
        if further and (further["file"], int(further["line"]), column) == last[:3] and last[1]:
            last[3].append(further["text"])  # the driver's further words on the same spot
        elif further:
            found.append((further["file"], int(further["line"]), column, [further["text"]]))
        else:
            found[-1][3].append(line)
    if len(found) > 1 and not where.line:
        del found[0]  # only said how many there are
    problems = []
    for i, (file, row, column, texts) in enumerate(found):
        detail = list(dict.fromkeys(t for t in texts[1:] if t.strip()))
        hint = error.hint if i == 0 else ""
        problems.append(Problem(file, row, column, _STAGE.sub("", texts[0]), "\n".join(detail), hint, state))
    return problems


def all_problems(standing: Iterable[tuple[str, LucarnaError]]) -> tuple[Problem, ...]:
    """Of all (state, error), each place once."""
    found: dict[tuple[str, int, int, str], Problem] = {}
    for state, error in standing:
        for problem in problems_of(error, state):
            found.setdefault((problem.file, problem.line, problem.column, problem.message), problem)
    return tuple(found.values())
