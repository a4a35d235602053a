"""Node: a view of one row for editors and scripts. A frame works on columns instead."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import InputError

if TYPE_CHECKING:
    from engine.scene.nodes import NodeTable

F8 = NDArray[np.float64]


class Node:
    """One node: (table, row, generation). Every access raises InputError once the row was removed."""

    __slots__ = ("_generation", "_row", "_table")

    def __init__(self, table: NodeTable, row: int) -> None:
        table.select(row)
        self._table = table
        self._row = int(row)
        self._generation = int(table.generation[row])

    @property
    def row(self) -> int:
        """The row's number; raises InputError if it was removed since."""
        table, row = self._table, self._row
        if not table.alive[row] or int(table.generation[row]) != self._generation:
            raise InputError(f"node row {row} was removed", hint="look the node up again")
        return row

    @property
    def is_alive(self) -> bool:
        return bool(self._table.alive[self._row]) and int(self._table.generation[self._row]) == self._generation

    @property
    def name(self) -> str:
        return self._table.name[self.row]

    @name.setter
    def name(self, value: str) -> None:
        self._table.name[self.row] = value

    @property
    def translation(self) -> F8:
        """f8[3], metres, a copy."""
        value: F8 = self._table.translation[self.row].copy()
        return value

    @translation.setter
    def translation(self, value: ArrayLike) -> None:
        self._table.set_translation(self.row, value)

    @property
    def rotation(self) -> F8:
        """f8[4], unit, xyzw, a copy."""
        value: F8 = self._table.rotation[self.row].copy()
        return value

    @rotation.setter
    def rotation(self, value: ArrayLike) -> None:
        self._table.set_rotation(self.row, value)

    @property
    def scale(self) -> F8:
        """f8[3], a copy."""
        value: F8 = self._table.scale[self.row].copy()
        return value

    @scale.setter
    def scale(self, value: ArrayLike) -> None:
        self._table.set_scale(self.row, value)

    @property
    def visible(self) -> bool:
        return bool(self._table.visible[self.row])

    @visible.setter
    def visible(self, value: bool) -> None:
        self._table.set_visible(self.row, value)

    @property
    def world(self) -> F8:
        """world_from_local f8[4,4], as of the last update."""
        return self._table.world_matrix(self.row)

    @property
    def parent(self) -> Node | None:
        above = int(self._table.parent[self.row])
        return Node(self._table, above) if above >= 0 else None

    @parent.setter
    def parent(self, value: Node | None) -> None:
        self._table.reparent(self.row, -1 if value is None else value.row)

    @property
    def children(self) -> list[Node]:
        return [Node(self._table, int(row)) for row in self._table.children(self.row)]

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Node)
            and self._table is other._table
            and (self._row, self._generation) == (other._row, other._generation)
        )

    def __hash__(self) -> int:
        return hash((id(self._table), self._row, self._generation))

    def __repr__(self) -> str:
        return f"Node({self._row}, {self.name!r})" if self.is_alive else f"Node({self._row}, removed)"
