"""Arrays: what is there once, repeated in a line, a grid or a ring."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.clip_nodes import clip_number
from engine.assets.scene import NodeAsset, SceneAsset
from engine.core.errors import InputError
from engine.core.param import ParamBlock, param
from engine.math import quat, transform
from engine.scene.scene import Scene

F8 = NDArray[np.float64]

SHAPES = ("line", "grid", "ring")
AXES = ("x", "y", "z")
#: nodes that an array may make at once
MOST_NODES = 100_000


class ArraySettings(ParamBlock):
    """How it is repeated; the original is the first. Directions are the world's."""

    shape: str = param("line", choices=SHAPES, doc="one after the other, in rows, or round a middle")
    count: int = param(3, min=1, max=10_000, doc="how many in the line or ring, the original being the first")
    count_x: int = param(3, min=1, max=1000, doc="how many of the grid along X")
    count_y: int = param(1, min=1, max=1000, doc="how many of the grid along Y")
    count_z: int = param(3, min=1, max=1000, doc="how many of the grid along Z")
    step: tuple[float, float, float] = param(
        (1.0, 0.0, 1.0), min=-1e6, max=1e6, step=0.02, unit="m",
        doc="from one of the line to the next; between a grid's neighbours along X, Y and Z",
    )  # fmt: skip
    radius: float = param(1.0, min=0.0, max=1e6, step=0.02, unit="m", doc="of the ring, on which the original lies")
    arc: float = param(360.0, min=-360.0, max=360.0, step=1.0, unit="deg", doc="how much of a ring; 360 closes it")
    axis: str = param("y", choices=AXES, doc="what the ring goes round")
    turn: bool = param(True, doc="turn each as the ring turns, so that all look to the middle alike")

    @property
    def total(self) -> int:
        """How many there will be, with the original."""
        return self.count_x * self.count_y * self.count_z if self.shape == "grid" else self.count


#: what only some shapes have
OF_SHAPE = {
    "line": {"count", "step"}, "grid": {"count_x", "count_y", "count_z", "step"},
    "ring": {"count", "radius", "arc", "axis", "turn"},
}  # fmt: skip


def moves(settings: ArraySettings, at: ArrayLike) -> F8:
    """Return f8[total - 1,4,4]: what takes the original, at `at` f8[3] in the world, to each of the others."""
    result = np.tile(np.eye(4), (settings.total - 1, 1, 1))
    if settings.shape == "ring":
        gaps = settings.count if abs(settings.arc) == 360.0 else max(settings.count - 1, 1)
        axis = np.eye(3)[AXES.index(settings.axis)]
        spoke = settings.radius * np.eye(3)[(AXES.index(settings.axis) + 2) % 3]  # about Y the middle lies along -X
        angles = math.radians(settings.arc) / gaps * np.arange(1, settings.count)
        turns = quat.to_matrix3(quat.from_axis_angle(axis, angles))
        if not settings.turn:
            result[:, :3, 3] = turns @ spoke - spoke
            return result
        middle = np.asarray(at, np.float64) - spoke
        result[:, :3, :3] = turns
        result[:, :3, 3] = middle - turns @ middle
        return result
    if settings.shape == "line":
        places = np.repeat(np.arange(settings.count)[:, None], 3, axis=1)
    else:
        counts = (settings.count_x, settings.count_y, settings.count_z)
        places = np.stack(np.meshgrid(*[np.arange(c) for c in counts], indexing="ij"), -1).reshape(-1, 3)
    result[:, :3, 3] = places[1:] * np.asarray(settings.step)
    return result


def placed(move: F8, local: F8, parent: F8) -> F8:
    """Return the local matrix [4,4] of a node below `parent` (world) that is `local` now, after `move` in the world."""
    result: F8 = transform.inverse_affine(parent) @ move @ parent @ local
    return result


def check_total(nodes: int) -> None:
    """Raises InputError for more nodes than can be made at once."""
    if nodes > MOST_NODES:
        raise InputError(f"an array of {nodes:,} nodes", hint=f"{MOST_NODES:,} can be made at once")


def repeat_node(asset: SceneAsset, index: int, settings: ArraySettings) -> int:
    """Repeat node `index` of a scene, with all below it; returns how many nodes were added.

    Copies of what clips move play along, except the nodes placed by the array itself. Raises InputError for too many.
    """
    nodes = asset.nodes
    inside = [index]
    for i in range(index + 1, len(nodes)):
        if nodes[i].parent in set(inside):
            inside.append(i)
    check_total((settings.total - 1) * len(inside))
    scene = Scene.from_asset(asset)
    rows = scene.row_of_node
    parent = np.eye(4) if nodes[index].parent < 0 else scene.nodes.world_matrix(int(rows[nodes[index].parent]))
    local = scene.nodes.local_matrix(int(rows[index]))
    taken = {node.name for node in nodes}
    animated = bool(asset.clips or asset.animation)
    first = len(nodes)
    for move in moves(settings, scene.nodes.world_matrix(int(rows[index]))[:3, 3]):
        new_of = {old: len(nodes) + k for k, old in enumerate(inside)}
        for old in inside:
            source = nodes[old]
            made = replace(
                source,
                parent=new_of.get(source.parent, source.parent),
                joints=[new_of.get(j, j) for j in source.joints],
            )
            if animated:
                made.clip_node = clip_number(source, old)
            if old == index:
                made = _moved(replace(made, name=_free(source.name, taken)), placed(move, local, parent))
                made.placed = source.placed or animated
                taken.add(made.name)
            nodes.append(made)
    return len(nodes) - first


def _moved(node: NodeAsset, local: F8) -> NodeAsset:
    t, q, s = (tuple(v.tolist()) for v in transform.decompose(local))
    sheared = not np.allclose(transform.compose(t, q, s), local, rtol=0.0, atol=1e-9 * float(np.abs(local).max()))
    matrix = tuple(local.T.ravel().tolist()) if sheared else None
    return replace(node, translation=t, rotation=q, scale=s, matrix=matrix)


def _free(wanted: str, taken: Collection[str]) -> str:
    """`wanted 2`, `wanted 3`…: the first that no node has."""
    stem, _, number = wanted.rpartition(" ")
    stem, count = (stem, int(number)) if stem and number.isdigit() else (wanted, 1)
    while (name := f"{stem} {count}") in taken or count == 1:
        count += 1
    return name
