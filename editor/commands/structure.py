"""Structural edits: add, delete, duplicate, group, hang elsewhere. Each is one entry that restores every row exactly.

Each function changes the scene by its own means between two looks at its tables; what differs is the command.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation.pose import BIND_WORLD
from engine.assets.clip_nodes import clip_number
from engine.assets.scene import CameraAsset, LightAsset
from engine.core.errors import InputError
from engine.math import transform
from engine.scene.patch import ScenePatch, difference, put, remember

if TYPE_CHECKING:
    from editor.document import Document

#: columns of a node: each says something of the same place, and the latest counts
PLACE = ("translation", "rotation", "scale", "local")

Overrides = Mapping[tuple[str, str, int], Any]


@dataclass(frozen=True, slots=True)
class StructureCommand:
    """`selection` and `overrides`: (before, after), since rows come and go with the nodes."""

    patch: ScenePatch
    selection: tuple[tuple[int, ...], tuple[int, ...]] = ((), ())
    overrides: tuple[Overrides, Overrides] = field(default=({}, {}))
    label: str = ""
    #: the line of a script that makes this change (see editor.scripting), or ''
    line: str = ""
    #: meshes and materials that had to be loaded for it, in that order
    loads: tuple[str, ...] = ()

    @property
    def target(self) -> tuple[str, str, tuple[int, ...]]:
        return "structure", "", ()

    @property
    def changes(self) -> bool:
        return self.patch.changes

    @property
    def of_view(self) -> bool:
        return False

    def inverse(self) -> StructureCommand:
        back = self.patch.inverse(), self.selection[::-1], self.overrides[::-1]
        return StructureCommand(*back, self.label, self.line, self.loads)

    def followed_by(self, later: Any) -> StructureCommand:
        raise AssertionError("structural edits are entries of their own")

    def describe(self) -> str:
        return self.label

    def apply(self, document: Document) -> None:
        """Bring the document to the state after this command."""
        scene = document.runtime.scene
        with _rested(document):
            put(scene, self.patch.after)
            _follow(document)
        objects = getattr(document.runtime, "objects", None)
        if objects is not None:
            rows = self.patch.after.tables["instances"].rows
            nodes = scene.instances.node[rows[rows < len(scene.instances)]].tolist()
            objects.agree(sorted({*nodes, *self.patch.after.sources}))
        document.overrides = dict(self.overrides[1])
        document.selection = self.selection[1]


def change(document: Document, label: str, make: Callable[[], Sequence[int]], loads: Sequence[Path] = ()) -> None:
    """Run `make`, which changes the scene and returns what to select, and record it as one entry. `loads`: the files
    of meshes and materials that it needs.

    What `make` raises comes through, after the scene was put back."""
    scene = document.runtime.scene
    with _rested(document):
        before, selected, overrides = remember(scene), document.selection, dict(document.overrides)
    try:
        after = tuple(int(r) for r in make())
    except InputError:
        with _rested(document):
            put(scene, difference(scene, before).before)
        document.overrides = overrides
        raise
    with _rested(document):
        patch = difference(scene, before)
    living = {name: getattr(scene, name).alive for name in ("nodes", "lights", "cameras")}
    living["drifts"] = living["nodes"]
    kept = {k: v for k, v in document.overrides.items() if k[0] not in living or living[k[0]][k[2]]}
    sides = (selected, after), (overrides, kept)
    files = tuple(str(path) for path in loads)
    document.history.do(StructureCommand(patch, *sides, label, document.doing, files))


def _follow(document: Document) -> None:
    follow = getattr(document.runtime, "follow_structure", None)
    if follow is not None:
        follow()


@contextmanager
def _rested(document: Document) -> Iterator[None]:
    """Copies with places of their own stand there, wherever time stands: it is another when this is undone."""
    _follow(document)
    places = document.runtime.scene.places
    with places.rested() if places is not None else nullcontext():
        yield


def load(document: Document, files: Sequence[str]) -> None:
    """Load meshes and materials before anything refers to their numbers. Raises InputError."""
    residency = document.runtime.residency
    for file in files:
        if file.endswith(".lmesh"):
            residency.load_mesh_file(Path(file))
        else:
            residency.load_materials([Path(file)])


def tops(document: Document, rows: Sequence[int]) -> list[int]:
    """`rows` without those that lie below another of them, in their order."""
    parents, inside = document.runtime.scene.nodes.parent.tolist(), set(rows)
    found = []
    for row in dict.fromkeys(rows):
        above = parents[row]
        while above >= 0 and above not in inside:
            above = parents[above]
        if above < 0:
            found.append(row)
    return found


def unique_name(wanted: str, taken: Collection[str]) -> str:
    """`wanted`, or `wanted 2`, `wanted 3`… where that name is taken."""
    stem, _, number = wanted.rpartition(" ")
    stem, count = (stem, int(number)) if stem and number.isdigit() else (wanted, 1)
    name = wanted
    while name in taken:
        count += 1
        name = f"{stem} {count}"
    return name


def add_empty(document: Document, matrix: ArrayLike, parent: int = -1) -> None:
    """A node that carries nothing, at world_from_local `matrix` f8[4,4], selected."""
    _add(document, "Empty", matrix, parent, None, None)


def add_light(document: Document, matrix: ArrayLike, light: LightAsset, parent: int = -1) -> None:
    """A light that shines along its node's -Z."""
    _add(document, f"{light.type.capitalize()} light", matrix, parent, light, None)


