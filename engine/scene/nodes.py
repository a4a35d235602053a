"""NodeTable: the scene's tree. Parent, translation, rotation, scale in; world transforms and visibility out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import InputError
from engine.math import quat, transform
from engine.scene import hierarchy as forest
from engine.scene.hierarchy import Hierarchy
from engine.scene.propagate import Columns, propagate
from engine.scene.table import Rows, RowValues, Table, blocks

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]

_NO_ROWS: I8 = np.zeros(0, np.int64)
_NO_ROWS.setflags(write=False)

_IDENTITY_WORLD = np.eye(3, 4)

_SCHEMA = {
    "parent": (np.int32, (), -1),
    "translation": (np.float64, (3,), 0.0),
    "rotation": (np.float64, (4,), quat.IDENTITY),
    "scale": (np.float64, (3,), 1.0),
    "visible": (np.bool_, (), True),
    "has_matrix": (np.bool_, (), False),
    "linear": (np.float64, (3, 3), np.eye(3)),
    "reach": (np.float64, (3,), 0.0),
    "world": (np.float64, (3, 4), _IDENTITY_WORLD),
    "visible_world": (np.bool_, (), True),
    "world_rev": (np.uint32, (), 0),
    "turn_rev": (np.uint32, (), 0),
    "moved": (np.bool_, (), True),
    "turned": (np.bool_, (), True),
}


class NodeTable(Table):
    """Nodes by row. Local transforms are T R S; `world` follows at `update()`.

    A node given a `matrix` that is no TRS (shear) keeps the matrix's linear part until its rotation or scale is set.
    Positions are float64 metres: at 1e6 m they are exact to a tenth of a nanometre.
    """

    DERIVED: ClassVar[frozenset[str]] = frozenset(
        {"reach", "world", "visible_world", "world_rev", "turn_rev", "moved", "turned"}
    )

    def __init__(self) -> None:
        super().__init__("node", _SCHEMA)
        #: one string per row; "" for removed rows
        self.name: list[str] = []
        #: rises with every `update()` that changed a world transform
        self.transform_rev = 0
        #: rises with every `update()` after a visibility or structure change
        self.visible_rev = 0
        #: rows whose world, and whose world's linear part, changed at the update that made `transform_rev`
        self.changed: I8 = _NO_ROWS
        self.changed_linear: I8 = _NO_ROWS
        self._hierarchy: Hierarchy | None = None
        self._dirty = self._dirty_visible = False

    # -- columns ------------------------------------------------------------------------------------------------------

    @property
    def parent(self) -> NDArray[np.int32]:
        """i4[n]: the parent's row, or -1."""
        return self._view("parent")

    @property
    def translation(self) -> F8:
        """f8[n,3], metres, in the parent's space."""
        return self._view("translation")

    @property
    def rotation(self) -> F8:
        """f8[n,4], unit, xyzw."""
        return self._view("rotation")

    @property
    def scale(self) -> F8:
        """f8[n,3]; may be zero or negative."""
        return self._view("scale")

    @property
    def visible(self) -> NDArray[np.bool_]:
        """bool[n]: the node's own switch."""
        return self._view("visible")

    @property
    def has_matrix(self) -> NDArray[np.bool_]:
        """bool[n]: the local linear part is a matrix that rotation and scale only approximate."""
        return self._view("has_matrix")

    @property
    def world(self) -> F8:
        """f8[n,3,4]: the upper rows of world_from_local, as of the last `update()`."""
        return self._view("world")

    @property
    def visible_world(self) -> NDArray[np.bool_]:
        """bool[n]: the node and all above it are visible, as of the last `update()`."""
        return self._view("visible_world")

    @property
    def world_rev(self) -> NDArray[np.uint32]:
        """u4[n]: the `transform_rev` at which the row's world last changed."""
        return self._view("world_rev")

    @property
    def turn_rev(self) -> NDArray[np.uint32]:
        """u4[n]: the `transform_rev` at which the linear part of the row's world last changed."""
        return self._view("turn_rev")

    @property
    def hierarchy(self) -> Hierarchy:
        """The level order of the living rows, rebuilt after structural changes."""
        if self._hierarchy is None:
            self._hierarchy = forest.build(self.parent, self.alive)
        return self._hierarchy

    # -- structure ----------------------------------------------------------------------------------------------------

    def add(
        self,
        name: str,
        parent: int = -1,
        translation: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike = (0.0, 0.0, 0.0, 1.0),
        scale: ArrayLike = (1.0, 1.0, 1.0),
        matrix: ArrayLike | None = None,
    ) -> int:
        """Add one node and return its row. `matrix` [4,4] (column vectors) replaces the three others.

        Raises InputError for a parent that does not exist, or values that are not finite.
        """
        if matrix is not None:
            local = np.asarray(matrix, np.float64)
            if local.shape != (4, 4):
                raise InputError(f"node {name!r}: a matrix must have shape (4, 4), got {local.shape}")
            _check_finite(local.reshape(1, 16), "matrix")
            translation, rotation, scale = transform.decompose(local)
        parents = None if parent == -1 else [parent]
        row = int(
            self.add_many([name], parents, np.asarray(translation)[None], np.asarray(rotation)[None],
                          np.asarray(scale)[None])[0]
        )  # fmt: skip
        if matrix is not None:
            self.set_matrix(row, matrix)
        return row

    def add_many(
        self,
        names: Sequence[str],
        parent_rows: ArrayLike | None = None,
        translations: ArrayLike | None = None,
        rotations: ArrayLike | None = None,
        scales: ArrayLike | None = None,
        *,
        batch_parents: ArrayLike | None = None,
    ) -> I8:
        """Add k nodes and return their rows i8[k]; missing columns are the identity.

        `parent_rows` [k]: rows that exist already, or -1. `batch_parents` [k]: instead, an earlier index of this very
        batch, or -1 to fall back on `parent_rows`. Raises InputError and adds nothing when an input is wrong.
        """
        count = len(names)
        parents = np.full(count, -1, np.int64)
        if parent_rows is not None:
            parents[:] = _shaped(parent_rows, (count,), "parent_rows", np.int64)
            self.select(np.unique(parents[parents != -1]))
        if batch_parents is not None:
            inside = _shaped(batch_parents, (count,), "batch_parents", np.int64)
            if ((inside >= np.arange(count)) | (inside < -1)).any():
                raise InputError("batch_parents must name earlier nodes of the batch, or -1")
        t = None if translations is None else _checked(translations, (count, 3), "translation")
        q = None if rotations is None else quat.normalize(_checked(rotations, (count, 4), "rotation"))
        s = None if scales is None else _checked(scales, (count, 3), "scale")
        rows = self._allocate(count)
        if batch_parents is not None:
            parents = np.where(inside >= 0, rows[np.maximum(inside, 0)], parents) if count else parents
        where = self.select(rows)
        self._data["parent"][where] = parents
        for column, values in (("translation", t), ("rotation", q), ("scale", s)):
            if values is not None:
                self._data[column][where] = values
        self.name.extend([""] * (len(self) - len(self.name)))
        for row, name in zip(rows.tolist(), names, strict=True):
            self.name[row] = name
        self._structure_changed()
        return rows

    def remove(self, rows: Rows) -> I8:
        """Remove `rows` and everything below them; return all rows removed, rising. Views of them become stale."""
        where = self.select(rows)
        tops = np.arange(where.start, where.stop) if isinstance(where, slice) else where
        gone = forest.subtree(self.parent, self.alive, tops)
        self._release(gone)
        self._data["parent"][gone] = -1
        for row in gone.tolist():
            self.name[row] = ""
        self._structure_changed()
        return gone

    def put(self, values: RowValues) -> None:
        super().put(values)
        del self.name[len(self) :]
        self.name.extend([""] * (len(self) - len(self.name)))
        inside = values.rows[values.rows < len(self)]
        self._data["moved"][inside] = self._data["turned"][inside] = True
        self._structure_changed()

    def reparent(self, row: int, parent: int) -> None:
        """Hang `row` below `parent` (-1: make it a root), keeping its local transform.

        Raises InputError if `parent` is `row` itself or below it.
        """
        self.select(row)
        if parent != -1:
            self.select(parent)
        above = parent
        while above != -1:
            if above == row:
                raise InputError(
                    f"cannot hang node {self.name[row]!r} below {self.name[parent]!r}, which is part of it",
                    hint="choose a parent outside the subtree",
                )
            above = int(self._data["parent"][above])
        self._data["parent"][row] = parent
        self._data["moved"][row] = self._data["turned"][row] = True
        self.structure_rev += 1
        self._structure_changed()

    # -- transforms ---------------------------------------------------------------------------------------------------

    def set_translation(self, rows: Rows, values: ArrayLike) -> None:
        """Set translations [k,3] (or [3] for all rows). Raises InputError for values that are not finite."""
        where = self.select(rows)
        self._data["translation"][where] = _checked(values, (_length(where), 3), "translation")
        self._data["moved"][where] = True
        self._dirty = True

    def set_rotation(self, rows: Rows, values: ArrayLike) -> None:
        """Set rotations [k,4] (or [4]), normalised here; a zero quaternion becomes the identity."""
        where = self.select(rows)
        self._data["rotation"][where] = quat.normalize(_checked(values, (_length(where), 4), "rotation"))
        self._turn(where)

    def set_scale(self, rows: Rows, values: ArrayLike) -> None:
        """Set scales [k,3] (or [3])."""
        where = self.select(rows)
        self._data["scale"][where] = _checked(values, (_length(where), 3), "scale")
        self._turn(where)

    def set_trs(self, rows: Rows, translations: ArrayLike, rotations: ArrayLike, scales: ArrayLike) -> None:
        """Set all three; nothing is changed when one of them is wrong."""
        where = self.select(rows)
        count = _length(where)
        t = _checked(translations, (count, 3), "translation")
        q = quat.normalize(_checked(rotations, (count, 4), "rotation"))
        self._data["scale"][where] = _checked(scales, (count, 3), "scale")
        self._data["translation"][where] = t
        self._data["rotation"][where] = q
        self._data["moved"][where] = True
        self._turn(where)

    def set_matrix(self, row: int, matrix: ArrayLike) -> None:
        """Set a local transform [4,4] (column vectors). One that is no TRS is kept exactly; TRS is then its nearest."""
        self.select(row)
        local = np.asarray(matrix, np.float64)
        if local.shape != (4, 4):
            raise InputError(f"node {self.name[row]!r}: a matrix must have shape (4, 4), got {local.shape}")
        _check_finite(local.reshape(1, 16), "matrix")
        t, q, s = transform.decompose(local)
        self.set_trs(row, t, q, s)
        size = float(np.abs(local[:3, :3]).max())
        if not np.allclose(transform.compose(t, q, s)[:3, :3], local[:3, :3], rtol=0.0, atol=1e-9 * size):
            self._data["linear"][row] = local[:3, :3]
            self._data["has_matrix"][row] = True

    def touch(self, rows: Rows) -> None:
        """Count `rows` as moved although their transforms stay: what hangs on them has another shape now."""
        self._data["moved"][self.select(rows)] = True
        self._dirty = True

    def set_visible(self, rows: Rows, values: ArrayLike) -> None:
        """Set the nodes' own visibility, bool [k] or one for all."""
        where = self.select(rows)
        self._data["visible"][where] = np.asarray(values, np.bool_)
        self._dirty_visible = True

    def update(self) -> I8:
        """Bring `world` and `visible_world` up to date; return the rows i8[k] whose world changed, in level order.

        Costs one comparison when nothing was set.
        """
        if not (self._dirty or self._dirty_visible):
            return _NO_ROWS
        if self._dirty_visible:
            self._update_visible()
        if not self._dirty:
            return _NO_ROWS
        self._dirty = False
        data, count = self._data, len(self)
        moved, turned = data["moved"][:count], data["turned"][:count]
        with np.errstate(over="ignore", invalid="ignore"):
            self._update_linear(turned)
            columns = Columns(data["parent"], data["translation"], data["linear"], data["reach"], data["world"])
            self.changed, self.changed_linear = propagate(self.hierarchy, columns, moved, turned)
        moved.fill(False)
        turned.fill(False)
        self.transform_rev += 1
        _fill(data["world_rev"][:count], self.changed, self.transform_rev)
        _fill(data["turn_rev"][:count], self.changed_linear, self.transform_rev)
        return self.changed

    def world_matrix(self, row: int) -> F8:
        """Return world_from_local f8[4,4] of a row, as of the last `update()`."""
        self.select(row)
        m = np.eye(4)
        m[:3] = self._data["world"][row]
        return m

    def local_matrix(self, row: int) -> F8:
        """Return parent_from_local f8[4,4] of a row; always up to date."""
        self.select(row)
        m = transform.compose(self.translation[row], self.rotation[row], self.scale[row])
        if self._data["has_matrix"][row]:
            m[:3, :3] = self._data["linear"][row]
        return m

    def children(self, row: int) -> I8:
        """Return the rows directly below `row`, rising. O(n): for editors and scripts."""
        self.select(row)
        return np.flatnonzero(self.parent == row)

    # -- inside -------------------------------------------------------------------------------------------------------

    def _turn(self, where: slice | I8) -> None:
        self._data["turned"][where] = True
        self._data["has_matrix"][where] = False
        self._dirty = True

    def _structure_changed(self) -> None:
        self._hierarchy = None
        self._dirty = self._dirty_visible = True

    def _update_linear(self, turned: NDArray[np.bool_]) -> None:
        data = self._data
        count = int(np.count_nonzero(turned))
        if count == 0:
            return
        matrices = data["has_matrix"][: len(turned)]
        whole = count == len(turned) and not matrices.any()
        for rows in blocks(slice(0, count) if whole else np.flatnonzero(turned & ~matrices)):
            data["linear"][rows] = quat.to_matrix3(data["rotation"][rows]) * data["scale"][rows, None, :]

    def _update_visible(self) -> None:
        self._dirty_visible = False
        self.visible_rev += 1
        data, h = self._data, self.hierarchy
        data["visible_world"][: len(self)] = data["visible"][: len(self)] & data["alive"][: len(self)]
        for level in range(1, h.levels):
            rows = h.order[h.level_start[level] : h.level_start[level + 1]]
            data["visible_world"][rows] &= data["visible_world"][data["parent"][rows]]


