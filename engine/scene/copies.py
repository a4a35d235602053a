"""Copies: nodes that clips move as they move another one, as of now; and those that move about a place of their own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip_nodes import ClipNodes, clip_number
from engine.math import quat
from engine.scene.nodes import NodeTable

if TYPE_CHECKING:
    from engine.scene.scene import Scene

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]
Trs = tuple[F8, F8, F8]

PATHS = ("translation", "rotation", "scale")
#: moves that leave a translation, a rotation, a scale exactly as it is
_NO_MOVE = (np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), np.ones(3))


@dataclass(frozen=True, slots=True)
class Copies:
    """Pair i: what clips do to the node that row `leader[i]` held when the scene was opened happens to `row[i]` too.

    `placed` bool[k]: these make the moves about their own place (see OwnPlaces)."""

    leader: I8 = field(default_factory=lambda: np.zeros(0, np.int64))
    row: I8 = field(default_factory=lambda: np.zeros(0, np.int64))
    placed: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))

    def __len__(self) -> int:
        return len(self.row)

    @property
    def moving(self) -> Copies:
        """Those whose transforms become the leader's."""
        return self._part(~self.placed)

    @property
    def staying(self) -> Copies:
        """The placed ones."""
        return self._part(self.placed)

    def _part(self, keep: NDArray[np.bool_]) -> Copies:
        return self if keep.all() else Copies(self.leader[keep], self.row[keep], self.placed[keep])

    def and_(self, other: Copies) -> Copies:
        """The pairs of both."""
        if not len(other):
            return self
        return Copies(
            np.append(self.leader, other.leader), np.append(self.row, other.row), np.append(self.placed, other.placed)
        )

    def repeat(self, rows: I8) -> tuple[I8, I8]:
        """(which of `rows`, as indices; copies' rows): every pair whose leader is among `rows`."""
        order = np.argsort(rows, kind="stable")
        at = np.searchsorted(rows[order], self.leader)
        found = np.flatnonzero(at < len(rows))
        found = found[rows[order[at[found]]] == self.leader[found]]
        return order[at[found]], self.row[found]


@dataclass(frozen=True, slots=True)
class _Own:
    """`own`: of one of translation, rotation, scale; `move`: what was last made of it; `written`: what came of that.
    `moved`: by a clip."""

    generation: int
    own: F8
    move: F8
    written: F8
    moved: bool = False


