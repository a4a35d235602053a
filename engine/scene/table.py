"""Table: growing numpy columns with stable row numbers, a free list and generations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from engine.core.errors import InputError

Rows = ArrayLike | slice
#: Rows worked on at a time by long chains of numpy operations.
BLOCK = 4096
#: name -> (dtype, shape of one row, value of a fresh row)
Schema = Mapping[str, tuple[DTypeLike, tuple[int, ...], Any]]

_COMMON: Schema = {"alive": (np.bool_, (), False), "generation": (np.uint32, (), 0)}


@dataclass(frozen=True, slots=True)
class TableState:
    """A copy of a table's own columns (not those that `update()` derives)."""

    count: int
    free: tuple[int, ...]
    columns: Mapping[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class RowValues:
    """The values of some rows of a table, with its length and its free rows. `columns[name]` is [len(rows), ...]."""

    count: int
    free: tuple[int, ...]
    rows: NDArray[np.int64]
    columns: Mapping[str, NDArray[Any]]


class Table:
    """Columns of equal length. `len(table)` counts row numbers in use or free; `alive` tells which hold something.

    Removing a row frees its number and raises its generation; `count` rows added after removing as many get the same
    numbers in the same order. A row that `put` took away comes back with its generation, and a new one there has
    another. Growth is amortised (capacity doubles).
    """

    #: columns that `update()` computes from the others; no part of a remembered state
    DERIVED: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, what: str, schema: Schema) -> None:
        self.what = what
        #: rises with every added or removed row and with every change of who hangs on whom
        self.structure_rev = 0
        self._schema: Schema = {**schema, **_COMMON}
        self._data: dict[str, NDArray[Any]] = {n: np.empty((0, *s), t) for n, (t, s, _) in self._schema.items()}
        self._views: dict[str, NDArray[Any]] = {}
        self._count = 0
        self._free: list[int] = []
        #: the generation that a row's next new holder has at least: undoing takes rows away without a trace in them
        self._next = np.zeros(0, np.uint32)

    def __len__(self) -> int:
        return self._count

    @property
    def alive(self) -> NDArray[np.bool_]:
        """bool[n]: which rows hold something."""
        return self._view("alive")

    @property
    def generation(self) -> NDArray[np.uint32]:
        """u4[n]: how often the row's number was freed."""
        return self._view("generation")

    @property
    def alive_count(self) -> int:
        return self._count - len(self._free)

    def alive_rows(self) -> NDArray[np.int64]:
        return np.flatnonzero(self.alive)

    def select(self, rows: Rows) -> slice | NDArray[np.int64]:
        """Return `rows` checked: a slice where they are a rising run without gaps, else i8[k].

        Accepts one number, a sequence, a bool mask or a slice. Raises InputError for a row that does not exist.
        """
        if isinstance(rows, slice):
            start, stop, step = rows.indices(self._count)
            if step != 1:
                return self.select(np.arange(start, stop, step))
            stop = max(start, stop)
            if self._free and not self._data["alive"][start:stop].all():
                raise InputError(f"slice {start}:{stop} holds removed {self.what} rows")
            return slice(start, stop)
        array = np.asarray(rows)
        if array.dtype == np.bool_:
            array = np.flatnonzero(array)
        array = np.atleast_1d(array).astype(np.int64, copy=False)
        if array.size == 0:
            return slice(0, 0)
        first, last = int(array[0]), int(array[-1])
        if last - first == array.size - 1 and (array.size < 3 or bool((array[1:] - array[:-1] == 1).all())):
            low, high = first, last
            result: slice | NDArray[np.int64] = slice(first, last + 1)
        else:
            low, high = int(array.min()), int(array.max())
            result = array
        if low < 0 or high >= self._count:
            raise InputError(f"no {self.what} row {low if low < 0 else high}", hint=f"there are {self._count}")
        if self._free and not self._data["alive"][result].all():
            dead = array[~self._data["alive"][array]]
            raise InputError(f"{self.what} row {dead[0]} was removed")
        return result

    def remember(self) -> TableState:
        """Return a copy of the state, for `difference`."""
        own = (name for name in self._schema if name not in self.DERIVED)
        return TableState(self._count, tuple(self._free), {n: self._data[n][: self._count].copy() for n in own})

    def difference(self, before: TableState) -> tuple[RowValues, RowValues]:
        """Return the rows that differ bit by bit from `before`: (as they were, as they are)."""
        count = max(self._count, before.count)
        old = {name: self._padded(name, values, count) for name, values in before.columns.items()}
        new = {name: self._padded(name, self._data[name][: self._count], count) for name in before.columns}
        changed = np.zeros(count, np.bool_)
        for name in old:
            changed |= (_bytes(old[name]) != _bytes(new[name])).any(axis=1)
        rows = np.flatnonzero(changed)
        return (
            RowValues(before.count, before.free, rows, {n: v[rows] for n, v in old.items()}),
            RowValues(self._count, tuple(self._free), rows, {n: v[rows] for n, v in new.items()}),
        )

    def put(self, values: RowValues) -> None:
        """Write rows that `difference` returned, with the table's length and free rows."""
        self._reserve(max(values.count, int(values.rows.max(initial=-1)) + 1))
        for name, column in values.columns.items():
            self._data[name][values.rows] = column
        given = np.where(values.columns["alive"], values.columns["generation"] + np.uint32(1), np.uint32(0))
        self._next[values.rows] = np.maximum(self._next[values.rows], given)
        self._count = values.count
        self._free = list(values.free)
        self._views.clear()
        self.structure_rev += 1

    def typed(self, column: str, values: ArrayLike) -> NDArray[Any]:
        """Return `values` as an array [k, ...] of the column's type."""
        dtype, shape, _ = self._schema[column]
        return np.array(values, dtype).reshape(-1, *shape)

    def _padded(self, name: str, values: NDArray[Any], count: int) -> NDArray[Any]:
        dtype, shape, fresh = self._schema[name]
        out = np.full((count, *shape), fresh, dtype)
        out[: len(values)] = values
        return out

    def _view(self, name: str) -> NDArray[Any]:
        view = self._views.get(name)
        if view is None:
            view = self._data[name][: self._count]
            view.flags.writeable = False
            self._views[name] = view
        return view

    def _allocate(self, count: int) -> NDArray[np.int64]:
        """Return `count` fresh rows, set to the schema's values."""
        if 0 < count <= len(self._free):
            rows = np.array(self._free[-count:], np.int64)
            del self._free[-count:]
        else:
            self._reserve(self._count + count)
            rows = np.arange(self._count, self._count + count)
            self._count += count
            self._views.clear()
        where = _run(rows)
        for name, (_, _, value) in self._schema.items():
            if name != "generation":
                self._data[name][where] = value
        self._data["alive"][where] = True
        generation = self._data["generation"]
        generation[where] = np.maximum(generation[where], self._next[where])
        self._next[where] = generation[where] + np.uint32(1)
        self.structure_rev += 1
        return rows

    def _release(self, rows: NDArray[np.int64]) -> None:
        self._data["alive"][rows] = False
        self._data["generation"][rows] += np.uint32(1)
        self._free.extend(rows.tolist())
        self.structure_rev += 1

    def _reserve(self, count: int) -> None:
        capacity = len(self._data["alive"])
        if count <= capacity:
            return
        capacity = max(count, 2 * capacity, 64)
        for name, (dtype, shape, value) in self._schema.items():
            grown = np.full((capacity, *shape), value, dtype)
            grown[: self._count] = self._data[name][: self._count]
            self._data[name] = grown
        self._next = np.append(self._next, np.zeros(capacity - len(self._next), np.uint32))
        self._views.clear()


def _bytes(values: NDArray[Any]) -> NDArray[np.uint8]:
    """Return [n, bytes of a row]: unlike ==, it tells 0.0 from -0.0."""
    if values.shape[0] == 0:
        return np.zeros((0, 1), np.uint8)
    return np.ascontiguousarray(values).view(np.uint8).reshape(len(values), -1)


def _run(rows: NDArray[np.int64]) -> slice | NDArray[np.int64]:
    if rows.size and rows[-1] - rows[0] == rows.size - 1 and (np.diff(rows) == 1).all():
        return slice(int(rows[0]), int(rows[-1]) + 1)
    return rows


def blocks(rows: slice | NDArray[np.int64]) -> Iterator[slice | NDArray[np.int64]]:
    """Yield `rows` in parts of at most BLOCK rows.

    Temporaries of a part stay in cache and below the size from which malloc maps fresh, zeroed pages for each of them.
    """
    if isinstance(rows, slice):
        for start in range(rows.start, rows.stop, BLOCK):
            yield slice(start, min(start + BLOCK, rows.stop))
    else:
        for start in range(0, len(rows), BLOCK):
            yield rows[start : start + BLOCK]
