"""Structural edits: add, delete, duplicate, group, hang elsewhere. Each is one entry that restores every row exactly.

Each function changes the scene by its own means between two looks at its tables; what differs is the command.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.scene import CameraAsset, LightAsset
from engine.core.errors import InputError
from engine.math import transform
from engine.scene.patch import ScenePatch, difference, put, remember

if TYPE_CHECKING:
    from editor.document import Document

Overrides = Mapping[tuple[str, str, int], Any]


@dataclass(frozen=True, slots=True)
class StructureCommand:
    """`selection` and `overrides`: (before, after), since rows come and go with the nodes."""

    patch: ScenePatch
    selection: tuple[tuple[int, ...], tuple[int, ...]] = ((), ())
    overrides: tuple[Overrides, Overrides] = field(default=({}, {}))
    label: str = ""

    @property
    def target(self) -> tuple[str, str, tuple[int, ...]]:
        return "structure", "", ()

    @property
    def changes(self) -> bool:
        return self.patch.changes

    def inverse(self) -> StructureCommand:
        return StructureCommand(self.patch.inverse(), self.selection[::-1], self.overrides[::-1], self.label)

    def followed_by(self, later: Any) -> StructureCommand:
        raise AssertionError("structural edits are entries of their own")

    def describe(self) -> str:
        return self.label

    def apply(self, document: Document) -> None:
        """Bring the document to the state after this command."""
        put(document.runtime.scene, self.patch.after)
        document.overrides = dict(self.overrides[1])
        document.selection = self.selection[1]


def change(document: Document, label: str, make: Callable[[], Sequence[int]]) -> None:
    """Run `make`, which changes the scene and returns what to select, and record it as one entry.

    What `make` raises comes through, after the scene was put back."""
    scene = document.runtime.scene
    before, selected, overrides = remember(scene), document.selection, dict(document.overrides)
    try:
        after = tuple(int(r) for r in make())
    except InputError:
        put(scene, difference(scene, before).before)
        document.overrides = overrides
        raise
    patch = difference(scene, before)
    living = {name: getattr(scene, name).alive for name in ("nodes", "lights", "cameras")}
    kept = {k: v for k, v in document.overrides.items() if k[0] not in living or living[k[0]][k[2]]}
    document.history.do(StructureCommand(patch, (selected, after), (overrides, kept), label))


def tops(document: Document, rows: Sequence[int]) -> list[int]:
    """`rows` without those that lie below another of them, in their order."""
    parents, inside = document.runtime.scene.nodes.parent, set(rows)
    found = []
    for row in dict.fromkeys(rows):
        above = int(parents[row])
        while above >= 0 and above not in inside:
            above = int(parents[above])
        if above < 0:
            found.append(row)
    return found


def unique_name(document: Document, wanted: str) -> str:
    """`wanted`, or `wanted 2`, `wanted 3`… where a node has that name."""
    taken = set(document.runtime.scene.nodes.name)
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
        row = scene.nodes.add(unique_name(document, name), parent, matrix=local)
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

    A copy of a skinned mesh hangs on the same joints, and so moves with the original."""
    scene = document.runtime.scene

    def make() -> list[int]:
        made = []
        for top in tops(document, rows):
            copies: dict[int, int] = {}
            for old in document.subtree(top):
                parent = int(scene.nodes.parent[old])
                name = unique_name(document, scene.nodes.name[old]) if old == top else scene.nodes.name[old]
                copies[old] = _copy_node(scene, old, copies.get(parent, parent), name)
            made.append(copies[top])
        return made

    change(document, f"Duplicate {_what(document, rows)}", make)


def _copy_node(scene: Any, old: int, parent: int, name: str) -> int:
    nodes = scene.nodes
    new = int(nodes.add(name, parent, nodes.translation[old], nodes.rotation[old], nodes.scale[old]))
    if nodes.has_matrix[old]:
        nodes.set_matrix(new, nodes.local_matrix(old))
    nodes.set_visible([new], [bool(nodes.visible[old])])
    if old in scene.sources:
        scene.sources[new] = scene.sources[old]
    table = scene.instances
    rows = np.flatnonzero(table.alive & (table.node == old))
    if rows.size:
        table.add_many(
            np.full(len(rows), new), table.mesh[rows], table.submesh[rows], table.material[rows],
            table.bounds_center[rows], table.bounds_radius[rows], table.visible[rows],
        )  # fmt: skip
    for kind in (scene.lights, scene.cameras):
        for row in np.flatnonzero(kind.alive & (kind.node == old)):
            kind.add(new, kind.asset(int(row)))
    skins = scene.skins
    for skin in np.flatnonzero(skins.node == old):
        part = slice(int(skins.first[skin]), int(skins.first[skin] + skins.count[skin]))
        bind = np.concatenate(
            [skins.inverse_bind[part], np.broadcast_to([[0.0, 0.0, 0.0, 1.0]], (int(skins.count[skin]), 1, 4))], axis=1
        )
        skins.add(new, skins.joint[part], bind, skins.reach[part])
    return new


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
        new = int(scene.nodes.add(unique_name(document, "Group"), parent, matrix=local))
        scene.update()
        for row in members:
            _hang(document, row, new)
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
                _hang(document, row, parent)
        return list(rows)

    change(document, f"Move {_what(document, rows)} below {where}", make)


def _hang(document: Document, row: int, parent: int) -> None:
    nodes = document.runtime.scene.nodes
    world: NDArray[np.float64] = nodes.world_matrix(row)
    nodes.reparent(row, parent)
    above = nodes.world_matrix(parent) if parent >= 0 else np.eye(4)
    if abs(float(np.linalg.det(above[:3, :3]))) < 1e-30:
        raise InputError(f"{nodes.name[parent]!r} is scaled to nothing, so nothing can keep its place below it")
    nodes.set_matrix(row, transform.inverse_affine(above) @ world)
    for column in ("translation", "rotation", "scale", "local"):
        document.overrides.pop(("nodes", column, row), None)
    document.overrides["nodes", "local", row] = document.tables["nodes"].read("local", (row,))[0]


def _what(document: Document, rows: Sequence[int]) -> str:
    names = document.runtime.scene.nodes.name
    return (names[rows[0]] or f"node {rows[0]}") if len(rows) == 1 else f"{len(rows)} nodes"
