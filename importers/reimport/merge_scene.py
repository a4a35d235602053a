"""A scene of three sides. Nodes of the import are known by their path of names, whatever their number; the user's own
nodes come along, and hang where they hung, or at the top where that is gone."""

from __future__ import annotations

import copy
from collections import Counter
from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

from engine.assets.clip_nodes import clip_number
from engine.assets.scene import CameraAsset, EnvironmentAsset, LightAsset, LookAsset, MeshRef, NodeAsset, SceneAsset
from importers.reimport.merge import Report, merge_mapping, merge_value

PLACE = ("translation", "rotation", "scale", "matrix")
Key = tuple[tuple[str, int], ...]


def node_keys(nodes: Sequence[NodeAsset]) -> list[Key]:
    """For each node its path of (name, how many siblings before it have that name)."""
    keys: list[Key] = []
    seen: Counter[tuple[Key, str]] = Counter()
    for node in nodes:
        above = keys[node.parent] if 0 <= node.parent < len(keys) else ()
        keys.append((*above, (node.name, seen[above, node.name])))
        seen[above, node.name] += 1
    return keys


def named(key: Key) -> str:
    return "/".join(f"{name} {n + 1}" if n else name for name, n in key)


def merge_scene(
    base: SceneAsset, theirs: SceneAsset, ours: SceneAsset, origin: Sequence[int], report: Report
) -> tuple[SceneAsset, list[int]]:
    """`origin[i]`: the node of `base` that node i of `ours` came from, or -1: the user made it.

    Returns the merged scene, and for each of its nodes the node of `theirs` that it came from, or -1."""
    base_keys, their_keys = node_keys(base.nodes), node_keys(theirs.nodes)
    old_of = {key: i for i, key in enumerate(base_keys)}
    new_of = {key: i for i, key in enumerate(their_keys)}
    ours_of = {b: i for i, b in enumerate(origin) if b >= 0}
    meshes = _MeshNames(base, theirs, report)
    nodes: list[NodeAsset] = []
    parents: list[tuple[str, int]] = []  # ("theirs" | "ours", its number)
    from_theirs: dict[int, int] = {}
    from_ours: dict[int, int] = {}
    for number, node in enumerate(theirs.nodes):
        key = their_keys[number]
        before = old_of.get(key, -1)
        mine = ours_of.get(before, -1)
        if before >= 0 and mine < 0:
            report.kept.append(f"{named(key)}: deleted")
            continue
        from_theirs[number] = len(nodes)
        if before < 0:
            report.taken.append(f"{named(key)}: new")
            nodes.append(copy.copy(node))
            parents.append(("theirs", node.parent))
            continue
        from_ours[mine] = len(nodes)
        nodes.append(_merge_node(base.nodes[before], node, ours.nodes[mine], f"{named(key)}: ", report))
        hung = ours.nodes[mine].parent
        same = (origin[hung] if hung >= 0 else -1) == base.nodes[before].parent and (hung < 0) == (
            base.nodes[before].parent < 0
        )
        if not same:
            report.kept.append(f"{named(key)}: hung elsewhere")
        parents.append(("theirs", node.parent) if same else ("ours", hung))
    for number, node in enumerate(ours.nodes):
        if number in from_ours:
            continue
        before = origin[number]
        if before >= 0:
            if base_keys[before] not in new_of:
                said = _changes(base.nodes[before], node)
                if said:
                    report.orphans.append(f"{named(base_keys[before])} is no longer in the source; yours: {said}")
                else:
                    report.taken.append(f"{named(base_keys[before])}: gone")
            continue
        from_ours[number] = len(nodes)
        added = replace(node, clip_node=_their_clip_node(node, base_keys, new_of))
        if added.mesh is not None:
            added.mesh = meshes.follow(added.mesh, node.name)
        nodes.append(added)
        parents.append(("ours", node.parent))
        report.kept.append(f"{node.name}: added")
    for index, (side, parent) in enumerate(parents):
        place = (from_theirs if side == "theirs" else from_ours).get(parent, -1)
        if parent >= 0 and place < 0 and side == "ours":
            report.orphans.append(f"{nodes[index].name} hung below what is gone, and stands at the top now")
        elif parent >= 0 and place < 0:
            place = _nearest(theirs.nodes, parent, from_theirs)
        nodes[index] = replace(nodes[index], parent=place)
    for index, node in enumerate(nodes):
        number = next((t for t, m in from_theirs.items() if m == index), -1) if node.joints else -1
        lookup = from_theirs if number >= 0 else from_ours
        if node.joints:
            nodes[index] = replace(node, joints=[lookup.get(j, -1) for j in node.joints])
            if -1 in nodes[index].joints:
                nodes[index] = replace(nodes[index], joints=[])
                report.orphans.append(f"{node.name}: a joint is gone, and it is rigid now")
    came = [-1] * len(nodes)
    for number, index in from_theirs.items():
        came[index] = number
        clip = clip_number(nodes[index], number)
        nodes[index] = replace(nodes[index], clip_node=clip)
    order = _parents_first(nodes)
    merged = SceneAsset(
        theirs.name, _reordered(nodes, order),
        clips=[*theirs.clips, *(c for c in ours.clips if c not in base.clips and c not in theirs.clips)],
        environment=_merge_record(
            base.environment, theirs.environment, ours.environment, EnvironmentAsset, "environment ", report
        ),
        look=_merge_record(base.look, theirs.look, ours.look, LookAsset, "look ", report),
        active_camera=_camera(theirs, ours, base, from_theirs, from_ours, origin, order),
        provenance=dict(theirs.provenance), animation=ours.animation, drive=ours.drive,
    )  # fmt: skip
    came = [came[i] for i in order]
    if merged.clips:
        for index, node in enumerate(merged.nodes):
            node.clip_node = None if node.clip_node == index else node.clip_node
    return merged, came


