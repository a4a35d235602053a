"""Prefabs: a scene file that stands in other scenes, as often as wanted, and changes there when it changes.

A scene holds an instance as nodes of its own, so that whoever cannot find the prefab, or knows nothing of prefabs,
still sees what was there last. What they are is in their extras:

    {"prefab": {"file": "tree.scene.json", "changed": {"trunk": ["place"]}, "removed": ["nest"]}}   of the instance
    {"prefab_node": "trunk/leaf"}                                                      of each node below it from there

`refresh` brings all instances of a scene up to date with their files, but for what is `changed` or `removed` here: the
fields of FIELDS. Nodes that were put below an instance stay. A prefab may hold instances of others; a circle is an
error.
"""

from __future__ import annotations

import copy
import math
import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

from engine.assets.scene import NodeAsset, SceneAsset
from engine.assets.scene_json import read_scene
from engine.core.errors import InputError
from engine.core.findings import Findings

ROOT, NODE = "prefab", "prefab_node"
#: what an instance may have of its own, and the fields of a node that it is
FIELDS: dict[str, tuple[str, ...]] = {
    "name": ("name",), "place": ("translation", "rotation", "scale", "matrix"), "visible": ("visible",),
    "mesh": ("mesh",), "light": ("light",), "camera": ("camera",), "weights": ("weights",),
}  # fmt: skip


_everything = attrgetter(*(name for names in FIELDS.values() for name in names))


def has_instances(asset: SceneAsset) -> bool:
    return any(ROOT in node.extras for node in asset.nodes)


def file_of(node: NodeAsset) -> str:
    """The prefab that the node is an instance of, relative to the scene; '' for any other node."""
    said = node.extras.get(ROOT)
    return str(said.get("file", "")) if isinstance(said, dict) else ""


def load_prefab(path: Path, stack: Sequence[Path] = ()) -> SceneAsset:
    """The prefab at `path`, its own instances up to date. Raises InputError for a circle and what cannot be read."""
    path = Path(os.path.normpath(path.absolute()))
    if path in stack:
        chain = " -> ".join(p.name for p in (*stack[stack.index(path) :], path))
        raise InputError(f"the prefab holds itself: {chain}", where=path, hint="take one of the instances out")
    return refresh(read_scene(path), path.parent, Findings(str(path)), (*stack, path), strict=True)


def instance_nodes(path: Path, folder: Path, *, stack: Sequence[Path] = ()) -> list[NodeAsset]:
    """The nodes of a new instance of `path` for a scene in `folder`: the instance first, then what it holds."""
    asset = load_prefab(path, stack)
    file = _relative(path, folder)
    root = NodeAsset(path.name.removesuffix(".scene.json"), extras={ROOT: {"file": file, "changed": {}, "removed": []}})
    nodes = [root]
    for key, node in zip(keys_of(asset.nodes), asset.nodes, strict=True):
        made = _rebased(node, path.parent, folder)
        made.extras = {**made.extras, NODE: key}
        nodes.append(replace(made, parent=node.parent + 1, joints=[j + 1 for j in node.joints], clip_node=-1))
    return nodes


def keys_of(nodes: Sequence[NodeAsset]) -> list[str]:
    """Each node's path of names, the second of a name among siblings as `name#2`."""
    keys: list[str] = []
    seen: Counter[str] = Counter()
    for node in nodes:
        above = f"{keys[node.parent]}/" if node.parent >= 0 else ""
        key = above + node.name.replace("/", "_")
        seen[key] += 1
        keys.append(key if seen[key] == 1 else f"{key}#{seen[key]}")
    return keys


def refresh(
    asset: SceneAsset, folder: Path, findings: Findings, stack: Sequence[Path] = (), *, strict: bool = False
) -> SceneAsset:
    """`asset` with its instances as their prefabs are now; itself where it has none.

    A prefab that cannot be read leaves its instance as it was, with a finding; with `strict` it is an InputError."""
    if not has_instances(asset):
        return asset
    result = replace(asset, nodes=[copy.copy(n) for n in asset.nodes])
    for index, node in enumerate(asset.nodes):
        if not file_of(node) or NODE in node.extras:  # that of another prefab came with it
            continue
        path = Path(os.path.normpath((folder / file_of(node)).absolute()))
        try:
            fresh = instance_nodes(path, folder, stack=stack)
        except InputError as error:
            if strict:
                raise
            findings.error(
                "prefab.unreadable", str(error), f"nodes[{index}]", "the instance is shown as it was when it was saved"
            )
            continue
        _bring_up(result, index, fresh, findings)
    return _ordered(result)


def changed_fields(asset: SceneAsset, root: int, prefab: Sequence[NodeAsset]) -> tuple[dict[str, list[str]], list[str]]:
    """What the instance at node `root` has of its own against `prefab` (of instance_nodes): (changed, removed)."""
    mine = {str(asset.nodes[i].extras[NODE]): asset.nodes[i] for i in members(asset, root)}
    changed: dict[str, list[str]] = {}
    removed = []
    for node in prefab[1:]:
        key = str(node.extras[NODE])
        if key not in mine:
            removed.append(key)
            continue
        own = own_fields(mine[key], node)
        if own:
            changed[key] = own
    return changed, removed


def own_fields(node: NodeAsset, prefab: NodeAsset) -> list[str]:
    """The FIELDS in which `node` is other than its prefab has it, but for what tables round: turns are kept at unit
    length, lights in float32."""
    if _everything(node) == _everything(prefab):  # most are
        return []
    return [
        field for field, names in FIELDS.items() if any(differ(getattr(node, n), getattr(prefab, n)) for n in names)
    ]


