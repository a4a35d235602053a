"""Argument: what an operation takes, declared once: checked in scripts and the console, asked for in the palette,
listed in the docs, and made up by the fuzzer. No imgui."""

from __future__ import annotations

import difflib
import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.core.errors import UsageError
from engine.core.param import COMPONENTS, Param

if TYPE_CHECKING:
    from editor.session import Session

#: what an argument may be besides the types of engine.core.param
OWN_TYPES = ("text", "path", "node", "nodes", "value")
#: stands for "has no default: must be given"
REQUIRED: Any = object()


@dataclass(frozen=True, slots=True)
class Argument:
    """`type`: one of engine.core.param's, or text, path, node (a name or a row), nodes, value (whatever fits what it is
    set to). `choices`: of an enum, or a function of the session that tells them."""

    name: str
    type: str
    default: Any = REQUIRED
    min: float = -math.inf
    max: float = math.inf
    choices: tuple[str, ...] | Callable[[Session], Sequence[str]] = ()
    unit: str = ""
    doc: str = ""

    def __post_init__(self) -> None:
        assert self.type in COMPONENTS or self.type in OWN_TYPES, f"no such type of argument: {self.type}"

    @property
    def required(self) -> bool:
        return self.default is REQUIRED

    def known(self, session: Session) -> tuple[str, ...]:
        """The choices there are now."""
        return tuple(self.choices(session)) if callable(self.choices) else self.choices

    def check(self, value: Any, session: Session) -> Any:
        """`value` as the operation gets it. Raises UsageError that names the argument."""
        if self.type == "node":
            return node_row(session, value, self.name)
        if self.type == "nodes":
            given = value if isinstance(value, (list, tuple)) else [value]
            return tuple(node_row(session, one, self.name) for one in given)
        if self.type == "path":
            if not isinstance(value, (str, Path)) or not str(value):
                raise UsageError(f"{self.name}: {value!r} is not a path")
            return Path(value)
        if self.type == "text":
            if not isinstance(value, str):
                raise UsageError(f"{self.name}: {value!r} is not text")
            return value
        if self.type == "value":
            return value
        return Param(self.name, self.type, None, self.min, self.max, choices=self.known(session)).check(value)

    def sample(self, session: Session, dice: random.Random) -> Any:
        """Some value that it may have now; of a node or an enum without any, one that will be refused."""
        if self.type in ("node", "nodes"):
            rows = living_nodes(session)
            picked = [dice.choice(rows) for _ in range(dice.randint(1, 3))] if rows else [0]
            return picked[0] if self.type == "node" else picked
        if self.type == "enum":
            known = self.known(session)
            return dice.choice(known) if known else "nothing"
        if self.type == "bool":
            return dice.random() < 0.5
        if self.type in ("text", "value"):
            return dice.choice(("", "a", "thing 2", "größe 木", 'quo"te\\', "x" * 80))
        if self.type == "path":
            return "nowhere"
        count = COMPONENTS[self.type]
        low, high = max(self.min, -10.0), min(self.max, 10.0)
        numbers = [dice.choice((0.0, 1.0, low, high, dice.uniform(low, high))) for _ in range(count)]
        numbers = [min(max(n, low), high) for n in numbers]
        if self.type in ("int", "uint"):
            return int(numbers[0])
        return tuple(numbers) if count > 1 else numbers[0]

    def usage(self) -> str:
        """`name: type = default`, for the docs and for messages."""
        choices = f" ({' | '.join(self.choices)})" if isinstance(self.choices, tuple) and self.choices else ""
        return f"{self.name}: {self.type}{choices}" + ("" if self.required else f" = {self.default!r}")


def checked(arguments: Sequence[Argument], given: dict[str, Any], session: Session, what: str) -> dict[str, Any]:
    """Every argument's value: as given, else its default. Raises UsageError for unknown, missing and bad ones."""
    names = [a.name for a in arguments]
    for name in given:
        if name not in names:
            near = difflib.get_close_matches(name, names, 1)
            known = f"it takes {', '.join(names)}" if names else "it takes none"
            raise UsageError(
                f"{what}: there is no argument {name!r}", hint=f"did you mean {near[0]!r}?" if near else known
            )
    values = {}
    for argument in arguments:
        if argument.name not in given and argument.required:
            raise UsageError(f"{what}: {argument.name!r} is missing", hint=argument.doc or f"give {argument.usage()}")
        if argument.name in given:
            values[argument.name] = argument.check(given[argument.name], session)
        else:
            values[argument.name] = argument.default
    return values


def living_nodes(session: Session) -> list[int]:
    if session.document is None:
        return []
    return [int(r) for r in np.flatnonzero(session.document.runtime.scene.nodes.alive)]


def node_row(session: Session, value: Any, name: str = "node") -> int:
    """The row of a node given by name or row; -1 stands for none. Raises UsageError where there is no such node."""
    if session.document is None:
        raise UsageError(f"{name}: no document is open")
    nodes = session.document.runtime.scene.nodes
    if isinstance(value, str):
        rows = [r for r in living_nodes(session) if nodes.name[r] == value]
        if rows:
            return rows[0]
        near = difflib.get_close_matches(value, [nodes.name[r] for r in living_nodes(session)], 1)
        raise UsageError(
            f"{name}: there is no node {value!r}", hint=f"did you mean {near[0]!r}?" if near else "see the scene tree"
        )
    if isinstance(value, (bool, float)) or not hasattr(value, "__index__"):
        raise UsageError(f"{name}: {value!r} is neither the name of a node nor its row")
    row = int(value)
    if row != -1 and not (0 <= row < len(nodes.name) and nodes.alive[row]):
        raise UsageError(f"{name}: there is no node in row {row}")
    return row