def _merge_node(base: NodeAsset, theirs: NodeAsset, ours: NodeAsset, what: str, report: Report) -> NodeAsset:
    places = [tuple(getattr(n, f) for f in PLACE) for n in (base, theirs, ours)]
    place = merge_value(places[0], places[1], places[2], f"{what}place", report)
    merged = replace(theirs, **dict(zip(PLACE, place, strict=True)))
    for name in ("name", "visible", "weights", "placed"):
        values = [getattr(n, name) for n in (base, theirs, ours)]
        setattr(merged, name, merge_value(values[0], values[1], values[2], f"{what}{name}", report))
    merged.light = _merge_record(base.light, theirs.light, ours.light, LightAsset, f"{what}light ", report)
    merged.camera = _merge_record(base.camera, theirs.camera, ours.camera, CameraAsset, f"{what}camera ", report)
    merged.extras = merge_mapping(base.extras, theirs.extras, ours.extras, f"{what}extra ", report)
    if merged.mesh is not None and base.mesh is not None and ours.mesh is not None:
        materials = list(merged.mesh.materials)
        for slot, (old, now) in enumerate(zip(base.mesh.materials, ours.mesh.materials, strict=False)):
            if old != now and slot < len(materials):
                materials[slot] = merge_value(old, materials[slot], now, f"{what}material {slot}", report)
        merged.mesh = replace(merged.mesh, materials=materials, overrides=_own_values(ours, len(materials), report))
    return merged


def _own_values(ours: NodeAsset, slots: int, report: Report) -> list[dict[str, Any]]:
    """What the object's materials are other in than their files: the user's alone, no import says it."""
    said = ours.mesh.overrides if ours.mesh is not None else []
    for slot, values in enumerate(said[max(slots, 1) :], max(slots, 1)):
        if values:
            report.orphans.append(f"{ours.name}: {', '.join(values)} of material slot {slot}, which is gone")
    return [dict(values) for values in said[: max(slots, 1)]]


def _merge_record(base: Any, theirs: Any, ours: Any, kind: type, what: str, report: Report) -> Any:
    """Field by field where all three have the record, else as a whole."""
    if base is None or theirs is None or ours is None:
        return merge_value(base, theirs, ours, what.strip(), report)
    sides = [{f.name: getattr(side, f.name) for f in fields(kind)} for side in (base, theirs, ours)]
    return kind(**merge_mapping(sides[0], sides[1], sides[2], what, report))


def _changes(base: NodeAsset, ours: NodeAsset) -> str:
    """What the user had changed of a node, in words."""
    report = Report()
    _merge_node(base, base, ours, "", report)
    return ", ".join(report.kept)


def _their_clip_node(node: NodeAsset, base_keys: list[Key], new_of: dict[Key, int]) -> int:
    """A copy of an imported node still moves with the clips of that one."""
    number = node.clip_node if node.clip_node is not None else -1
    return new_of.get(base_keys[number], -1) if 0 <= number < len(base_keys) else -1


def _nearest(nodes: Sequence[NodeAsset], index: int, kept: dict[int, int]) -> int:
    while index >= 0 and index not in kept:
        index = nodes[index].parent
    return kept.get(index, -1)


def _camera(
    theirs: SceneAsset, ours: SceneAsset, base: SceneAsset, from_theirs: dict[int, int], from_ours: dict[int, int],
    origin: Sequence[int], order: list[int],
) -> int:  # fmt: skip
    mine = ours.active_camera
    unchanged = (origin[mine] if 0 <= mine < len(origin) else -1) == base.active_camera
    index = from_theirs.get(theirs.active_camera, -1) if unchanged else from_ours.get(mine, -1)
    return order.index(index) if index >= 0 else -1


def _parents_first(nodes: Sequence[NodeAsset]) -> list[int]:
    """The nodes' numbers with parents before children, else in their order; a loop is cut at the top."""
    order: list[int] = []
    done: set[int] = set()
    for start in range(len(nodes)):
        chain, index = [], start
        while index >= 0 and index not in done and index not in chain:
            chain.append(index)
            index = nodes[index].parent
        done.update(chain)
        order += reversed(chain)
    return order


def _reordered(nodes: Sequence[NodeAsset], order: list[int]) -> list[NodeAsset]:
    place = {old: new for new, old in enumerate(order)}
    return [
        replace(nodes[old], parent=place.get(nodes[old].parent, -1), joints=[place[j] for j in nodes[old].joints])
        for old in order
    ]


class _MeshNames:
    """Meshes of the last import that the user's own nodes show, found in the new one by their names."""

    def __init__(self, base: SceneAsset, theirs: SceneAsset, report: Report) -> None:
        self._files = {n.mesh.file for n in base.nodes if n.mesh is not None}
        self._new: dict[str, MeshRef] = {}
        for node in theirs.nodes:
            if node.mesh is not None:
                self._new.setdefault(node.mesh.name, node.mesh)
        self._report = report

    def follow(self, ref: MeshRef, who: str) -> MeshRef | None:
        if ref.file not in self._files:
            return ref
        found = self._new.get(ref.name)
        if found is None:
            self._report.orphans.append(f"{who} shows the mesh {ref.name}, which is no longer in the source")
            return None
        return replace(found, materials=list(ref.materials))
