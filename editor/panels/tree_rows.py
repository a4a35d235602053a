"""Which rows of the scene tree show, as flat lists. No imgui.

Only unfolded nodes are walked, so that a scene of a hundred thousand nodes costs what is on the screen.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import NamedTuple

from editor.document import Document

#: nodes unfolded from the start when the scene has no more than these
UNFOLD_LIMIT = 300


class TreeRow(NamedTuple):
    row: int
    depth: int
    has_children: bool


def visible_rows(document: Document, unfolded: Collection[int]) -> list[TreeRow]:
    """Depth first, parents before children, without what lies under folded nodes."""
    found: list[TreeRow] = []
    children_of = document.children
    stack = [(row, 0) for row in reversed(children_of.get(-1, []))]
    while stack:
        row, depth = stack.pop()
        children = children_of.get(row)
        found.append(TreeRow(row, depth, children is not None))
        if children is None:
            continue
        if row in unfolded:
            stack.extend((child, depth + 1) for child in reversed(children))
    return found


def matching_rows(document: Document, needle: str) -> list[TreeRow]:
    """All nodes whose name holds `needle`, ignoring case, with their ancestors; unfolded."""
    nodes = document.runtime.scene.nodes
    needle = needle.lower().strip()
    keep: set[int] = set()
    parents, alive = nodes.parent.tolist(), nodes.alive.tolist()
    for row, name in enumerate(nodes.name):
        if needle in name.lower() and alive[row]:
            at = row
            while at >= 0 and at not in keep:
                keep.add(at)
                at = parents[at]
    return [r for r in visible_rows(document, keep) if r.row in keep]


def ancestors(document: Document, rows: Iterable[int]) -> set[int]:
    """The nodes above any of `rows`."""
    parents = document.runtime.scene.nodes.parent
    parents = parents.tolist() if len(list(rows)) > 100 else parents
    found: set[int] = set()
    for row in rows:
        at = int(parents[row])
        while at >= 0 and at not in found:
            found.add(at)
            at = int(parents[at])
    return found


def kinds(document: Document) -> dict[int, str]:
    """Node row -> mesh, light or camera, for those that carry one."""
    scene = document.runtime.scene
    found = dict.fromkeys((int(n) for n in scene.instances.node), "mesh")
    found.update(dict.fromkeys((int(n) for n in scene.cameras.node), "camera"))
    found.update(dict.fromkeys((int(n) for n in scene.lights.node), "light"))
    return found
