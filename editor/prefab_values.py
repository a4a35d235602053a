"""What an instance of a prefab has of its own, value by value: listed, reverted, applied to the prefab. No imgui.

own_values ─► the list of the inspector, the tree's hint, what saving writes down (engine.assets.prefab.FIELDS)
revert_value ─► one entry of plain edits, where the value is one of a table; else the scene is read again
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from editor import prefabs, saving
from editor.commands import structure
from engine.assets.prefab import NODE, differ, own_fields
from engine.assets.scene import NodeAsset

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session

#: the field under which a node is listed that the prefab has and the instance lacks
REMOVED = "removed"
#: what the fields are called in lists
LABELS = {
    "name": "Name", "place": "Place", "visible": "Visible", "mesh": "Mesh and materials", "light": "Light",
    "camera": "Camera", "weights": "Morph weights", REMOVED: "Removed",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class OwnValue:
    """`node`: its key in the prefab; `row`: in the scene, -1 where it was removed; `here`, `there`: in words."""

    node: str
    row: int
    field: str
    here: str
    there: str


def nodes_now(document: Document, rows: Sequence[int]) -> dict[int, NodeAsset]:
    """Nodes as saving would write them, by row; without what counts other nodes. Not to be written into: what nobody
    touched is the node as it was read."""
    runtime = document.runtime
    scene, base = runtime.scene, runtime.asset
    touched = _touched(document)
    if not saving.is_restructured(scene, base):
        nodes = {row: copy.deepcopy(base.nodes[row]) if row in touched else base.nodes[row] for row in rows}
        _say(document, nodes, nodes.keys() & touched)
        return nodes
    from engine.scene.convert import node_assets

    index = {row: i for i, row in enumerate(scene.row_of_node.tolist()) if row >= 0}
    driven = saving.driven_rows(runtime)
    nodes = {row: base.nodes[index[row]] for row in rows if row in index and row not in touched}
    nodes |= _as_they_came(scene, [row for row in rows if row not in nodes and row not in touched], driven)
    changed = node_assets(scene, [row for row in rows if row not in nodes])
    rests = {row: base.nodes[index[row]] if row in index else scene.sources[row] for row in changed
             if row in index or row in driven}  # fmt: skip
    for row, old in rests.items():
        node = changed[row]
        node.translation, node.rotation, node.scale = old.translation, old.rotation, old.scale
        node.matrix = old.matrix
    for (table, column, row), value in document.overrides.items():
        if table == "nodes" and row in rests:
            saving.apply_to_node(changed[row], column, value)
    return nodes | changed


def _touched(document: Document) -> set[int]:
    """The rows of nodes that the user said something of, or of what they carry."""
    scene = document.runtime.scene
    rows = {row for table, _, row in document.overrides if table in ("nodes", "objects")}
    carried = {(table, row) for table, _, row in document.overrides if table in ("lights", "cameras")}
    return rows | {int(getattr(scene, table).node[row]) for table, row in carried}


def _say(document: Document, nodes: dict[int, NodeAsset], rows: Collection[int]) -> None:
    """What the user said of the nodes `rows` of the file."""
    scene = document.runtime.scene
    for (table, column, row), value in document.overrides.items() if rows else ():
        if table == "nodes" and row in rows:
            saving.apply_to_node(nodes[row], column, value)
        elif table == "objects" and row in rows:
            saving.apply_to_object(nodes[row], column, value)
        elif table in ("lights", "cameras"):
            carrier = int(getattr(scene, table).node[row])
            part = getattr(nodes[carrier], table.removesuffix("s")) if carrier in rows else None
            if part is not None:
                setattr(part, column, value)


def _as_they_came(scene: Any, rows: Sequence[int], driven: Collection[int]) -> dict[int, NodeAsset]:
    """Of nodes that came since the scene was opened those that are still as they came: their sources."""
    table, found = scene.nodes, {}
    places = zip(
        *(column[list(rows)].tolist() for column in (table.translation, table.rotation, table.scale)), strict=True
    )
    visible = table.visible[list(rows)].tolist()
    for row, place, shows in zip(rows, places, visible, strict=True):
        source = scene.sources.get(row)
        if source is None or source.light is not None or source.camera is not None or source.matrix is not None:
            continue
        stands = row in driven or tuple(map(tuple, place)) == (source.translation, source.rotation, source.scale)
        if stands and table.name[row] == source.name and shows == source.visible and not table.has_matrix[row]:
            found[row] = source
    return found


def prefab_nodes(document: Document, root: int) -> dict[str, NodeAsset] | None:
    """The nodes of the prefab of the instance at `root` by key, as it was when it was read; None: unknown."""
    path = prefabs.path_of(document, root)
    for _ in range(2):
        found = next((nodes for p, nodes in document.prefabs.items() if p.resolve() == path), None)
        if found is not None:
            return {str(node.extras[NODE]): node for node in found[1:]}
        saving.know_prefabs(document, document.runtime.asset)
    return None


def members_of(document: Document, root: int) -> dict[str, int]:
    """The rows of what came with the prefab, by key."""
    sources = document.runtime.scene.sources
    found: dict[str, int] = {}
    queue = [root]
    while queue:
        row = queue.pop()
        for below in reversed(document.children_of(row)):
            queue.append(below)
        source = sources.get(row)
        if row != root and source is not None and NODE in source.extras:
            found[str(source.extras[NODE])] = row
    return found


def own_values(document: Document, root: int) -> list[OwnValue]:
    """What the instance at row `root` has of its own, in the prefab's order."""
    prefab = prefab_nodes(document, root)
    if prefab is None:
        return []
    rows = members_of(document, root)
    mine = nodes_now(document, list(rows.values()))
    found: list[OwnValue] = []
    for key, node in prefab.items():
        if key not in rows:
            found.append(OwnValue(key, -1, REMOVED, "", ""))
            continue
        own = mine[rows[key]]
        found += [OwnValue(key, rows[key], field, *_words(field, own, node)) for field in own_fields(own, node)]
    return found


