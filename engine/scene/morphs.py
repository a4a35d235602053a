"""MorphTable: the morph weights of nodes whose meshes have targets, and how far these can carry a vertex."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import InputError
from engine.math.bounds import largest_scale
from engine.scene.instances import InstanceTable
from engine.scene.nodes import NodeTable
from engine.scene.skins import SkinTable

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]

#: far beyond any use; offsets times it still fit the GPU's float32
LARGEST_WEIGHT = 1e6


class MorphTable:
    """Row m is node `node[m]` with the weights `weights[first[m]]` … `weights[first[m] + count[m]]`, one per target.

    `names`: per row its targets' names. A row is `active` once a weight was not 0: only then do its shaders know of
    morphing, and it stays so, since another variant in mid-play would cost more than the few zeros it saves.
    """

    def __init__(self, nodes: NodeTable, instances: InstanceTable, skins: SkinTable) -> None:
        self._nodes, self._instances, self._skins = nodes, instances, skins
        self.node: I8 = np.zeros(0, np.int64)
        self.first: I8 = np.zeros(0, np.int64)
        self.count: I8 = np.zeros(0, np.int64)
        self.names: list[tuple[str, ...]] = []
        self.weights: F8 = np.zeros(0)
        #: f8[weights]: the weights as the file has them
        self.rest: F8 = np.zeros(0)
        #: f8[weights]: metres in mesh space that a target moves a vertex by at most, at weight 1
        self.reach: F8 = np.zeros(0)
        self.active: NDArray[np.bool_] = np.zeros(0, np.bool_)
        #: rises with every weight that changed
        self.rev = 0
        #: rises with every row added or become active
        self.structure_rev = 0
        self._generation: NDArray[np.uint32] = np.zeros(0, np.uint32)
        self._radius: dict[int, F8] = {}

    def __len__(self) -> int:
        return len(self.node)

    def add(self, node: int, names: Sequence[str], reach: ArrayLike, weights: ArrayLike = ()) -> int:
        """Give the mesh on `node` targets `names` [t] with `reach` [t]; missing weights are 0. Returns the row.

        Raises InputError for a node that does not exist or has targets already, or lengths that differ."""
        self._nodes.select(np.array([node]))
        far = np.asarray(reach, np.float64).reshape(-1)
        if len(far) != len(names) or not np.isfinite(far).all():
            raise InputError(f"{len(names)} morph targets with {len(far)} reaches, expected one finite number each")
        if self.of_nodes(np.array([node]))[0] >= 0:
            raise InputError(f"node {node} has morph targets already")
        given = _usable(np.asarray(weights, np.float64).reshape(-1))[: len(names)]
        rest = np.concatenate([given, np.zeros(len(names) - len(given))])
        self.node = np.append(self.node, node)
        self.first = np.append(self.first, len(self.weights))
        self.count = np.append(self.count, len(names))
        self._generation = np.append(self._generation, self._nodes.generation[node])
        self.names.append(tuple(names))
        self.weights, self.rest = np.concatenate([self.weights, rest]), np.concatenate([self.rest, rest])
        self.reach = np.concatenate([self.reach, far])
        self.active = np.append(self.active, False)
        self.structure_rev += 1
        self._moved(np.array([len(self) - 1]))
        return len(self) - 1

    @property
    def living(self) -> I8:
        """i8[k]: the rows whose nodes are still what they were: a removed node's row comes back with it."""
        nodes = self._nodes
        there: I8 = np.flatnonzero(self.node < len(nodes.alive))  # undoing an addition makes the node table shorter
        at = self.node[there]
        rows: I8 = there[nodes.alive[at] & (nodes.generation[at] == self._generation[there])]
        return rows

    def of_nodes(self, rows: ArrayLike) -> I8:
        """i8[k]: the row of each of the nodes `rows`, -1 for none."""
        of_node = np.full(len(self._nodes) + 1, -1, np.int64)
        living = self.living
        of_node[self.node[living]] = living
        found: I8 = of_node[np.asarray(rows)]
        return found

    def of_node(self, node: int) -> F8:
        """f8[t]: the weights of a node; none where it has no targets."""
        row = int(self.of_nodes(np.array([node]))[0])
        return self.weights[self.first[row] : self.first[row] + self.count[row]] if row >= 0 else np.zeros(0)

    def set_node(self, node: int, values: ArrayLike) -> None:
        """Set all weights of a node. Raises InputError for a node without targets or another number of weights."""
        row = int(self.of_nodes(np.array([node]))[0])
        wanted = np.asarray(values, np.float64).reshape(-1)
        if row < 0 or len(wanted) != self.count[row]:
            count = int(self.count[row]) if row >= 0 else 0
            raise InputError(f"{len(wanted)} weights for a node with {count} morph targets")
        self.set(self.first[row] + np.arange(len(wanted)), wanted)

    def set(self, numbers: I8, values: F8) -> None:
        """Set the weights `numbers` i8[k]; what is not finite becomes 0, what is absurd LARGEST_WEIGHT."""
        clean = _usable(values)
        changed = self.weights[numbers] != clean
        if not changed.any():
            return
        self.weights[numbers] = clean
        self._moved(np.unique(np.searchsorted(self.first, numbers[changed], side="right") - 1))

    def swell(self) -> F8:
        """f8[rows]: how far, in mesh space, the weights of now move a vertex at most."""
        total = np.concatenate([[0.0], np.cumsum(np.abs(self.weights) * self.reach)])
        return np.asarray(total[self.first + self.count] - total[self.first], np.float64)

    def update_skinned(self) -> None:
        """Let the world spheres of skinned instances hold their morphs too. Call after SkinTable.update()."""
        rows = self.living[self.active[self.living]]
        skin = self._skins.of_nodes(self.node[rows])
        rows, skin = rows[skin >= 0], skin[skin >= 0]
        if len(rows) == 0:
            return
        swell, table = self.swell(), self._instances
        stretch = largest_scale(self._skins.joint_world()[:, :, :3] @ self._skins.inverse_bind[:, :, :3])
        for row, s in zip(rows.tolist(), skin.tolist(), strict=True):
            part = slice(int(self._skins.first[s]), int(self._skins.first[s] + self._skins.count[s]))
            drawn = np.flatnonzero(table.alive & (table.node == self.node[row]))
            more = float(swell[row]) * float(stretch[part].max())
            base = self._skins.sphere(s)
            centers = np.repeat(base[None, :3], len(drawn), axis=0)
            table.set_world_spheres(drawn, centers, np.full(len(drawn), base[3] + more))

    def _moved(self, rows: I8) -> None:
        """The weights of `rows` changed: spheres grow or shrink, and the nodes count as moved."""
        self.rev += 1
        moving = np.array([bool(self.weights[self.first[r] : self.first[r] + self.count[r]].any()) for r in rows])
        if (moving & ~self.active[rows]).any():
            self.active[rows[moving]] = True
            self.structure_rev += 1
        swell, table = self.swell(), self._instances
        living = set(self.living.tolist())
        for row in rows.tolist():
            if row not in living:
                continue
            drawn = np.flatnonzero(table.alive & (table.node == self.node[row]))
            if len(drawn):
                known = self._radius.get(row)
                if known is None or len(known) != len(drawn):
                    known = self._radius[row] = table.bounds_radius[drawn].astype(np.float64)
                table.set_bounds(drawn, table.bounds_center[drawn], known + swell[row])
            self._nodes.touch([int(self.node[row])])


def _usable(weights: F8) -> F8:
    """0 for what is not finite, within LARGEST_WEIGHT for the rest."""
    return np.clip(np.nan_to_num(weights, posinf=0.0, neginf=0.0), -LARGEST_WEIGHT, LARGEST_WEIGHT)
