"""Which rows of the scene tree show, as flat lists. No imgui.

Only unfolded nodes are walked, so that a scene of a hundred thousand nodes costs what is on the screen.
"""

from __future__ import annotations

from dataclasses import dataclass

from editor.document import Document

#: nodes unfolded from the start when the scene has no more than these
UNFOLD_LIMIT = 300


@dataclass(frozen=True, slots=True)
class TreeRow:
    row: int
    depth: int
    has_children: bool


def visible_rows(document: Document, unfolded: set[int]) -> list[TreeRow]:
    """Depth first, parents before children, without what lies under folded nodes."""
    found: list[TreeRow] = []
    stack = [(row, 0) for row in reversed(document.children_of(-1))]
    while stack:
        row, depth = stack.pop()
        children = document.children_of(row)
        found.append(TreeRow(row, depth, bool(children)))
        if row in unfolded:
            stack.extend((child, depth + 1) for child in reversed(children))
    return found


def matching_rows(document: Document, needle: str) -> list[TreeRow]:
    """All nodes whose name holds `needle`, ignoring case, with their ancestors; unfolded."""
    nodes = document.runtime.scene.nodes
    needle = needle.lower().strip()
    keep: set[int] = set()
    for row, name in enumerate(nodes.name):
        if needle in name.lower() and nodes.alive[row]:
            at = row
            while at >= 0 and at not in keep:
                keep.add(at)
                at = int(nodes.parent[at])
    return [r for r in visible_rows(document, keep) if r.row in keep]


def ancestors(document: Document, row: int) -> list[int]:
    """The nodes above `row`, nearest first."""
    parents = document.runtime.scene.nodes.parent
    found = []
    at = int(parents[row])
    while at >= 0:
        found.append(at)
        at = int(parents[at])
    return found


def kinds(document: Document) -> dict[int, str]:
    """Node row -> mesh, light or camera, for those that carry one."""
    scene = document.runtime.scene
    found = dict.fromkeys((int(n) for n in scene.instances.node), "mesh")
    found.update(dict.fromkeys((int(n) for n in scene.cameras.node), "camera"))
    found.update(dict.fromkeys((int(n) for n in scene.lights.node), "light"))
    return found