def add_camera(document: Document, matrix: ArrayLike, camera: CameraAsset, parent: int = -1) -> None:
    _add(document, "Camera", matrix, parent, None, camera)


def _add(
    document: Document, name: str, matrix: ArrayLike, parent: int, light: LightAsset | None, camera: CameraAsset | None
) -> None:
    scene = document.runtime.scene

    def make() -> list[int]:
        local = np.asarray(matrix, np.float64)
        if parent >= 0:
            local = transform.inverse_affine(scene.nodes.world_matrix(parent)) @ local
        row = scene.nodes.add(unique_name(name, set(scene.nodes.name)), parent, matrix=local)
        if light is not None:
            scene.lights.add(row, light)
        if camera is not None:
            scene.cameras.add(row, camera)
        return [row]

    change(document, f"Add {name.lower()}", make)


def delete(document: Document, rows: Sequence[int]) -> None:
    """Remove nodes with everything below and on them."""
    what = _what(document, rows)

    def make() -> list[int]:
        document.runtime.scene.remove(tops(document, rows))
        return []

    change(document, f"Delete {what}", make)


def duplicate(document: Document, rows: Sequence[int]) -> None:
    """Copy nodes with everything below and on them, beside the originals, and select the copies.

    A copy of a skinned mesh hangs on the copies of those joints that are copied too, else on the same ones: then it is
    posed with the original, and stands off from it by as much as it is moved. Whatever clips move below `rows` they
    move in the copies too, and the copies of `rows` themselves about the places where they are put."""
    what = _what(document, rows)
    change(document, f"Duplicate {what}", lambda: copy_nodes(document, tops(document, rows)))


def copy_nodes(document: Document, heads: Sequence[int]) -> list[int]:
    """Copy `heads`, none of them below another, with everything below and on them; returns the copies' rows.

    Changes the scene without a trace in the history: for use within `change`."""
    scene = document.runtime.scene
    nodes = scene.nodes
    olds = [old for top in heads for old in document.subtree(top)]
    index = {old: i for i, old in enumerate(olds)}
    head, taken = set(heads), set(nodes.name)
    names, outside, inside = [], [], []
    for old in olds:
        parent = int(nodes.parent[old])
        name = nodes.name[old]
        if old in head:
            name = unique_name(name, taken)
            taken.add(name)
        names.append(name)
        inside.append(-1 if old in head else index[parent])
        outside.append(parent if old in head else -1)
    news = nodes.add_many(
        names, outside, nodes.translation[olds], nodes.rotation[olds], nodes.scale[olds], batch_parents=inside
    )
    nodes.set_visible(news, nodes.visible[olds])
    _copy_contents(scene, np.array(olds), news)
    _follow_clips(scene, olds, news.tolist(), head)
    new_of = dict(zip(olds, news.tolist(), strict=True))
    for (table, column, row), value in list(document.overrides.items()):
        if table == "nodes" and column in PLACE and row in new_of and row not in head:
            document.overrides[table, column, new_of[row]] = value  # posed by clips, it rests there
    return [int(news[index[top]]) for top in heads]


def _follow_clips(scene: Any, olds: Sequence[int], news: Sequence[int], heads: Collection[int]) -> None:
    """Let clips move the nodes `news` as they move `olds`; copies of `heads` about places of their own."""
    index_of = {row: i for i, row in enumerate(scene.row_of_node.tolist()) if row >= 0}
    for old, new in zip(olds, news, strict=True):
        source = scene.sources.get(old)
        number = index_of.get(old, -1) if source is None else clip_number(source, index_of.get(old, -1))
        if number >= 0 and source is not None:
            placed = source.placed or old in heads
            scene.sources[new] = replace(scene.sources.get(new, source), clip_node=number, placed=placed)


