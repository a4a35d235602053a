"""A random walk over the operations of the editor, and what must hold at each step of it.

    - what an operation changes in the document it changes through the history: without an entry nothing differs
    - undo and redo bring back every state that was there before, whatever lies between
    - an operation is done or refused in words (a LucarnaError): anything else is a failure
    - a script of the history makes the same document from the same file

`Model` knows the content of the document after each entry of its history. It is written to a trace line by line, so
that whoever comes after a kill can compare."""

from __future__ import annotations

import json
import random
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from editor import prefabs
from editor.builtin_operations import builtin_operations
from editor.document import Document
from editor.operations import Operations
from editor.session import Session
from engine.core.errors import LucarnaError
from tests.fuzz import operation_stage as stage

#: operations that the walk leaves out, and why
LEFT_OUT = {
    "file.quit": "ends the window",
    "file.open-sample": "opens another document",
    "file.save-turntable": "writes pictures and no document",
    "help.export-keymap": "writes a file and no document",
    "shader.effect": "opens files of the installation in the text editor",
}

PREFABS = ("prefab.make", "prefab.apply", "prefab.revert", "prefab.place")


class Broken(AssertionError):
    """Something that must hold does not."""


@dataclass(slots=True)
class Model:
    """`states[i]`: the content after the first i entries of the history, then of those undone; `at`: where it is."""

    states: list[str] = field(default_factory=list)
    at: int = 0

    def follow(self, event: dict[str, Any]) -> None:
        """Take over what a trace line says. Raises Broken where a state is not the one it was."""
        done, undone, now = event["done"], event["undone"], event["state"]
        if event["e"] == "open":
            # a history that is there already was restored in part: what its states were, the first visit tells
            self.states, self.at = [""] * done + [now] + [""] * undone, done
            return
        if event["e"] == "do":
            if event["dropped"]:
                del self.states[0]
            self.states = [*self.states[:done], now]
        elif event["e"] in ("undo", "redo", "end", "saved"):
            del self.states[done + undone + 1 :]
            self.states[done] = self.states[done] or now
            if self.states[done] != now:
                raise Broken(
                    f"after {event['e']} to entry {done} the document is not what it was there: "
                    f"{now}, and was {self.states[done]}"
                )
        self.at = done


