"""Operations: everything a user can do by name. Menu, palette, keys, console, scripts and tests are doors to the same
functions, and what was done is written down as the line of a script that does it again.

A shortcut is written `Ctrl+Shift+P`; single letters work while no text field has the focus. No imgui here.
"""

from __future__ import annotations

import difflib
import random
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from editor import scripting
from editor.arguments import Argument, checked
from editor.session import Session
from editor.strings import tr
from engine.core.errors import DeviceError, LucarnaError, UsageError

#: how many lines of what was done are kept
LOG_LIMIT = 2000


def always(session: Session) -> bool:
    return True


@dataclass(frozen=True, slots=True)
class Operation:
    """`id` is stable (`view.frame-all`). `menu`: one of menus.MENUS, or '' for the palette only.
    `checked` makes it a toggle. `run` gets the session and its `arguments` by name; one with a required argument is
    for scripts, the console and the palette, which asks. `sample` makes arguments up for tests where those of their
    declarations would mostly be refused."""

    id: str
    label: str
    run: Callable[..., None]
    menu: str = ""
    shortcuts: tuple[str, ...] = ()
    enabled: Callable[[Session], bool] = always
    checked: Callable[[Session], bool] | None = None
    separator: bool = False
    doc: str = ""
    arguments: tuple[Argument, ...] = ()
    sample: Callable[[Session, random.Random], dict[str, Any]] | None = None

    @property
    def asks(self) -> bool:
        """Whether it cannot run without being told something."""
        return any(a.required for a in self.arguments)


class Operations:
    """The registry. Ids and shortcuts are unique: a clash is a programming mistake and asserts."""

    def __init__(self) -> None:
        self._by_id: dict[str, Operation] = {}
        self._by_shortcut: dict[str, str] = {}
        #: operation -> keys in the place of its own (see editor.keymap)
        self._rebound: dict[str, tuple[str, ...]] = {}
        self._in_use: dict[str, str] | None = None
        #: lines of a script for what was run, the newest last
        self.log: deque[str] = deque(maxlen=LOG_LIMIT)
        #: grows with every line
        self.logged = 0
        #: told each line before it is run
        self.listener: Callable[[str], None] | None = None

    def add(self, operation: Operation) -> None:
        assert operation.id not in self._by_id, f"operation {operation.id} is registered twice"
        for shortcut in operation.shortcuts:
            assert shortcut not in self._by_shortcut, f"{shortcut} is taken by {self._by_shortcut[shortcut]}"
            self._by_shortcut[shortcut] = operation.id
        self._by_id[operation.id] = operation
        self._in_use = None

    def __iter__(self) -> Iterator[Operation]:
        return iter(self._by_id.values())

    def __getitem__(self, id: str) -> Operation:
        return self._by_id[id]

    def __contains__(self, id: str) -> bool:
        return id in self._by_id

    def remove(self, id: str) -> None:
        """Take an operation away (a plug-in's)."""
        operation = self._by_id.pop(id)
        for shortcut in operation.shortcuts:
            self._by_shortcut.pop(shortcut, None)
        self._in_use = None

    def run(self, id: str, session: Session, **given: Any) -> bool:
        """Run an operation by id; False when it is not enabled now. Raises UsageError for an unknown id and for
        arguments that it does not take."""
        operation = self._by_id.get(id)
        if operation is None:
            near = difflib.get_close_matches(id, self._by_id, 1)
            hint = f"did you mean {near[0]!r}?" if near else "see the command palette for their names"
            raise UsageError(f"there is no operation {id!r}", hint=hint)
        if not operation.enabled(session):
            return False
        values = checked(operation.arguments, given, session, id)
        line = scripting.call(session, id, given)
        self.log.append(line)
        self.logged += 1
        if self.listener is not None:
            self.listener(line)
        with scripting.doing(session, line):
            operation.run(session, **values)
        return True

    def attempt(self, id: str, session: Session, **given: Any) -> bool:
        """As `run`, with what is refused in the error bar: for keys and menus, above which nobody answers for it."""
        try:
            return self.run(id, session, **given)
        except DeviceError:  # nothing can be shown any more
            raise
        except LucarnaError as error:
            session.fail(error)
            return False

    def shortcuts(self) -> dict[str, str]:
        """Shortcut -> operation id, as in use; what was bound anew goes before what an operation has by itself."""
        if self._in_use is None:
            own = {k: o.id for o in self for k in o.shortcuts if o.id not in self._rebound}
            self._in_use = own | {k: id for id, keys in self._rebound.items() for k in keys if id in self._by_id}
        return dict(self._in_use)

    def keys_of(self, operation: Operation) -> tuple[str, ...]:
        """The keys that run it now."""
        taken = self.shortcuts()
        keys = self._rebound.get(operation.id, operation.shortcuts)
        return tuple(key for key in keys if taken.get(key) == operation.id)

    def rebind(self, keys: Mapping[str, tuple[str, ...]]) -> None:
        """Operation -> its keys, for those that have others than their own."""
        self._rebound = dict(keys)
        self._in_use = None

    def menu(self, name: str) -> list[Operation]:
        return [o for o in self if o.menu == name]

    def search(self, text: str, session: Session) -> list[Operation]:
        """Enabled operations whose menu and label, in English or as shown, or whose id hold the letters of `text` in
        order, best match first."""
        scored = []
        for operation in self:
            labels = {
                f"{operation.menu} {operation.label}",
                f"{tr(operation.menu)} {tr(operation.label)}",
                operation.id,
            }
            scores = [match_score(text, label.strip()) for label in labels]
            score = min((s for s in scores if s is not None), default=None)
            if score is not None and operation.enabled(session):
                scored.append((score, operation.label, operation))
        return [operation for _score, _label, operation in sorted(scored, key=lambda s: s[:2])]


def match_score(pattern: str, text: str) -> float | None:
    """How well `pattern`'s letters occur in order in `text`, ignoring case: lower is better, None is no match.

    Whole words and starts of words win over letters scattered about."""
    pattern, lowered = pattern.lower().strip(), text.lower()
    if not pattern:
        return 0.0
    at = lowered.find(pattern)
    if at >= 0:
        return (0.0 if at == 0 or not lowered[at - 1].isalnum() else 1.0) + 0.001 * len(text)
    score, position = 2.0, -1
    for letter in pattern:
        if letter == " ":
            continue
        found = lowered.find(letter, position + 1)
        if found < 0:
            return None
        starts_word = found == 0 or not lowered[found - 1].isalnum()
        score += 0.0 if starts_word else 0.1 * (found - position)
        position = found
    return score + 0.001 * len(text)