class OwnPlaces:
    """Where placed copies would stand if no clip moved them: what a clip does to their leader, from where that rests,
    happens to them from there.

        t = own + (clip's - rest)        q = own (rest)^-1 (clip's)        s = own (clip's / rest)

    Who moves a copy by hand moves its own place: what stands in the node table is then not what was written here.
    """

    def __init__(self, nodes: NodeTable) -> None:
        """`nodes`: as they rest."""
        self._nodes = nodes
        self._rest: Trs = (nodes.translation.copy(), nodes.rotation.copy(), nodes.scale.copy())
        self._generation = nodes.generation.copy()
        self._known: dict[tuple[int, int], _Own] = {}
        self._resting = False

    def __len__(self) -> int:
        return len(self._known)

    def adopt(self, copies: Copies) -> None:
        """Find the own places of placed `copies` that are new. One made while its leader is in the midst of a move is
        in the midst of it too."""
        staying = copies.staying
        for leader, row in zip(staying.leader.tolist(), staying.row.tolist(), strict=True):
            for number, column in enumerate(self._columns()):
                if self._entry(number, row) is not None:
                    continue
                still = self._alive(row) or not self._alive(leader)
                moved = not (still or self._resting or np.array_equal(column[leader], self._rest[number][leader]))
                move = _move(number, self._rest[number][leader], column[leader]) if moved else _NO_MOVE[number]
                own, now = _back(number, column[row], move), column[row].copy()
                self._known[number, row] = _Own(int(self._nodes.generation[row]), own, move, now, moved)

    def write(self, copies: Copies, path: str, rows: I8, values: F8) -> None:
        """Let the placed of `copies` follow their leaders among `rows` i8[k], which are set to `values`."""
        staying = copies.staying
        if not len(staying):
            return
        which, to = staying.repeat(rows)
        number = PATHS.index(path)
        for i, row in zip(which.tolist(), to.tolist(), strict=True):  # few: heads of what was copied
            own = self._own(number, row)
            if own is None:
                continue
            self._pose(number, row, own, _move(number, self._rest[number][int(rows[i])], values[i]))

    def rest(self) -> None:
        """Put them back to their own places."""
        for (number, row), entry in list(self._known.items()):
            own = self._own(number, row)
            if own is None:
                del self._known[number, row]
            elif entry.moved:
                self._set(number, row, own)
                now = self._columns()[number][row].copy()
                self._known[number, row] = _Own(entry.generation, own, _NO_MOVE[number], now)

    @contextmanager
    def rested(self) -> Iterator[None]:
        """Within, they stand at their own places, and so do those that come: what is kept of the table then holds
        wherever time stands. Afterwards those that were moved are moved as before."""
        if self._resting:
            yield
            return
        moves = {key: entry.move for key, entry in self._known.items() if entry.moved}
        self.rest()
        self._resting = True
        try:
            yield
        finally:
            self._resting = False
            for (number, row), move in moves.items():
                own = self._own(number, row)
                if own is not None:
                    self._pose(number, row, own, move)

    def own_of(self, number: int, row: int, value: F8) -> F8:
        """What a `value` of the table, with what clips do to the node now, is without that."""
        entry = self._entry(number, row)
        if entry is None or not entry.moved:
            return value
        return entry.own if np.array_equal(value, entry.written) else _back(number, value, entry.move)

    def stand(self, number: int, row: int) -> None:
        """The table was just given an own place: add what clips do to the node now."""
        entry = self._entry(number, row)
        if entry is not None and entry.moved:
            self._pose(number, row, self._columns()[number][row].copy(), entry.move)

    def of(self, row: int) -> Trs:
        """The own translation, rotation and scale of any node: where it stands, unless a clip moves it from there."""
        found = []
        for number, column in enumerate(self._columns()):
            entry = self._entry(number, row)
            own = self._own(number, row) if entry is not None and entry.moved else None
            found.append(column[row] if own is None else own)
        return found[0], found[1], found[2]

    def _pose(self, number: int, row: int, own: F8, move: F8) -> None:
        self._set(number, row, _forth(number, own, move))
        now = self._columns()[number][row].copy()
        self._known[number, row] = _Own(int(self._nodes.generation[row]), own, move, now, moved=True)

    def _own(self, number: int, row: int) -> F8 | None:
        entry = self._entry(number, row)
        if entry is None:
            return None
        now = self._columns()[number][row]
        return entry.own if np.array_equal(now, entry.written) else _back(number, now, entry.move)

    def _entry(self, number: int, row: int) -> _Own | None:
        """What is known of the node that the row holds now."""
        nodes, entry = self._nodes, self._known.get((number, row))
        if entry is None or row >= len(nodes) or entry.generation != int(nodes.generation[row]):
            return None
        return entry if nodes.alive[row] else None

    def _columns(self) -> Trs:
        return self._nodes.translation, self._nodes.rotation, self._nodes.scale

    def _set(self, number: int, row: int, value: F8) -> None:
        nodes = self._nodes
        (nodes.set_translation, nodes.set_rotation, nodes.set_scale)[number](row, value)

    def _alive(self, row: int) -> bool:
        """Whether the row holds the node that it held at rest."""
        nodes = self._nodes
        known = row < min(len(self._generation), len(nodes))
        return known and bool(nodes.alive[row]) and bool(nodes.generation[row] == self._generation[row])


def _move(number: int, rest: F8, value: F8) -> F8:
    if number == 0:
        moved: F8 = value - rest
    elif number == 1:
        moved = quat.multiply(quat.conjugate(rest), value)
    else:
        moved = value / np.where(rest == 0.0, 1.0, rest)
    return moved


def _forth(number: int, own: F8, move: F8) -> F8:
    result: F8 = own + move if number == 0 else quat.multiply(own, move) if number == 1 else own * move
    return result


def _back(number: int, value: F8, move: F8) -> F8:
    if number == 0:
        result: F8 = value - move
    elif number == 1:
        result = quat.multiply(value, quat.conjugate(move))
    else:
        result = value / np.where(move == 0.0, 1.0, move)
    return result


def copies_of(scene: Scene, lead: ClipNodes | None, opened: I8) -> Copies:
    """The scene's copies: `lead` and `opened` i8[nodes], rows by index, are as when it was opened.

    Runs after structural changes only, so a plain loop is fine here."""
    index_of = {int(row): i for i, row in enumerate(scene.row_of_node.tolist()) if row >= 0}
    found: list[tuple[int, int, bool]] = []
    for row, source in scene.sources.items():
        if source.clip_node is None:
            continue
        number = clip_number(source, -1)
        leader = number if lead is None else lead.weighed.get(number, -1)
        if 0 <= leader < len(opened) and index_of.get(row, -1) != leader:
            found.append((int(opened[leader]), row, source.placed))
    if not found:
        return Copies()
    table = np.array(found, np.int64)
    return Copies(table[:, 0], table[:, 1], table[:, 2].astype(np.bool_))
