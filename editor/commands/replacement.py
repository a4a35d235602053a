"""Replacement: the whole scene under a document changed, by a new import, another prefab, or files that moved.

The runtimes of both sides stay open for as long as the entry can be undone or done again, so undo restores every row
and every edit before it as it was. History keeps no more than LIMIT of them: the oldest entries are forgotten.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from editor.document import Document

#: replacements that can be undone
LIMIT = 3

#: of a document, what belongs to the scene under it
FIELDS = (
    "source", "scene_path", "base_path", "findings", "runtime", "tables", "selection", "overrides", "locked",
    "isolated", "saved_to", "name", "imported_from", "news", "prefabs", "bookmarks",
)  # fmt: skip

_numbers = itertools.count(1)


@dataclass(frozen=True, slots=True)
class Standing:
    """A document's FIELDS at a moment."""

    values: dict[str, Any]

    @property
    def runtime(self) -> Any:
        return self.values["runtime"]


def standing(document: Document) -> Standing:
    """As `document` stands now."""
    return Standing({name: getattr(document, name) for name in FIELDS})


@dataclass(slots=True, eq=False)
class Replacement:
    """`steps`: what has to happen beside, as (to get to after, to get to before): files that move, a sidecar's text.
    What they raise leaves everything as it was. `of_view`: there is nothing to save."""

    before: Standing
    after: Standing
    label: str
    of_view: bool = False
    steps: tuple[Callable[[], None], Callable[[], None]] = (lambda: None, lambda: None)
    line: str = ""
    number: int = field(default_factory=lambda: next(_numbers))

    @property
    def target(self) -> tuple[str, str, tuple[int, ...]]:
        return "replacement", str(self.number), ()

    @property
    def changes(self) -> bool:
        return True

    def inverse(self) -> Replacement:
        return Replacement(self.after, self.before, self.label, self.of_view, self.steps[::-1], self.line, self.number)

    def followed_by(self, later: Any) -> Replacement:
        raise AssertionError("replacements are entries of their own")

    def describe(self) -> str:
        return self.label

    def apply(self, document: Document) -> None:
        """Bring the document to the state after this entry; before it, remember how it stands. Who only visits that
        state leaves the files where they are."""
        if not document.history.visited:
            self.steps[0]()
        self.before.values.update(standing(document).values)
        for name, value in self.after.values.items():
            setattr(document, name, value)
        document.forget_bounds()
        if document.on_replaced is not None:
            document.on_replaced()

    @property
    def runtimes(self) -> tuple[Any, Any]:
        return self.before.runtime, self.after.runtime


@dataclass(slots=True, eq=False)
class FileStep:
    """A change of files that the open scene does not show: `steps` as a Replacement has them."""

    label: str
    steps: tuple[Callable[[], None], Callable[[], None]]
    line: str = ""
    number: int = field(default_factory=lambda: next(_numbers))

    @property
    def target(self) -> tuple[str, str, tuple[int, ...]]:
        return "files", str(self.number), ()

    @property
    def changes(self) -> bool:
        return True

    @property
    def of_view(self) -> bool:
        return True

    def inverse(self) -> FileStep:
        return FileStep(self.label, self.steps[::-1], self.line, self.number)

    def followed_by(self, later: Any) -> FileStep:
        raise AssertionError("changes of files are entries of their own")

    def describe(self) -> str:
        return self.label

    def apply(self, document: Document) -> None:
        if not document.history.visited:
            self.steps[0]()


def settled(text: str, path: Path) -> Callable[[], None]:
    """A step that gives a file that text; '' removes it."""

    def run() -> None:
        from engine.core.atomic import write_text

        if text:
            write_text(path, text)
        else:
            path.unlink(missing_ok=True)

    return run
