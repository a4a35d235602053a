"""Prefabs in the editor: made of a selection, placed, shown for what they have of their own. Each is one undoable
entry; reverting, applying and following changes is prefab_updates.py. No imgui."""

from __future__ import annotations

import filecmp
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from editor import saving
from editor.commands import structure
from engine.assets.prefab import (
    NODE,
    ROOT,
    file_of,
    instance_nodes,
    keys_of,
    load_prefab,
    map_files,
    members,
)
from engine.assets.scene import NodeAsset, SceneAsset
from engine.assets.scene_json import write_scene
from engine.core.errors import InputError, LucarnaError
from engine.core.paths import user_cache_dir
from engine.math import transform
from engine.scene.convert import parents_first

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session

SUFFIX = ".scene.json"


# --- looking ---


def root_of(document: Document, row: int) -> int:
    """The row of the instance that node `row` is, or lies in; -1 where it is none."""
    scene = document.runtime.scene
    found = -1
    while row >= 0:
        source = scene.sources.get(row)
        if source is not None and file_of(source) and NODE not in source.extras:
            found = row
        row = int(scene.nodes.parent[row])
    return found


def path_of(document: Document, row: int) -> Path | None:
    """The prefab of the instance at `row`."""
    source = document.runtime.scene.sources.get(row)
    if source is None or not file_of(source):
        return None
    return (document.scene_path.parent / file_of(source)).resolve()


def index_of(document: Document, row: int) -> int:
    """Where `row` is among the nodes of the edited scene."""
    scene = document.runtime.scene
    if saving.is_restructured(scene, document.runtime.asset):
        return parents_first(scene).index(row)
    return int(np.flatnonzero(scene.row_of_node == row)[0])


def is_instance(session: Session) -> bool:
    document = session.document
    return document is not None and document.primary >= 0 and root_of(document, document.primary) >= 0


# --- placing and making ---


def place(session: Session, path: Path, matrix: ArrayLike | None = None) -> bool:
    """Put an instance of the scene file `path` at world_from_local `matrix` (None: where the camera looks); a source is
    converted into the project first. False where it was refused."""
    document = session.document
    if document is None:
        return False
    try:
        path = _as_scene(session, document, path.absolute())
        _refuse_circle(document, path)
        nodes = instance_nodes(path, document.scene_path.parent)
        if matrix is None:
            matrix = np.eye(4)
            matrix[:3, 3] = session.camera.target
        folder = document.scene_path.parent
        meshes = dict.fromkeys(n.mesh.file for n in nodes if n.mesh is not None)
        materials = dict.fromkeys(m for n in nodes if n.mesh is not None for m in n.mesh.materials if m)
        loads = [(folder / f).resolve() for f in (*meshes, *materials)]
        with session.device_frame():
            structure.load(document, [str(f) for f in loads])
        rows = _add(document, nodes, path, np.asarray(matrix, np.float64), loads)
    except LucarnaError as error:
        session.fail(error)
        return False
    document.selection = rows
    _let_play(session)
    session.ui.notice = f"Placed {path.name}"
    return True


def _let_play(session: Session) -> None:
    """Where the first thing that moves has come: let it, as what is opened does."""
    from editor.animating import following

    still = not session.playback.available
    following.follow(session)
    if still and session.playback.available:
        session.playback.playing = not session.software


def _add(
    document: Document, nodes: list[NodeAsset], path: Path, matrix: np.ndarray[Any, Any], loads: Sequence[Path]
) -> tuple[int, ...]:
    scene, folder = document.runtime.scene, document.scene_path.parent
    name = structure.unique_name(nodes[0].name, set(scene.nodes.name))
    nodes = [replace(nodes[0], name=name), *nodes[1:]]

    def make() -> list[int]:
        rows = document.runtime.add_nodes(nodes, folder)
        scene.nodes.set_matrix(int(rows[0]), matrix)
        return [int(rows[0])]

    document.prefabs[path] = instance_nodes(path, folder)
    structure.change(document, f"Place {name}", make, loads)
    return document.selection


def _as_scene(session: Session, document: Document, path: Path) -> Path:
    """The scene file of `path`; a source is converted into `prefabs/` of the project, or beside the scene."""
    if path.name.lower().endswith(SUFFIX):
        return path
    from importers.convert import convert
    from importers.naming import safe_name
    from importers.presets import resolve

    out = _folder(document) / "prefabs" / safe_name(path.stem)
    result = convert(path, out, resolve(path).settings)
    session.messages.findings(result.findings)
    assert result.scene is not None
    return result.scene


def _folder(document: Document) -> Path:
    """Where prefabs of the document belong: in its project, else beside what was opened."""
    if document.project_root is not None:
        return document.project_root
    from importers.project.references import project_root

    return project_root(document.saved_to or document.source)


def _refuse_circle(document: Document, path: Path) -> None:
    """Raise InputError where the document's own scene would come to stand in itself."""
    own = {p.resolve() for p in (document.scene_path, document.saved_to, document.source) if p is not None}
    if path.resolve() in own:
        raise InputError("a scene cannot stand in itself", where=path, hint="place another one, or duplicate the nodes")
    for each in own:
        load_prefab(path, (each,))