def _fill(column: NDArray[np.uint32], rows: I8, value: int) -> None:
    if len(rows) == len(column):
        column.fill(value)
    elif len(rows):
        column[rows] = value


def _length(where: slice | I8) -> int:
    return where.stop - where.start if isinstance(where, slice) else len(where)


def _shaped(values: ArrayLike, shape: tuple[int, ...], what: str, dtype: type[np.generic]) -> NDArray[np.int64]:
    array = np.asarray(values, dtype)
    if array.shape != shape:
        raise InputError(f"{what} must have shape {shape}, got {array.shape}")
    return array.astype(np.int64, copy=False)


def _checked(values: ArrayLike, shape: tuple[int, int], what: str) -> F8:
    array = np.asarray(values, np.float64)
    if array.shape not in (shape, shape[1:]):
        raise InputError(f"{what} must have shape {shape}, got {array.shape}")
    _check_finite(array.reshape(-1, shape[1]), what)
    return array


def _check_finite(array: F8, what: str) -> None:
    # a sum is NaN or infinite if any value is; only then look which one
    with np.errstate(over="ignore", invalid="ignore"):
        total = float(array.sum())
    if total - total != 0.0:
        bad = ~np.isfinite(array).all(axis=1)
        if bad.any():
            index = int(np.argmax(bad))
            raise InputError(f"{what} {array[index].tolist()} at index {index} is not finite")
