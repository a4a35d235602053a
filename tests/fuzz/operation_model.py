"""What the walk over operations knows of the documents that are open: of each its content after every entry of its
history. It goes to a trace line by line, so that whoever comes after a kill can compare."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from editor.document import Document
from tests.fuzz import operation_stage as stage


class Broken(AssertionError):
    """Something that must hold does not."""


@dataclass(slots=True)
class Model:
    """`states[i]`: the content after the first i entries of the history, then of those undone; `at`: where it is."""

    states: list[str] = field(default_factory=list)
    at: int = 0

    @property
    def now(self) -> str:
        return self.states[self.at]

    def follow(self, event: dict[str, Any]) -> None:
        """Take over what a trace line says. Raises Broken where a state is not the one it was."""
        done, undone, now = event["done"], event["undone"], event["state"]
        if event["e"] == "open":
            # a history that is there already was restored in part: what its states were, the first visit tells
            self.states, self.at = [""] * done + [now] + [""] * undone, done
            return
        del self.states[: event.get("dropped", 0)]
        if event["e"] == "do":
            self.states = [*self.states[:done], now]
        elif event["e"] in ("undo", "redo", "end", "saved"):
            del self.states[done + undone + 1 :]
            self.states[done] = self.states[done] or now
            if self.states[done] != now:
                raise Broken(
                    f"after {event['e']} to entry {done} ({event.get('label', '')}) the document is not what it was "
                    f"there: {now}, and was {self.states[done]}"
                )
        self.at = done

    def forget(self, now: str) -> None:
        """Files that the document shares with another one changed: what it is now counts, the rest is not known."""
        self.states = ["" if i != self.at else now for i in range(len(self.states))]


@dataclass(slots=True, eq=False)
class Watched:
    """An open document. `home`: the folder that its files are in; `shared`: another one wrote files there since."""

    key: str
    document: Document
    home: Path
    model: Model = field(default_factory=Model)
    entries: tuple[Any, ...] = ()
    shared: bool = False

    def content(self) -> str:
        return stage.content(self.document, exact=not getattr(self.document.runtime, "clips", ()))

    def event(self, what: str) -> dict[str, Any]:
        """What the trace says of something that the history did."""
        history = self.document.history
        entries = history.entries
        forgotten = [i for i, entry in enumerate(self.entries) if entries and entry is entries[0]]
        dropped, self.entries = forgotten[0] if forgotten else 0, entries
        label = {"undo": history.redo_label, "redo": history.undo_label, "do": history.undo_label}.get(what, "")
        return {
            "e": what, "key": self.key, "done": len(entries), "undone": len(history.undone), "dropped": dropped,
            "label": label, "state": self.content(),
        }  # fmt: skip


def models_of(trace: Path) -> dict[str, Model]:
    """By document, what a trace says of those that were open when it ended."""
    models: dict[str, Model] = {}
    for line in trace.read_text(encoding="utf-8").splitlines():
        event = json.loads(line)
        if event["e"] == "close":
            models.pop(event["key"], None)
        else:
            models.setdefault(event["key"], Model()).follow(event)
    return models


def stamp_of(folder: Path) -> Any:
    """Changes with every file in it."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return [(str(path), (found := path.stat()).st_mtime_ns, found.st_size) for path in files]
