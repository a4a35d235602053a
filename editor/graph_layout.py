"""Where the passes and textures of a compiled frame graph stand, as plain numbers. No imgui.

Passes in columns by how many passes must run before them, in rows by their order; a texture is an edge from the pass
that last wrote it to each pass that reads that version.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Box:
    """A pass. `column` and `row` on a grid; `reason` says why it was left out, '' for one that runs."""

    name: str
    column: int
    row: int
    writes: tuple[str, ...] = ()
    reason: str = ""
    saved: int = 0


@dataclass(frozen=True, slots=True)
class Edge:
    """Textures `resources` from box `start` to box `end` (indices). `history`: what the frame before wrote."""

    start: int
    end: int
    resources: tuple[str, ...]
    history: bool = False


@dataclass(frozen=True, slots=True)
class Diagram:
    boxes: tuple[Box, ...]
    edges: tuple[Edge, ...]
    columns: int
    rows: int
    #: rows of those that run; the others are below
    rows_running: int = 0


def diagram(declarations: Sequence[Any], left_out: Sequence[Any]) -> Diagram:
    """The diagram of what runs (framegraph.builder.Declaration, in order) and, in a row of its own, of what does not
    (framegraph.compiled.LeftOut)."""
    ways: dict[tuple[int, int, bool], list[str]] = {}
    writer: dict[str, int] = {}
    for index, declaration in enumerate(declarations):
        sources = dict.fromkeys((*declaration.reads, *(w for w in declaration.writes if w in writer)))
        for name in sources:
            if name in writer:
                ways.setdefault((writer[name], index, False), []).append(name)
        for name in declaration.writes:
            writer[name] = index
    for index, declaration in enumerate(declarations):
        for name in declaration.histories:
            if writer.get(name, index) != index:
                ways.setdefault((writer[name], index, True), []).append(name)
    edges = [Edge(start, end, tuple(names), history) for (start, end, history), names in ways.items()]
    columns = _columns(len(declarations), edges)
    used: dict[int, int] = {}
    boxes = []
    for index, declaration in enumerate(declarations):
        row = used.get(columns[index], 0)
        used[columns[index]] = row + 1
        boxes.append(Box(declaration.name, columns[index], row, tuple(declaration.writes)))
    width = max([*columns, -1]) + 1
    height = max([*used.values(), 0])
    across = max(width, 4)
    for i, item in enumerate(left_out):
        boxes.append(Box(item.name, i % across, height + i // across, (), str(item.reason), int_or_zero(item.saved)))
    width = max(width, min(len(left_out), across))
    return Diagram(tuple(boxes), tuple(edges), width, height + -(-len(left_out) // across), height)


def int_or_zero(value: object) -> int:
    return value if isinstance(value, int) else 0


def _columns(count: int, edges: Sequence[Edge]) -> list[int]:
    """The longest way to each pass; passes are in order of execution, so one sweep suffices."""
    columns = [0] * count
    for end in range(count):
        before = [columns[e.start] + 1 for e in edges if e.end == end and not e.history and e.start < end]
        columns[end] = max(before, default=0)
    return columns
