"""ScenePatch: how two states of a scene's tables differ, as rows. Undo writes one side back, redo the other.

    before = remember(scene)
    scene.remove(rows)                  # any structural change, by the scene's own means
    patch = difference(scene, before)   # only the rows that differ are kept
    put(scene, patch.before)            # exactly as it was: row numbers, generations, free rows, skins, sources

Row numbers of later changes stay right, since the list of free rows is part of a state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.scene import CameraAsset, LightAsset, MeshRef, NodeAsset
from engine.scene.scene import Scene
from engine.scene.table import RowValues, TableState

TABLES = ("nodes", "instances", "lights", "cameras")
SKIN_COLUMNS = {
    "node": "i8", "first": "i8", "count": "i8", "joint": "i8", "inverse_bind": "f8", "reach": "f8", "follow": "f8",
    "dual": "?",
}  # fmt: skip


@dataclass(slots=True)
class SceneState:
    """A copy of everything that a structural change may touch."""

    tables: dict[str, TableState]
    names: list[str]
    skins: dict[str, NDArray[Any]]
    sources: dict[int, NodeAsset]
    row_of_node: NDArray[np.int64]
    active_camera: int


@dataclass(frozen=True, slots=True)
class Side:
    """One side of a patch. `names`, `sources`: of the changed node rows; `skins` only where they changed."""

    tables: Mapping[str, RowValues]
    names: Mapping[int, str] = field(default_factory=dict)
    sources: Mapping[int, NodeAsset | None] = field(default_factory=dict)
    skins: Mapping[str, NDArray[Any]] | None = None
    row_of_node: NDArray[np.int64] | None = None
    active_camera: int = -1
    #: LightTable.profiles, which the lights' rows index; only ever longer
    profiles: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ScenePatch:
    before: Side
    after: Side

    def inverse(self) -> ScenePatch:
        return ScenePatch(self.after, self.before)

    @property
    def changes(self) -> bool:
        """Whether the two sides differ at all."""
        tables = any(len(rows.rows) or rows.free != self.before.tables[n].free for n, rows in self.after.tables.items())
        other = self.after.names != self.before.names or self.after.sources != self.before.sources
        return tables or other or self.after.skins is not None or self.after.active_camera != self.before.active_camera


def remember(scene: Scene) -> SceneState:
    """Return a copy of the tables. O(rows): some milliseconds for ten thousand nodes."""
    scene.update()  # so that what follows from other columns is up to date on both sides
    return SceneState(
        {name: getattr(scene, name).remember() for name in TABLES},
        list(scene.nodes.name),
        {name: getattr(scene.skins, name) for name in SKIN_COLUMNS},  # replaced as a whole, never written into
        dict(scene.sources),
        scene.row_of_node.copy(),
        scene.active_camera,
    )


def difference(scene: Scene, before: SceneState) -> ScenePatch:
    """Return what changed since `before` was remembered."""
    scene.update()
    olds: dict[str, RowValues] = {}
    news: dict[str, RowValues] = {}
    for name in TABLES:
        olds[name], news[name] = getattr(scene, name).difference(before.tables[name])
    named = _changed_names(before.names, scene.nodes.name)
    sourced = [
        row for row in sorted({*before.sources, *scene.sources})
        if before.sources.get(row) is not scene.sources.get(row)
    ]  # fmt: skip
    skins = {name: getattr(scene.skins, name) for name in SKIN_COLUMNS}
    same_skins = all(skins[name] is before.skins[name] for name in SKIN_COLUMNS)
    same_rows = np.array_equal(before.row_of_node, scene.row_of_node)
    return ScenePatch(
        Side(
            olds, {r: _name(before.names, r) for r in named}, {r: before.sources.get(r) for r in sourced},
            None if same_skins else before.skins, None if same_rows else before.row_of_node, before.active_camera,
            tuple(scene.lights.profiles),
        ),
        Side(
            news, {r: _name(scene.nodes.name, r) for r in named}, {r: scene.sources.get(r) for r in sourced},
            None if same_skins else skins, None if same_rows else scene.row_of_node.copy(), scene.active_camera,
            tuple(scene.lights.profiles),
        ),
    )  # fmt: skip


def put(scene: Scene, side: Side) -> None:
    """Bring the scene to that side of a patch; it must be at the other one, or at this one already."""
    scene.lights.profiles.extend(side.profiles[len(scene.lights.profiles) :])
    for name in TABLES:
        getattr(scene, name).put(side.tables[name])
    for row, text in side.names.items():
        if row < len(scene.nodes):
            scene.nodes.name[row] = text
    for row, source in side.sources.items():
        if source is None:
            scene.sources.pop(row, None)
        else:
            scene.sources[row] = source
    if side.skins is not None:
        for name, values in side.skins.items():
            setattr(scene.skins, name, values)
        scene.skins.structure_rev += 1
    if side.row_of_node is not None:
        scene.row_of_node[:] = side.row_of_node  # in place: others hold this array
    scene.active_camera = side.active_camera
    scene.update()


# -- as plain values, for a journal -----------------------------------------------------------------------------------


def side_to_plain(side: Side) -> dict[str, Any]:
    """Return `side` as JSON-able values; floats keep every bit."""
    return {
        "tables": {
            name: {
                "count": rows.count, "free": list(rows.free), "rows": rows.rows.tolist(),
                "columns": {column: values.tolist() for column, values in rows.columns.items()},
            }
            for name, rows in side.tables.items()
        },
        "names": [[row, name] for row, name in side.names.items()],
        "sources": [[row, None if node is None else asdict(node)] for row, node in side.sources.items()],
        "skins": None if side.skins is None else {name: values.tolist() for name, values in side.skins.items()},
        "row_of_node": None if side.row_of_node is None else side.row_of_node.tolist(),
        "active_camera": side.active_camera,
        "profiles": list(side.profiles),
    }  # fmt: skip


def side_from_plain(data: Mapping[str, Any], scene: Scene) -> Side:
    """Return the side that `side_to_plain` wrote; `scene` tells the columns' types. Raises KeyError, TypeError or
    ValueError for what it never wrote."""
    tables = {}
    for name in TABLES:
        rows, table = data["tables"][name], getattr(scene, name)
        tables[name] = RowValues(
            int(rows["count"]), tuple(int(r) for r in rows["free"]), np.array(rows["rows"], np.int64),
            {c: table.typed(c, v) for c, v in rows["columns"].items()},
        )  # fmt: skip
    skins = data["skins"]
    if skins is not None:
        skins = {n: np.array(skins[n], kind) for n, kind in SKIN_COLUMNS.items()}
        skins["inverse_bind"] = skins["inverse_bind"].reshape(-1, 3, 4)
    rows_of = data["row_of_node"]
    return Side(
        tables,
        {int(row): str(name) for row, name in data["names"]},
        {int(row): None if node is None else node_from_plain(node) for row, node in data["sources"]},
        skins,
        None if rows_of is None else np.array(rows_of, np.int64),
        int(data["active_camera"]),
        tuple(str(path) for path in data.get("profiles", ())),
    )


def node_from_plain(data: Mapping[str, Any]) -> NodeAsset:
    """The node that `dataclasses.asdict` made `data` of, and JSON passed on."""
    values = dict(data)
    for key, kind in (("mesh", MeshRef), ("camera", CameraAsset), ("light", LightAsset)):
        if values[key] is not None:
            values[key] = kind(**values[key])
    if values["mesh"] is not None:
        said = values["mesh"].overrides
        values["mesh"].overrides = [{k: tuple(v) if isinstance(v, list) else v for k, v in s.items()} for s in said]
    if values["light"] is not None:
        values["light"].color = tuple(values["light"].color)
    for key in ("translation", "rotation", "scale"):
        values[key] = tuple(values[key])
    if values["matrix"] is not None:
        values["matrix"] = tuple(values["matrix"])
    return NodeAsset(**values)


def _changed_names(old: list[str], new: list[str]) -> list[int]:
    return [row for row in range(max(len(old), len(new))) if _name(old, row) != _name(new, row)]


def _name(names: list[str], row: int) -> str:
    return names[row] if row < len(names) else ""
