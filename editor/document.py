"""Document: one open scene: where it came from, its runtime, its edit history, what is selected. No imgui."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from editor.bookmark_table import BOOKMARKS, BookmarkTable, of_asset
from editor.camera_controls import OrbitCamera
from editor.commands.command import Command, Edit, Said
from editor.commands.history import History
from editor.commands.lights import follow_drifts
from editor.commands.replacement import FileStep, Replacement
from editor.commands.structure import PLACE, StructureCommand
from editor.host import Resolved, Runtime, box_corners
from editor.tables import make_command, tables_of
from engine.core.errors import LucarnaError

#: parts whose real boxes are looked at one by one; above, their bounding spheres serve
EXACT_LIMIT = 200
#: up to so many vertices the box of a bent mesh is that of its posed vertices, above that of its joints' boxes
EXACT_VERTICES = 5000


class Document:
    """Owns `runtime` until `close()`."""

    def __init__(self, resolved: Resolved, runtime: Runtime) -> None:
        self.source = resolved.source
        self.scene_path = resolved.scene
        self.project_root = resolved.project_root
        self.findings = resolved.findings
        #: the source that the scene was imported from, and what the import card says of it
        self.imported_from = resolved.imported_from
        self.news: Any = None
        self.runtime = runtime
        self.tables = tables_of(runtime)
        self.history = History(self._write)
        self.selection: tuple[int, ...] = ()
        self._selected: tuple[tuple[int, ...], frozenset[int]] = ((), frozenset())
        self.name = resolved.project_name or resolved.source.name
        #: (table, column, row) -> the value the user gave it: what saving adds to the scene as it was opened
        self.overrides: dict[tuple[str, str, int], Any] = {}
        #: the scene file's content as it was opened, where `scene_path` may have been saved over since
        self.base_path: Path | None = None
        #: node rows that a click in the viewport does not select
        self.locked: set[int] = set()
        #: the rows that showed before isolating, or None
        self.isolated: dict[int, bool] | None = None
        #: camera bookmarks by number
        self.bookmarks: dict[int, OrbitCamera] = of_asset(runtime.asset)
        self.tables[BOOKMARKS] = BookmarkTable(self.bookmarks)
        #: the script line of the operation that runs now, or '' (see editor.scripting)
        self.doing = ""
        #: where this document was saved in this session, or None
        self.saved_to: Path | None = None
        #: (table, column, file) of values that were saved into files of their own (see saving.note_saved)
        self.saved_values: set[tuple[str, str, str]] = set()
        #: the prefabs of its instances, as they were when they came (engine.assets.prefab.instance_nodes)
        self.prefabs: dict[Path, list[Any]] = {}
        self.prefab_stamps: dict[Path, tuple[Any, ...]] = {}
        #: errors that were told of already
        self.noted: set[str] = set()
        #: called after the scene under this document became another one (see commands.replacement)
        self.on_replaced: Callable[[], None] | None = None
        self._bounds: dict[tuple[int, ...], tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
        # mesh -> engine.app.posed_box.joint_boxes
        self._joint_boxes: dict[int, NDArray[np.float64]] = {}
        self._bounds_key: object = None
        self._children_cache: tuple[tuple[int, int], dict[int, list[int]]] | None = None

    @property
    def dirty(self) -> bool:
        return self.history.dirty

    @property
    def primary(self) -> int:
        """The row selected last, or -1."""
        return self.selection[-1] if self.selection else -1

    def edit(
        self,
        table: str,
        column: str,
        rows: Sequence[int],
        values: Sequence[Any],
        *,
        gesture: Hashable | None = None,
        label: str = "",
    ) -> None:
        """Set `column` of `rows` to `values` as one undoable command (see History for `gesture`)."""
        command = make_command(self.tables, table, column, rows, values, label)
        if not command.of_view:
            command = replace(command, said=(self._said(table, command.column, command.rows), ()))
        self.history.do(command, gesture)

    @property
    def selected(self) -> frozenset[int]:
        """The selection, to look rows up in."""
        if self._selected[0] is not self.selection:
            self._selected = self.selection, frozenset(self.selection)
        return self._selected[1]

    def select(self, row: int, *, toggle: bool = False) -> None:
        """Select `row` alone (-1: nothing), or with `toggle` add or take it away."""
        if toggle and row >= 0:
            rest = tuple(r for r in self.selection if r != row)
            self.selection = rest if row in self.selection else (*rest, row)
        else:
            self.selection = (row,) if row >= 0 else ()

    def subtree(self, row: int) -> list[int]:
        """`row` and all nodes below it, parents first, siblings in order."""
        children = self._children()
        found, queue = [], [row]
        while queue:
            node = queue.pop()
            found.append(node)
            queue.extend(reversed(children.get(node, ())))
        return found

    def bounds(self, rows: Sequence[int] = ()) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """World box (low, high) of the nodes `rows` with all below them; without rows, of everything visible.

        Nodes without a mesh count as points. Kept until something moves; above EXACT_LIMIT parts, of their spheres."""
        scene = self.runtime.scene
        key = (int(scene.structure_rev), int(scene.transform_rev), self.history.revision)
        if key != self._bounds_key:
            self._bounds_key = key
            self._bounds.clear()
        rows = tuple(rows)
        if rows not in self._bounds:
            self._bounds[rows] = self._find_bounds(rows)
        return self._bounds[rows]

    def _find_bounds(self, rows: tuple[int, ...]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        scene = self.runtime.scene
        nodes = sorted({n for row in rows for n in self.subtree(row)})
        points: list[NDArray[np.float64]] = []
        if rows:
            wanted = np.flatnonzero(np.isin(np.asarray(scene.instances.node), nodes))
        else:
            wanted = np.flatnonzero(scene.instances.drawn)
        if not rows and len(wanted) == 0:
            low, high = scene.bounds()
            return np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
        if len(wanted) > EXACT_LIMIT:
            center, radius = scene.instances.world_center[wanted], scene.instances.world_radius[wanted, None]
            return (center - radius).min(axis=0), (center + radius).max(axis=0)
        for instance in wanted:
            posed = self._posed_box(int(instance))
            if posed is not None:
                points.append(np.stack(posed))
                continue
            low, high = self._instance_box(int(instance))
            world = scene.nodes.world_matrix(int(scene.instances.node[instance]))
            points.append(box_corners(low, high) @ world[:3, :3].T + world[:3, 3])
        if not points:
            points = [np.asarray(scene.nodes.world_matrix(n)[:3, 3], dtype=np.float64)[None] for n in rows]
        corners = np.concatenate(points)
        return corners.min(axis=0), corners.max(axis=0)

    def close(self) -> None:
        """Close the runtime, and those that undo or redo would bring back."""
        for runtime in (self.runtime, *self.parked):
            runtime.close()

    @property
    def parked(self) -> list[Runtime]:
        """The runtimes that undo or redo would bring back, each once."""
        edits = (*self.history.entries, *self.history.undone)
        found = {id(r): r for edit in edits if isinstance(edit, Replacement) for r in edit.runtimes}
        found.pop(id(self.runtime), None)
        return list(found.values())

    def forget_bounds(self) -> None:
        """The scene is another one: nothing that was known of it holds."""
        self._bounds.clear()
        self._joint_boxes.clear()
        self._bounds_key = self._children_cache = None

    def _instance_box(self, instance: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        instances = self.runtime.scene.instances
        info = self.runtime.residency.meshes[int(instances.mesh[instance])]
        submesh = info.asset.submeshes[int(instances.submesh[instance])]
        return np.asarray(submesh.bounds_min, dtype=np.float64), np.asarray(submesh.bounds_max, dtype=np.float64)

    def _posed_box(self, instance: int) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """The world box of what a skin or morph targets bend; None for what is rigid."""
        from engine.app.posed import posed_positions
        from engine.app.posed_box import joint_boxes, posed_box

        scene = self.runtime.scene
        if not (len(getattr(scene, "skins", ())) or len(getattr(getattr(scene, "morphs", None), "node", ()))):
            return None
        mesh = int(scene.instances.mesh[instance])
        asset = self.runtime.residency.meshes[mesh].asset
        node = np.array([int(scene.instances.node[instance])])
        bent = int(scene.skins.of_nodes(node)[0]) >= 0 or bool(np.any(scene.morphs.of_node(int(node[0]))))
        if bent and asset.vertex_count <= EXACT_VERTICES:
            points = posed_positions(scene, self.runtime.residency, instance)
            return points.min(axis=0), points.max(axis=0)
        if mesh not in self._joint_boxes:
            self._joint_boxes[mesh] = joint_boxes(asset)
        return posed_box(scene, asset, self._joint_boxes[mesh], instance)

    @property
    def children(self) -> Mapping[int, list[int]]:
        """Row -> its live child rows in table order, without those that have none; -1: the roots."""
        return self._children()

    def _children(self) -> dict[int, list[int]]:
        scene = self.runtime.scene
        key = (int(scene.structure_rev), len(scene.nodes.name))
        if self._children_cache is None or self._children_cache[0] != key:
            children: dict[int, list[int]] = {}
            parents, alive = np.asarray(scene.nodes.parent), np.asarray(scene.nodes.alive)
            rows = np.flatnonzero(alive[: len(parents)])
            for row, parent in zip(rows.tolist(), parents[rows].tolist(), strict=True):
                children.setdefault(parent, []).append(row)
            self._children_cache = (key, children)
        return self._children_cache[1]

    def children_of(self, row: int) -> list[int]:
        """Live child rows of `row` (-1: the roots), in table order."""
        return self._children().get(row, [])

    def _said(self, table: str, column: str, rows: Sequence[int]) -> Said:
        """What the overrides hold of each row in the columns that `column` overlaps, the latest last."""
        columns = overlapping(table, column)
        own: dict[int, list[tuple[str, Any]]] = {row: [] for row in rows}
        if len(columns) * len(own) < len(self.overrides) and table != "nodes":  # no order to keep
            keys = ((table, name, row) for row in own for name in columns)
            found = ((key, self.overrides[key]) for key in keys if key in self.overrides)
        else:
            found = ((k, v) for k, v in self.overrides.items() if k[0] == table and k[1] in columns and k[2] in own)
        for key, value in found:
            own[key[2]].append((key[1], value))
        return tuple(tuple(own[row]) for row in rows)

    def _kept(self, table: str, column: str, row: int, value: Any) -> Any:
        """`value`, or what the table made of one that lights and cameras cannot have: what shows is what is saved."""
        if table not in ("lights", "cameras"):
            return value
        now = self.tables[table].read(column, (row,))[0]
        if isinstance(value, str | bool) or isinstance(now, str | bool):
            return now
        return value if np.array_equal(np.float32(value), np.float32(now)) else now  # tables of lights are float32

    def _write(self, edit: Edit) -> None:
        if isinstance(edit, (Replacement, FileStep)):
            edit.apply(self)
            return
        if isinstance(edit, StructureCommand):
            edit.apply(self)
            follow_drifts(self)
            getattr(self.runtime, "follow_structure", lambda: None)()
            return
        assert isinstance(edit, Command)
        try:
            self.tables[edit.table].write(edit.column, edit.rows, edit.after)
        except LucarnaError:  # the rows before the one that refused took it already
            self.tables[edit.table].write(edit.column, edit.rows, edit.before)
            raise
        if edit.of_view:
            return
        columns = edit.column.split(",")
        for row, value in zip(edit.rows, edit.after, strict=True):
            for column, part in zip(columns, value if len(columns) > 1 else (value,), strict=True):
                key = (edit.table, column, row)
                self.overrides.pop(key, None)  # the latest comes last: "local" and its parts overlap
                self.overrides[key] = self._kept(edit.table, column, row, part)
        for row, said in zip(edit.rows, edit.said[1], strict=False):
            for column in overlapping(edit.table, edit.column):
                self.overrides.pop((edit.table, column, row), None)
            self.overrides.update({(edit.table, column, row): value for column, value in said})
        if edit.table == "nodes":
            self.runtime.scene.update()


def overlapping(table: str, column: str) -> tuple[str, ...]:
    """The columns whose overrides an edit of `column` replaces or goes before."""
    return PLACE if table == "nodes" and column in PLACE else tuple(column.split(","))