def changes(document: Document, root: int) -> tuple[dict[str, list[str]], list[str]]:
    """The same as the scene's file says it: (node -> fields, nodes that the instance lacks)."""
    changed: dict[str, list[str]] = {}
    removed = []
    for value in own_values(document, root):
        if value.field == REMOVED:
            removed.append(value.node)
        else:
            changed.setdefault(value.node, []).append(value.field)
    return changed, removed


class OwnValues:
    """`of`: own_values, found again when something changed, but for the middle of a drag."""

    def __init__(self) -> None:
        self._key: object = None
        self._found: list[OwnValue] = []

    def of(self, document: Document, root: int) -> list[OwnValue]:
        key = (id(document.runtime), root, document.history.revision, int(document.runtime.scene.structure_rev))
        same = self._key is not None and isinstance(self._key, tuple) and self._key[:2] == key[:2]
        if key != self._key and not (same and document.history.in_gesture):
            self._key, self._found = key, own_values(document, root)
        return self._found


def selected_root(session: Session) -> int:
    """The row of the instance that is selected, or lies around what is; -1 for none."""
    document = session.document
    return prefabs.root_of(document, document.primary) if document is not None and document.primary >= 0 else -1


def nothing_own(node: str, field: str) -> str:
    return f"{node} has no {LABELS.get(field, field).lower()} of its own"


# --- taking back ---


def revert_value(session: Session, node: str, field: str) -> bool:
    """Give one value of the selected instance back to its prefab. False where there is none of that kind."""
    from editor import prefab_updates

    document, root = session.document, selected_root(session)
    if document is None or root < 0:
        session.ui.notice = "Select an instance of a prefab"
        return False
    found = next((v for v in own_values(document, root) if (v.node, v.field) == (node, field)), None)
    prefab = prefab_nodes(document, root)
    if found is None or prefab is None:
        session.ui.notice = nothing_own(node, field)
        return False
    write = _writer(document, found, prefab[node]) if field != REMOVED else None
    if write is None:
        return prefab_updates.revert(session, (node, field))
    selected = document.selection

    def make() -> tuple[int, ...]:
        write()
        return selected

    structure.change(document, f"Revert {LABELS[field].lower()} of {session.node_name(found.row)}", make)
    return True


def _writer(document: Document, found: OwnValue, node: NodeAsset) -> Callable[[], None] | None:
    """What writes the prefab's value to the tables; None where no table has it."""
    row, tables, said = found.row, document.tables, document.overrides
    if found.field in ("name", "visible"):

        def plain() -> None:
            value = getattr(node, found.field)
            tables["nodes"].write(found.field, (row,), (value,))
            said["nodes", found.field, row] = value

        return plain
    if found.field == "place":
        matrix = None if node.matrix is None else tuple(map(tuple, np.array(node.matrix).reshape(4, 4).T.tolist()))
        local = (node.translation, node.rotation, node.scale, matrix)

        def place() -> None:
            tables["nodes"].write("local", (row,), (local,))
            for column in ("translation", "rotation", "scale", "local"):
                said.pop(("nodes", column, row), None)
            said["nodes", "local", row] = local

        return place
    table = {"light": "lights", "camera": "cameras"}.get(found.field, "")
    carriers = list(_carried(document, table, row)) if table else []
    part = getattr(node, found.field) if table else None
    if part is None or len(carriers) != 1:
        return None

    def carried() -> None:
        values = {f.name: getattr(part, f.name) for f in fields(part)}
        other = [name for name in values if tables[table].read(name, carriers)[0] != values[name]]
        getattr(document.runtime.scene, table).set(carriers[0], **values)
        said.update({(table, name, carriers[0]): values[name] for name in other})

    return carried


def _carried(document: Document, table: str, row: int) -> Iterator[int]:
    """Rows of the lights or cameras on a node."""
    found = getattr(document.runtime.scene, table)
    return (int(i) for i in found.alive_rows().tolist() if int(found.node[i]) == row)


# --- in words ---


def _words(field: str, own: NodeAsset, node: NodeAsset) -> tuple[str, str]:
    return _said(field, own, node), _said(field, node, own)


def _said(field: str, node: NodeAsset, other: NodeAsset) -> str:
    """The value in words, and of what has many parts those that differ from `other`'s."""
    if field == "place":
        if differ(node.matrix, other.matrix):
            return "a matrix" if node.matrix is not None else "move, turn, scale"
        parts = [("", node.translation, other.translation), ("turned ", node.rotation, other.rotation),
                 ("scaled ", node.scale, other.scale)]  # fmt: skip
        return ", ".join(f"{word}{_numbers(mine)}" for word, mine, its in parts if differ(mine, its))
    if field in ("light", "camera"):
        mine, its = getattr(node, field), getattr(other, field)
        if mine is None or its is None:
            return "none" if mine is None else "one"
        names = [f.name for f in fields(mine) if differ(getattr(mine, f.name), getattr(its, f.name))]
        return ", ".join(f"{name.replace('_', ' ')} {_plain(getattr(mine, name))}" for name in names)
    if field == "mesh":
        return "none" if node.mesh is None else node.mesh.name or node.mesh.file
    if field == "weights":
        return _numbers(tuple(node.weights)) if node.weights else "at rest"
    return _plain(getattr(node, field))


def _numbers(values: tuple[float, ...]) -> str:
    return " ".join(f"{v:.4g}" for v in values[:4]) + (" …" if len(values) > 4 else "")


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    return _numbers(tuple(value)) if isinstance(value, (tuple, list)) else str(value)
