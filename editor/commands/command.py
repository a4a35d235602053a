"""Command: one edit of one column of one table, as plain values, so that it can be undone, merged and logged."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Protocol

#: the table whose edits are undone as all are, but make no document differ from its file
VIEW_TABLE = "settings"


#: for each row (column, value) pairs
Said = tuple[tuple[tuple[str, Any], ...], ...]


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

    `said`: (before, after): what the user had said of each row before, as (column, value) in the order it was said,
    which is not what was there when nobody had said anything or a clip had moved it since. So undo leaves nothing
    behind that saving would write down. () is: as the command says."""

    table: str
    column: str
    rows: tuple[int, ...]
    before: tuple[Any, ...]
    after: tuple[Any, ...]
    label: str = ""
    said: tuple[Said, Said] = ((), ())

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
        return replace(self, before=self.after, after=self.before, said=self.said[::-1])

    def followed_by(self, later: Command) -> Command:
        """This command and then `later` on the same target, as one."""
        assert self.target == later.target
        return replace(self, after=later.after)

    def describe(self) -> str:
        return self.label or f"Change {self.column.replace('_', ' ')}"
