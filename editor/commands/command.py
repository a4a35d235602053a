"""Command: one edit of one column of one table, as plain values, so that it can be undone, merged and logged."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Protocol

#: the table whose edits are undone as all are, but make no document differ from its file
VIEW_TABLE = "settings"


class Edit(Protocol):
    """What the history keeps: a Command, or another kind of change with the same surface."""

    @property
    def target(self) -> tuple[str, str, tuple[int, ...]]: ...
    @property
    def changes(self) -> bool: ...
    @property
    def of_view(self) -> bool: ...
    def inverse(self) -> Edit: ...
    def followed_by(self, later: Any) -> Edit: ...
    def describe(self) -> str: ...


@dataclass(frozen=True, slots=True)
class Command:
    """`before[i]` and `after[i]` are the values of `column` in row `rows[i]`: numbers, strings or tuples of them.

    `unsaid`: (before, after): the (column, row) whose value was nobody's, as it was in the file or as a clip had moved
    it; there undo must not leave a value behind that saving would write down."""

    table: str
    column: str
    rows: tuple[int, ...]
    before: tuple[Any, ...]
    after: tuple[Any, ...]
    label: str = ""
    unsaid: tuple[tuple[tuple[str, int], ...], tuple[tuple[str, int], ...]] = ((), ())

    def __post_init__(self) -> None:
        assert len(self.rows) == len(self.before) == len(self.after), "one value before and after for each row"

    @property
    def target(self) -> tuple[str, str, tuple[int, ...]]:
        return self.table, self.column, self.rows

    @property
    def changes(self) -> bool:
        return self.before != self.after

    @property
    def of_view(self) -> bool:
        """Whether it changes how the document is seen, not the document: there is nothing to save."""
        return self.table == VIEW_TABLE

    def inverse(self) -> Command:
        return replace(self, before=self.after, after=self.before, unsaid=self.unsaid[::-1])

    def followed_by(self, later: Command) -> Command:
        """This command and then `later` on the same target, as one."""
        assert self.target == later.target
        return replace(self, after=later.after)

    def describe(self) -> str:
        return self.label or f"Change {self.column.replace('_', ' ')}"
