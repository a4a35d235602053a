"""SkinTable: which nodes' meshes hang on which joint nodes, and where their bones are.

All skins lie in one run of arrays, so that every palette of a frame is one matrix product.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import InputError
from engine.math import quat
from engine.math.bounds import largest_scale
from engine.math.transform import decompose
from engine.scene.instances import InstanceTable
from engine.scene.nodes import NodeTable

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]


METHODS = ("linear", "dual_quaternion")


def dual_rows(matrices: F8) -> F8:
    """Affine matrices f8[n,3,4] as rows (rotation xyzw), (dual part xyzw), (scale xyz, 0): f8[n,3,4].

    The dual part of a rigid motion is (t, 0) q / 2 (Kavan et al. 2008, eq. 4). Shear is lost."""
    whole = np.zeros((len(matrices), 4, 4))
    whole[:, :3], whole[:, 3, 3] = matrices, 1.0
    translation, rotation, scale = decompose(whole)
    out = np.zeros((len(matrices), 3, 4))
    out[:, 0] = rotation
    pure = np.concatenate([translation, np.zeros((len(translation), 1))], axis=1)
    out[:, 1] = 0.5 * quat.multiply(pure, rotation)
    out[:, 2, :3] = scale
    return out


class SkinTable:
    """Skin s hangs on node `node[s]` and owns the joints `first[s]` … `first[s] + count[s]`.

    A skinned mesh is placed by its joints alone; its own node's transform does not count (glTF 2.0, 3.7.3.3).
    """

    def __init__(self, nodes: NodeTable, instances: InstanceTable) -> None:
        self._nodes = nodes
        self._instances = instances
        #: rises with every skin added or removed
        self.structure_rev = 0
        self.node: I8 = np.zeros(0, np.int64)
        self.first: I8 = np.zeros(0, np.int64)
        self.count: I8 = np.zeros(0, np.int64)
        #: node row of every joint of every skin
        self.joint: I8 = np.zeros(0, np.int64)
        #: f8[joints,3,4], joint space from mesh space
        self.inverse_bind: F8 = np.zeros((0, 3, 4))
        #: f8[joints]: how far from the joint a vertex lies that follows it, in the joint's own space
        self.reach: F8 = np.zeros(0)
        #: f8[skins,4,4]: bind space from world for skins that also follow their own node (see `add`), else NaN
        self.follow: F8 = np.zeros((0, 4, 4))
        #: bool[skins]: whether rotations are blended as dual quaternions (see `set_method`)
        self.dual: NDArray[np.bool_] = np.zeros(0, np.bool_)
        self._linear_nodes: frozenset[int] = frozenset()
        self._spheres: F8 = np.zeros((0, 4))
        self._seen: tuple[int, int, int] = (-1, -1, -1)

    def __len__(self) -> int:
        return len(self.node)

    def add(
        self, node: int, joints: ArrayLike, inverse_bind: ArrayLike, reach: ArrayLike,
        bind_world: ArrayLike | None = None,
    ) -> int:  # fmt: skip
        """Hang the mesh of `node` on the nodes `joints` [k]; inverse_bind [k,4,4], reach [k]. Returns the skin's index.

        `bind_world` f8[4,4]: the node's world transform when it was bound, where the source moves the whole skin by
        what the node has moved since (Maya does). Raises InputError for a node that does not exist or lengths that
        differ.
        """
        rows = np.asarray(joints, np.int64).reshape(-1)
        bind = np.asarray(inverse_bind, np.float64).reshape(-1, 4, 4)[:, :3]
        far = np.asarray(reach, np.float64).reshape(-1)
        if not len(rows) == len(bind) == len(far) > 0:
            raise InputError(f"a skin with {len(rows)} joints, {len(bind)} bind matrices, {len(far)} reaches")
        self._nodes.select(np.unique(np.append(rows, node)))
        self.node = np.append(self.node, node)
        self.first = np.append(self.first, len(self.joint))
        self.count = np.append(self.count, len(rows))
        self.joint = np.concatenate([self.joint, rows])
        self.inverse_bind = np.concatenate([self.inverse_bind, bind])
        self.reach = np.concatenate([self.reach, far])
        back = np.full((4, 4), np.nan) if bind_world is None else np.linalg.inv(np.asarray(bind_world, np.float64))
        self.follow = np.concatenate([self.follow, back[None]])
        self.dual = np.append(self.dual, False)
        self.structure_rev += 1
        return len(self.node) - 1

    def remove_of_nodes(self, gone: ArrayLike) -> None:
        """Remove the skins that hang on, or hold a joint among, the nodes `gone`."""
        lost = np.isin(self.joint, gone)
        keep = ~np.isin(self.node, gone)
        for s in np.flatnonzero(keep):
            keep[s] = not lost[self.first[s] : self.first[s] + self.count[s]].any()
        if keep.all():
            return
        joints = np.repeat(keep, self.count)
        self.joint, self.inverse_bind, self.reach = self.joint[joints], self.inverse_bind[joints], self.reach[joints]
        self.node, self.count, self.follow = self.node[keep], self.count[keep], self.follow[keep]
        self.dual = self.dual[keep]
        self.first = np.cumsum(self.count) - self.count
        self.structure_rev += 1

    def of_nodes(self, rows: NDArray[np.integer]) -> I8:
        """i8[k]: the skin of each of the nodes `rows`, -1 for none."""
        of_node = np.full(len(self._nodes) + 1, -1, np.int64)
        of_node[self.node] = np.arange(len(self.node))
        found: I8 = of_node[rows]
        return found

    def joint_world(self) -> F8:
        """f8[joints,3,4]: where the joints are, with what their skin's own node adds."""
        world: F8 = self._nodes.world[self.joint]
        follows = ~np.isnan(self.follow[:, 0, 0])
        if not follows.any():
            return world
        own = self._nodes.world[self.node[follows]]
        moved = own[:, :, :3] @ self.follow[follows, :3]
        moved[:, :, 3] += own[:, :, 3]
        rows = np.flatnonzero(np.repeat(follows, self.count))
        by = np.repeat(moved, self.count[follows], axis=0)
        out = world.copy()
        out[rows] = by[:, :, :3] @ world[rows]
        out[rows, :, 3] += by[:, :, 3]
        return out

    def set_method(self, skin: int, method: str) -> None:
        """Blend the joints of a skin by `linear` matrices or as `dual_quaternion`s. Raises InputError for another."""
        if method not in METHODS:
            raise InputError(f"unknown skinning {method!r}", hint=f"choose one of {', '.join(METHODS)}")
        dual = method == "dual_quaternion"
        if dual != bool(self.dual[skin]):
            self.dual = self.dual.copy()
            self.dual[skin] = dual
            self.structure_rev += 1

    @property
    def blends_dual(self) -> NDArray[np.bool_]:
        """bool[skins]: which are blended as dual quaternions: those that are `dual`, where their shaders can."""
        return self.dual & ~np.isin(self.node, list(self._linear_nodes)) if self._linear_nodes else self.dual

    def keep_linear(self, nodes: frozenset[int]) -> None:
        """Blend the skins of these nodes linearly whatever their method: a shader there knows nothing else."""
        if nodes != self._linear_nodes:
            self._linear_nodes = nodes
            self.structure_rev += 1

    def method(self, skin: int) -> str:
        return METHODS[int(self.dual[skin])]

    def palette(self, origin: F8) -> NDArray[np.float32]:
        """f4[joints,3,4]: from mesh space to the world relative to `origin` f8[3], per joint, as of the last update.

        For dual skins the three rows are the rotation and the dual part (xyzw each) and the scale (xyz, 0)."""
        world = self.joint_world()
        with np.errstate(over="ignore", invalid="ignore"):  # a joint beyond float32 takes only its own vertices along
            out = world[:, :, :3] @ self.inverse_bind
            out[:, :, 3] += world[:, :, 3] - origin
            dual = self.blends_dual
            if dual.any():
                rows = np.flatnonzero(np.repeat(dual, self.count))
                out[rows] = dual_rows(out[rows])
            return out.astype(np.float32)

    def sphere(self, skin: int) -> F8:
        """f8[4]: centre and radius, in the world, of what hangs on a skin, as of the last update."""
        found: F8 = self._spheres[skin]
        return found

    def update(self) -> bool:
        """Give the skinned instances world spheres that hold their pose; True when they moved. Call after nodes and
        instances."""
        seen = (self._nodes.transform_rev, self.structure_rev, self._instances.structure_rev)
        if seen == self._seen or len(self) == 0:
            return False
        self._seen = seen
        with np.errstate(over="ignore", invalid="ignore"):
            self._place_spheres()
        return True

    def _place_spheres(self) -> None:
        world = self.joint_world()
        place = world[:, :, 3]
        reach = self.reach * largest_scale(world[:, :, :3])
        low = np.minimum.reduceat(place - reach[:, None], self.first)
        high = np.maximum.reduceat(place + reach[:, None], self.first)
        center = (low + high) / 2
        off = np.linalg.norm(place - np.repeat(center, self.count, axis=0), axis=1) + reach
        radius = np.minimum(np.maximum.reduceat(off, self.first), np.linalg.norm(high - low, axis=1) / 2)
        self._spheres = np.concatenate([center, radius[:, None]], axis=1)
        table = self._instances
        skin = self.of_nodes(table.node)
        rows = np.flatnonzero(table.alive & (skin >= 0))
        table.set_world_spheres(rows, center[skin[rows]], radius[skin[rows]])