class Walk:
    """One document at a time, and random operations on it. `trace` gets a line for each event of the history."""

    def __init__(self, session: Session, trace: IO[str], *, exact: bool) -> None:
        self.session, self.exact, self.trace = session, exact, trace
        self.operations: Operations = builtin_operations()
        self.model = Model()
        self.document: Document | None = None
        self.counts: Counter[str] = Counter()
        #: called with the number of the event that was just traced
        self.after_event: Callable[[str], None] = lambda event: None
        self._first: Any = None

    def content(self) -> str:
        assert self.document is not None
        return stage.content(self.document, exact=self.exact)

    def watch(self, document: Document, *, model: Model | None = None) -> None:
        """Follow this document from now on; with a `model` it must be what that says."""
        self.document = document
        history = document.history
        journal = history.listener

        def listen(what: str, edit: Any, gesture: Any) -> None:
            if journal is not None:
                journal(what, edit, gesture)
            self._tell(what)

        history.listener = listen
        if self.session.journal is not None:  # so that leaving it finds its listener
            self.session.journal.record = listen  # type: ignore[method-assign]  # what is compared there
        if model is None:
            self._first = None
            self._tell("open")
            return
        self.model = model
        if self.content() != model.states[model.at]:
            raise Broken("the restored document is not what it was when its process was killed")
        self._first = history.entries[0] if history.entries else None

    def _tell(self, what: str) -> None:
        assert self.document is not None
        history = self.document.history
        entries = history.entries
        dropped = len(entries) >= 1000 and entries[0] is not self._first
        self._first = entries[0] if entries else None
        event = {
            "e": what, "done": len(entries), "undone": len(history.undone), "dropped": dropped,
            "state": self.content(),
        }  # fmt: skip
        self.trace.write(json.dumps(event) + "\n")
        self.trace.flush()
        self.after_event(what)
        self.model.follow(event)

    # --- steps ---

    def step(self, dice: random.Random, folder: Path) -> str:
        """One random thing; returns what. Raises Broken."""
        session = self.session
        before = self.content()
        at, revision = self.model.at, self.document.history.revision if self.document else 0
        kind = dice.choices(("undo", "drag", "set", "select", "operation", "prefab"), (18, 8, 18, 14, 42, 4))[0]
        document, what = self.document, kind
        assert document is not None
        try:
            if kind == "undo":
                what = dice.choice(("edit.undo", "edit.redo", "jump"))
                if what == "jump":
                    document.history.go_to(
                        dice.randint(0, len(document.history.entries) + len(document.history.undone))
                    )
                else:
                    for _ in range(dice.randint(1, 6)):
                        self.operations.run(what, session)
            elif kind == "drag":
                self._drag(dice)
            elif kind == "set":
                what = self._run("edit.set", dice, folder)
            elif kind == "prefab":
                what = self._prefab(dice, folder)
            elif kind == "select":
                what = self._run("select.nodes", dice, folder)
            else:
                what = self._run(dice.choice([o.id for o in self.operations if o.id not in LEFT_OUT]), dice, folder)
        except LucarnaError:
            what += " (refused)"
        self.counts[what] += 1
        self._settle(dice)
        if session.document is not self.document:
            return what
        after = self.content()
        if after != self.model.states[self.model.at]:
            raise Broken(
                f"{what}: the document changed, and its history does not know: {after}, and was "
                f"{self.model.states[self.model.at]}"
            )
        if document.history.revision == revision and (after != before or self.model.at != at):
            raise Broken(f"{what}: no edit was made, and the document is another")
        return what

    def _run(self, id: str, dice: random.Random, folder: Path) -> str:
        operation = self.operations[id]
        if not operation.enabled(self.session):
            return f"{id} (not now)"
        if operation.sample is not None:
            given = operation.sample(self.session, dice)
        else:
            given = {
                a.name: a.sample(self.session, dice) for a in operation.arguments if a.required or dice.random() < 0.5
            }
        for argument in operation.arguments:
            if argument.type == "path" and argument.name in given:
                given[argument.name] = folder / dice.choice(("other.scene.json", "sub/third.scene.json", "nowhere.glb"))
        self.operations.run(id, self.session, **given)
        return id

    def _prefab(self, dice: random.Random, folder: Path) -> str:
        """An operation on an instance that there is, more often than chance selects one."""
        document = self.document
        assert document is not None
        nodes = document.runtime.scene.nodes
        rows = [int(row) for row in range(len(nodes)) if nodes.alive[row] and prefabs.root_of(document, row) == row]
        if rows and dice.random() < 0.7:
            document.select(dice.choice(rows))
        return self._run(dice.choice(PREFABS) if rows else "prefab.make", dice, folder)

    def _drag(self, dice: random.Random) -> None:
        """A gesture of some steps on one target, as a widget makes it; now and then back to where it began."""
        assert self.document is not None
        given = self.operations["edit.set"].sample
        assert given is not None
        order = given(self.session, dice)
        table, column, rows = order["table"], order["column"], order["rows"]
        start = self.document.tables[table].read(column, rows)
        for number in range(dice.randint(2, 6)):
            value = order["value"] if number % 2 == 0 else start[0] if start else None
            if table in ("lights", "cameras", "nodes", "materials"):
                self.session.edit(table, column, rows, [value] * len(rows), gesture=("drag", table))
        self.session.end_gesture()

    def _settle(self, dice: random.Random) -> None:
        """What a window does between frames, and a user with what it asks."""
        session = self.session
        if session.job is not None:
            session.job.wait(20)
        session.poll()
        if session.work is not None:
            from editor import work

            work.cancel(session)
        requests = session.ui
        if requests.after_discard is not None:
            after, requests.after_discard = requests.after_discard, None
            given_up = dice.random() < 0.05
            if given_up and self.document is not None and session.document is self.document:
                after()
        if session.job is not None:
            session.job.wait(20)
            session.poll()
        requests.quit = False
        if requests.paste is not None:
            paste, requests.paste = requests.paste, None
            paste(dice.choice((requests.copy_text, "roughness = 0.3", "", "no = [toml")))
        for tab in [tab for tab in session.tabs if tab.document is not session.document]:
            tab.document.history.listener = None  # one document at a time: what of several is another test's
            if tab.journal is not None:
                tab.journal.finish()
            tab.document.close()
            session.tabs.remove(tab)
        session.playback.playing = False
        session.tick(0.05)