def differ(a: Any, b: Any) -> bool:
    """Whether two values of a node do, by more than rounding."""
    if a == b:
        return False
    if is_dataclass(a) and type(a) is type(b):
        return any(differ(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, (tuple, list)) and isinstance(b, (tuple, list)) and len(a) == len(b):
        return any(differ(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, float | int) and isinstance(b, float | int) and not isinstance(a, bool):
        return not math.isclose(a, b, rel_tol=1e-7, abs_tol=1e-12)
    return True


def with_changes(asset: SceneAsset, folder: Path, prefabs: Mapping[Path, Sequence[NodeAsset]]) -> SceneAsset:
    """`asset` with every instance's own values written down, against `prefabs` as they were when it was read."""
    if not has_instances(asset):
        return asset
    result = replace(asset, nodes=list(asset.nodes))
    for index, node in enumerate(asset.nodes):
        path = Path(os.path.normpath((folder / file_of(node)).absolute())) if file_of(node) else None
        if path is None or NODE in node.extras or path not in prefabs:
            continue
        changed, removed = changed_fields(asset, index, prefabs[path])
        said = {"file": file_of(node), "changed": changed, "removed": removed}
        result.nodes[index] = replace(node, extras={**node.extras, ROOT: said})
    return result


def members(asset: SceneAsset, root: int) -> list[int]:
    """The nodes below `root` that came with its prefab."""
    inside = {root}
    found = []
    for index, node in enumerate(asset.nodes):
        if node.parent in inside:
            inside.add(index)
            if NODE in node.extras:
                found.append(index)
    return found


def map_files(node: NodeAsset, follow: Callable[[str], str]) -> NodeAsset:
    """A copy of `node` whose references are what `follow` makes of them."""
    made = replace(node, extras=dict(node.extras))
    if node.mesh is not None:
        made.mesh = replace(
            node.mesh, file=follow(node.mesh.file), materials=[follow(m) if m else "" for m in node.mesh.materials]
        )
    if node.light is not None and node.light.profile:
        made.light = replace(node.light, profile=follow(node.light.profile))
    if file_of(node):
        said: Any = node.extras[ROOT]
        made.extras[ROOT] = {**said, "file": follow(said["file"])}
    return made


def _bring_up(result: SceneAsset, root: int, fresh: Sequence[NodeAsset], findings: Findings) -> None:
    """Make the instance at `root` what `fresh` is; new nodes go to the end, lost ones are marked by a parent of -2."""
    nodes = result.nodes
    said: Any = nodes[root].extras[ROOT]
    changed: dict[str, list[str]] = {str(k): list(v) for k, v in (said.get("changed") or {}).items()}
    removed = set(said.get("removed") or ())
    mine = {str(nodes[i].extras[NODE]): i for i in members(result, root)}
    place: dict[int, int] = {0: root}
    for number, node in enumerate(fresh[1:], 1):
        key = str(node.extras[NODE])
        index = mine.pop(key, -1)
        if index < 0:
            if key in removed or node.parent not in place:
                continue
            place[number] = len(nodes)
            nodes.append(replace(node, parent=place[node.parent], joints=[]))
            continue
        place[number] = index
        kept = {n for field in changed.get(key, ()) for n in FIELDS.get(field, ())}
        taken = {n: getattr(node, n) for names in FIELDS.values() for n in names if n not in kept}
        extras = {**node.extras, **nodes[index].extras, **{k: v for k, v in node.extras.items() if k == ROOT}}
        nodes[index] = replace(nodes[index], **taken, extras=extras)
    for number, node in enumerate(fresh):
        if node.joints and number in place:
            joints = [place.get(j, -1) for j in node.joints]
            nodes[place[number]] = replace(nodes[place[number]], joints=joints if -1 not in joints else [])
    for key, index in mine.items():
        if key in changed:
            findings.warn("prefab.orphan", f"{key} is no longer in the prefab; it had values of its own here")
        nodes[index] = replace(nodes[index], parent=-2)


def _ordered(asset: SceneAsset) -> SceneAsset:
    """Without the lost nodes; what hung below them hangs where they hung; parents first."""
    nodes = asset.nodes
    gone = {i for i, node in enumerate(nodes) if node.parent == -2}
    order: list[int] = []
    done: set[int] = set()
    for start in range(len(nodes)):
        chain, index = [], start
        while index >= 0 and index not in done:
            chain.append(index)
            index = nodes[index].parent
        done.update(chain)
        order += [i for i in reversed(chain) if i not in gone]
    if order == list(range(len(nodes))):
        return asset
    number = {old: new for new, old in enumerate(order)}
    moved = [
        replace(
            nodes[old], parent=number.get(nodes[old].parent, -1),
            joints=[number[j] for j in nodes[old].joints if j in number],
            clip_node=old if nodes[old].clip_node is None and asset.clips else nodes[old].clip_node,
        )
        for old in order
    ]  # fmt: skip
    return replace(asset, nodes=moved, active_camera=number.get(asset.active_camera, -1))


def _rebased(node: NodeAsset, source: Path, folder: Path) -> NodeAsset:
    return map_files(node, lambda text: text if Path(text).is_absolute() else _relative(source / text, folder))


def _relative(path: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # on another drive of Windows
        return path.as_posix()


def prefab_files(asset: SceneAsset, folder: Path) -> Iterable[Path]:
    """The files of all instances, those inside other prefabs too."""
    return dict.fromkeys(Path(os.path.normpath((folder / file_of(n)).absolute())) for n in asset.nodes if file_of(n))