def _copy_contents(scene: Any, olds: NDArray[np.int64], news: NDArray[np.int64]) -> None:
    """Give the nodes `news` what `olds` carry: matrices, meshes, lights, cameras, skins."""
    nodes, table, skins = scene.nodes, scene.instances, scene.skins
    new_of = np.full(len(nodes) + 1, -1, np.int64)  # its last entry is for "no node"
    new_of[olds] = news
    for old in olds[nodes.has_matrix[olds]].tolist():
        nodes.set_matrix(int(new_of[old]), nodes.local_matrix(old))
    for old in olds.tolist():
        if old in scene.sources:
            scene.sources[int(new_of[old])] = scene.sources[old]
    rows = np.flatnonzero(table.alive & (new_of[table.node] >= 0))
    if rows.size:
        table.add_many(
            new_of[table.node[rows]], table.mesh[rows], table.submesh[rows], table.material[rows],
            table.bounds_center[rows], table.bounds_radius[rows], table.visible[rows],
        )  # fmt: skip
    for row in scene.morphs.living[new_of[scene.morphs.node[scene.morphs.living]] >= 0].tolist():
        part = slice(int(scene.morphs.first[row]), int(scene.morphs.first[row] + scene.morphs.count[row]))
        names, reach = scene.morphs.names[row], scene.morphs.reach[part].copy()
        scene.morphs.add(int(new_of[scene.morphs.node[row]]), names, reach, scene.morphs.weights[part].copy())
    for kind in (scene.lights, scene.cameras):
        for row in np.flatnonzero(kind.alive & (new_of[kind.node] >= 0)).tolist():
            kind.add(int(new_of[kind.node[row]]), kind.asset(row))
    for skin in np.flatnonzero(new_of[skins.node] >= 0).tolist():
        part = slice(int(skins.first[skin]), int(skins.first[skin] + skins.count[skin]))
        count = int(skins.count[skin])
        bind = np.concatenate(
            [skins.inverse_bind[part], np.broadcast_to([[0.0, 0.0, 0.0, 1.0]], (count, 1, 4))], axis=1
        )
        joints = np.where(new_of[skins.joint[part]] >= 0, new_of[skins.joint[part]], skins.joint[part])
        follow = skins.follow[skin]
        bound = None if np.isnan(follow[0, 0]) else np.linalg.inv(follow)
        if bound is None and (new_of[skins.joint[part]] < 0).all():
            bound = _stand_off(scene, int(skins.node[skin]), int(new_of[skins.node[skin]]))
        made = skins.add(int(new_of[skins.node[skin]]), joints, bind, skins.reach[part], bound)
        skins.set_method(made, skins.method(skin))


def _stand_off(scene: Any, old: int, new: int) -> NDArray[np.float64]:
    """Let the skinned mesh of `new`, which has no joints of its own, also move as its node does from where it is now.
    Returns the node's place."""
    bound: NDArray[np.float64] = scene.nodes.world_matrix(old)
    source = scene.sources.get(new)
    if source is not None:
        extras = {**source.extras, BIND_WORLD: bound.T.reshape(16).tolist()}
        scene.sources[new] = replace(source, extras=extras)
    return bound


def group(document: Document, rows: Sequence[int]) -> None:
    """Hang nodes below a new one in their middle, where the last of them hung; nothing moves in the world."""
    scene = document.runtime.scene

    def make() -> list[int]:
        members = tops(document, rows)
        parent = int(scene.nodes.parent[members[-1]])
        while parent in members:
            parent = int(scene.nodes.parent[parent])
        middle = np.eye(4)
        middle[:3, 3] = np.mean([scene.nodes.world_matrix(r)[:3, 3] for r in members], axis=0)
        above = np.eye(4) if parent < 0 else scene.nodes.world_matrix(parent)
        local = transform.inverse_affine(above) @ middle
        new = int(scene.nodes.add(unique_name("Group", set(scene.nodes.name)), parent, matrix=local))
        scene.update()
        for row in members:
            hang(document, row, new)
        return [new]

    change(document, f"Group {_what(document, rows)}", make)


def reparent(document: Document, rows: Sequence[int], parent: int) -> None:
    """Hang nodes below `parent` (-1: make them roots); they stay where they are in the world.

    Raises InputError, and changes nothing, when `parent` is one of them or below one."""
    nodes = document.runtime.scene.nodes
    where = nodes.name[parent] if parent >= 0 else "the top"

    def make() -> list[int]:
        for row in tops(document, rows):
            if int(nodes.parent[row]) != parent:
                hang(document, row, parent)
        return list(rows)

    change(document, f"Move {_what(document, rows)} below {where}", make)


def hang(document: Document, row: int, parent: int) -> None:
    """Hang one node below another where it is. For use within `change`. Raises InputError for a loop."""
    nodes = document.runtime.scene.nodes
    world: NDArray[np.float64] = nodes.world_matrix(row)
    nodes.reparent(row, parent)
    above = nodes.world_matrix(parent) if parent >= 0 else np.eye(4)
    if abs(float(np.linalg.det(above[:3, :3]))) < 1e-30:
        raise InputError(f"{nodes.name[parent]!r} is scaled to nothing, so nothing can keep its place below it")
    nodes.set_matrix(row, transform.inverse_affine(above) @ world)
    for column in PLACE:
        document.overrides.pop(("nodes", column, row), None)
    table: Any = document.tables["nodes"]
    document.overrides["nodes", "local", row] = table.own("local", (row,), table.read("local", (row,)))[0]


def _what(document: Document, rows: Sequence[int]) -> str:
    names = document.runtime.scene.nodes.name
    return (names[rows[0]] or f"node {rows[0]}") if len(rows) == 1 else f"{len(rows)} nodes"
