"""SceneAsset to Scene and back. Runs at load and save, so plain loops over nodes are fine here."""

from __future__ import annotations

import copy
import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from engine.assets.clip_nodes import clip_number
from engine.assets.scene import IDENTITY_ROTATION, NodeAsset, SceneAsset
from engine.scene.scene import Scene


def fill_scene(scene: Scene, asset: SceneAsset) -> None:
    """Add the nodes, lights and cameras of `asset` to an empty `scene` and update it; findings go to the scene's."""
    notes = scene.findings
    nodes = asset.nodes
    parents = []
    for index, node in enumerate(nodes):
        parent = node.parent
        if not -1 <= parent < index:
            notes.warn("scene.parent", f"parent {parent} is not an earlier node, made a root", f"nodes[{index}]")
            parent = -1
        parents.append(parent)

    def column(name: str, default: tuple[float, ...]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        values = np.array([getattr(n, name) for n in nodes], np.float64).reshape(len(nodes), len(default))
        for index in np.flatnonzero(~np.isfinite(values).all(axis=1)):
            notes.warn("scene.number", f"{name} {values[index].tolist()} is not finite, reset", f"nodes[{index}]")
            values[index] = default
        return values

    rows = scene.nodes.add_many(
        [n.name for n in nodes],
        None,
        column("translation", (0.0, 0.0, 0.0)),
        column("rotation", IDENTITY_ROTATION),
        column("scale", (1.0, 1.0, 1.0)),
        batch_parents=parents,
    )
    scene.row_of_node = rows
    if nodes:
        scene.nodes.set_visible(rows, [n.visible for n in nodes])
    for index, (node, row) in enumerate(zip(nodes, rows.tolist(), strict=True)):
        path = f"nodes[{index}]"
        scene.sources[row] = node
        if math.hypot(*node.rotation) < 1e-30:
            notes.warn("scene.rotation", "zero rotation, taken as none", path)
        if node.matrix is not None:
            if len(node.matrix) == 16 and all(math.isfinite(v) for v in node.matrix):
                scene.nodes.set_matrix(row, np.array(node.matrix, np.float64).reshape(4, 4).T)
            else:
                notes.warn("scene.matrix", "matrix is not 16 finite numbers, left out", path)
        if node.light is not None:
            scene.lights.add(row, node.light, notes, f"{path}.light")
        if node.camera is not None:
            scene.cameras.add(row, node.camera, notes, f"{path}.camera")
    scene.environment = copy.copy(asset.environment)
    scene.look = copy.copy(asset.look)
    if 0 <= asset.active_camera < len(nodes):
        scene.active_camera = int(rows[asset.active_camera])
    scene.update()


def scene_asset(scene: Scene, base: SceneAsset | None) -> SceneAsset:
    """Return `scene` as an asset: rows in their order, except that a parent always precedes its children."""
    order = parents_first(scene)
    index_of = {row: index for index, row in enumerate(order)}
    before = {int(row): index for index, row in enumerate(scene.row_of_node.tolist()) if row >= 0}
    joint_of = {old: index_of[row] for row, old in before.items() if row in index_of}
    nodes = [_node_asset(scene, row, index_of, joint_of) for row in order]
    if base is None or base.clips:  # their channels count nodes as the scene's file did
        for index, (node, row) in enumerate(zip(nodes, order, strict=True)):
            number = clip_number(node, before.get(row, -1))
            node.clip_node = None if number == index else number
    skins = scene.skins
    for node, skin in zip(nodes, skins.of_nodes(np.array(order, np.int64)).tolist(), strict=True):
        if skin >= 0:  # a copy hangs on other joints than its source
            joints = skins.joint[skins.first[skin] : skins.first[skin] + skins.count[skin]]
            node.joints = [index_of.get(int(j), -1) for j in joints]
    for rows, table in ((scene.lights.alive_rows(), scene.lights), (scene.cameras.alive_rows(), scene.cameras)):
        for row in rows.tolist():
            node = nodes[index_of[int(table.node[row])]]
            if table is scene.lights:
                node.light = scene.lights.asset(row)
            else:
                node.camera = scene.cameras.asset(row)
    return SceneAsset(
        name=scene.name,
        nodes=nodes,
        clips=list(base.clips) if base else [],
        environment=copy.copy(scene.environment),
        look=copy.copy(scene.look),
        active_camera=index_of.get(scene.active_camera, -1),
        animation=base.animation if base else "",
        drive=base.drive if base else "",
        bookmarks=list(base.bookmarks) if base else [],
        provenance=dict(base.provenance) if base else {},
    )


def node_assets(scene: Scene, rows: Collection[int]) -> dict[int, NodeAsset]:
    """Some nodes as `scene_asset` writes them, by row; without parents, joints and clip numbers, which count nodes."""
    nodes = {row: replace(_node_asset(scene, row, {}, {}), joints=[]) for row in rows}
    for table in (scene.lights, scene.cameras):
        for at in table.alive_rows().tolist():
            row = int(table.node[at])
            if row not in nodes:
                continue
            if table is scene.lights:
                nodes[row].light = scene.lights.asset(at)
            else:
                nodes[row].camera = scene.cameras.asset(at)
    return nodes


def _node_asset(scene: Scene, row: int, index_of: dict[int, int], joint_of: dict[int, int]) -> NodeAsset:
    table = scene.nodes
    source = scene.sources.get(row)
    own = (table.translation[row], table.rotation[row], table.scale[row])
    if scene.places is not None:  # of what a clip moves about a place of its own, that place
        own = scene.places.of(row)
    (tx, ty, tz), (qx, qy, qz, qw), (sx, sy, sz) = (part.tolist() for part in own)
    matrix = tuple(table.local_matrix(row).T.reshape(16).tolist()) if table.has_matrix[row] else None
    kept = replace(source, light=None, camera=None) if source else NodeAsset("")
    return replace(
        kept,
        name=table.name[row],
        parent=index_of.get(int(table.parent[row]), -1),
        translation=(tx, ty, tz),
        rotation=(qx, qy, qz, qw),
        scale=(sx, sy, sz),
        matrix=matrix,
        visible=bool(table.visible[row]),
        joints=[joint_of.get(j, -1) for j in kept.joints],
    )


def parents_first(scene: Scene) -> list[int]:
    """Return the living node rows in the order in which `scene_asset` writes them."""
    parent = scene.nodes.parent.tolist()
    order: list[int] = []
    done: set[int] = set()
    for row in scene.nodes.alive_rows().tolist():
        chain = []
        while row != -1 and row not in done:
            chain.append(row)
            done.add(row)
            row = parent[row]
        order.extend(reversed(chain))
    return order