def make(session: Session, target: Path | None = None) -> bool:
    """Write the selection as a prefab of its own, and put an instance in its place. Undo brings the nodes back; the
    file stays."""
    document = session.document
    if document is None or not document.selection:
        return False
    heads = structure.tops(document, document.selection)
    name = str(document.runtime.scene.nodes.name[heads[0]]) if len(heads) == 1 else "Group"
    try:
        from importers.naming import safe_name

        if any(root_of(document, row) >= 0 and root_of(document, row) != row for row in heads):
            raise InputError("a part of an instance is selected", hint="select the whole instance, or apply it first")
        target = (target or _free(_folder(document) / "prefabs" / f"{safe_name(name)}{SUFFIX}")).absolute()
        if not target.name.endswith(SUFFIX):
            raise InputError("a prefab's name ends with .scene.json", where=target)
        if target.exists():
            raise InputError("there is a file of this name already", where=target, hint="choose another name")
        before = len(document.history.entries)
        structure.change(document, f"Make the prefab {name}", lambda: [_wrap(document, heads, name, target)])
        try:
            _write(document, document.selection[0], target)
        except LucarnaError:
            document.history.go_to(before)
            raise
    except LucarnaError as error:
        session.fail(error)
        return False
    document.prefabs[target] = instance_nodes(target, document.scene_path.parent)
    session.ui.notice = f"{target.name} is a prefab now"
    session.messages.info(f"Made the prefab {target.name}", where=str(target))
    return True


def _free(path: Path, ending: str = SUFFIX) -> Path:
    stem, number = path.name.removesuffix(ending), 1
    while path.exists():
        number += 1
        path = path.with_name(f"{stem} {number}{ending}")
    return path


def _wrap(document: Document, heads: Sequence[int], name: str, target: Path) -> int:
    """Hang `heads` below a new node that is the instance, and mark what is in it. For use within structure.change."""
    scene = document.runtime.scene
    nodes = scene.nodes
    parent = int(nodes.parent[heads[0]])
    world = np.eye(4)
    if len(heads) == 1:  # its size and skew stay its own: an instance elsewhere is as large
        place, turn, size = transform.decompose(nodes.world_matrix(heads[0]))
        world = transform.compose(place, turn, np.ones(3))
    else:
        world[:3, 3] = np.mean([nodes.world_matrix(r)[:3, 3] for r in heads], axis=0)
    above = nodes.world_matrix(parent) if parent >= 0 else np.eye(4)
    local = transform.inverse_affine(above) @ world
    root = int(nodes.add(structure.unique_name(name, set(nodes.name)), parent, matrix=local))
    scene.update()
    for row in heads:
        structure.hang(document, row, root)
    if len(heads) == 1 and not nodes.has_matrix[heads[0]]:  # exactly so, and not but for rounding
        nodes.set_trs(heads[0], np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), size)
        document.overrides["nodes", "local", heads[0]] = document.tables["nodes"].read("local", (heads[0],))[0]
    rows = [r for r in document.subtree(root) if r != root]
    number = {row: i for i, row in enumerate(rows)}
    plain = [NodeAsset(str(nodes.name[r]), number.get(int(nodes.parent[r]), -1)) for r in rows]
    for row, key in zip(rows, keys_of(plain), strict=True):
        source = scene.sources.get(row) or NodeAsset(str(nodes.name[row]))
        scene.sources[row] = replace(source, extras={**source.extras, NODE: key})
    said = {"file": saving.relative(target, document.scene_path.parent), "changed": {}, "removed": []}
    scene.sources[root] = NodeAsset(name, extras={ROOT: said})
    return root


def _write(document: Document, root: int, target: Path) -> None:
    """Write what the instance at row `root` holds as the prefab `target`, with what it needs where that lies in the
    cache, which may be emptied."""
    asset = saving.current_scene(document)
    index = index_of(document, root)
    inside = members(asset, index)
    folder = document.scene_path.resolve().parent
    part = SceneAsset(target.name.removesuffix(SUFFIX), _cut(asset, index, inside))
    target.parent.mkdir(parents=True, exist_ok=True)
    place = folder
    if folder.is_relative_to(user_cache_dir().resolve()):
        place = _place_of_copies(part, folder, target)
        saving.copy_references(part, folder, place)

    def seen(text: str) -> str:
        if not text or Path(text).is_absolute():
            return text
        found = place / text if (place / text).is_file() else folder / text
        return saving.relative(Path(os.path.normpath(found)), target.parent)

    part.nodes = [map_files(n, seen) for n in part.nodes]
    write_scene(target, part)


def _place_of_copies(part: SceneAsset, folder: Path, target: Path) -> Path:
    """Where what `part` needs of `folder` is copied to: beside the prefab; where other files of those names are there,
    which other prefabs may need, into a folder of its own."""
    for name in saving.references(part, folder):
        here, there = folder / name, target.parent / name
        if here.is_file() and there.is_file() and not filecmp.cmp(here, there, shallow=False):
            return _free(target.with_name(f"{target.name.removesuffix(SUFFIX)} files"), "")
    return target.parent


def _cut(asset: SceneAsset, root: int, inside: Sequence[int]) -> list[NodeAsset]:
    """The nodes `inside`, on their own: those that hung below `root` are tops."""
    number = {old: new for new, old in enumerate(inside)}
    nodes = []
    for old in inside:
        node = asset.nodes[old]
        extras = {k: v for k, v in node.extras.items() if k != NODE}
        joints = [number[j] for j in node.joints] if all(j in number for j in node.joints) else []
        parent = number.get(node.parent, -1) if node.parent != root else -1
        nodes.append(replace(node, parent=parent, joints=joints, extras=extras, clip_node=None, placed=False))
    return nodes
