"""InstanceTable: one row per drawable (a mesh's submesh on a node) with its bounding sphere in the world."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import InputError
from engine.math.bounds import largest_scale
from engine.scene.nodes import NodeTable
from engine.scene.propagate import apply
from engine.scene.table import Rows, RowValues, Table, blocks

F8 = NDArray[np.float64]
F4 = NDArray[np.float32]
I4 = NDArray[np.int32]
I8 = NDArray[np.int64]

#: float32 rounding of a plane's product with a sphere, relative to its terms: five products and sums, with room.
CULL_SLACK = np.float32(2.0**-20)

#: Metres from the world's origin beyond which an object has no say in where the scene's middle is.
_FARTHEST = 1e15

_SCHEMA = {
    "node": (np.int32, (), -1),
    "mesh": (np.int32, (), -1),
    "submesh": (np.int32, (), 0),
    "material": (np.int32, (), -1),
    "visible": (np.bool_, (), True),
    "bounds_center": (np.float64, (3,), 0.0),
    "bounds_radius": (np.float32, (), 0.0),
    "offset": (np.float64, (3,), 0.0),
    "world_center": (np.float64, (3,), 0.0),
    "world_radius": (np.float32, (), 0.0),
    "drawn": (np.bool_, (), False),
}


class InstanceTable(Table):
    """Drawables by row; `node` names the NodeTable's row. World spheres and `drawn` follow at `update()`.

    A removed row stays as a hole (`alive` and `drawn` false) until it is used again.
    """

    DERIVED: ClassVar[frozenset[str]] = frozenset({"offset", "world_center", "world_radius", "drawn"})

    def __init__(self, nodes: NodeTable) -> None:
        super().__init__("instance", _SCHEMA)
        self._nodes = nodes
        self._stale_spheres = self._stale_drawn = False
        self._seen = (0, 0)  # the nodes' transform_rev and visible_rev at the last update
        self._run: int | None = None  # node row - instance row, where that is the same for all
        #: rises with every `update()` that changed a world sphere
        self.bounds_rev = 0
        #: rises with every `update()` that looked at visibility again
        self.drawn_rev = 0
        self._cull = np.ones((5, 0), np.float32)
        #: f8[3]: what `cull_spheres` is relative to, in the scene's middle
        self.cull_origin: F8 = np.zeros(3)

    @property
    def node(self) -> I4:
        """i4[n]: row of the node."""
        return self._view("node")

    @property
    def mesh(self) -> I4:
        """i4[n]: mesh id."""
        return self._view("mesh")

    @property
    def submesh(self) -> I4:
        """i4[n]: index of the submesh in its mesh."""
        return self._view("submesh")

    @property
    def material(self) -> I4:
        """i4[n]: material id."""
        return self._view("material")

    @property
    def visible(self) -> NDArray[np.bool_]:
        """bool[n]: the instance's own switch."""
        return self._view("visible")

    @property
    def bounds_center(self) -> F8:
        """f8[n,3]: centre of the bounding sphere, in mesh space."""
        return self._view("bounds_center")

    @property
    def bounds_radius(self) -> F4:
        """f4[n]: radius of the bounding sphere, in mesh space."""
        return self._view("bounds_radius")

    @property
    def world_center(self) -> F8:
        """f8[n,3]: centre in the world, as of the last `update()`."""
        return self._view("world_center")

    @property
    def world_radius(self) -> F4:
        """f4[n]: radius in the world, as of the last `update()`; safe also under shear."""
        return self._view("world_radius")

    @property
    def drawn(self) -> NDArray[np.bool_]:
        """bool[n]: alive, visible, and so is its node with all above, as of the last `update()`."""
        return self._view("drawn")

    @property
    def cull_spheres(self) -> F4:
        """f4[5,n], one plane product away from a cull: x, y, z relative to `cull_origin`, radius, 1.

        The radius holds what float32 may be off by: 2^-20 of the coordinates' sum."""
        return self._cull[:, : len(self)]

    def add_many(
        self,
        nodes: ArrayLike,
        meshes: ArrayLike,
        submeshes: ArrayLike,
        materials: ArrayLike,
        bounds_center: ArrayLike,
        bounds_radius: ArrayLike,
        visible: ArrayLike = True,
    ) -> I8:
        """Add k instances and return their rows i8[k]. Bounds are spheres in mesh space: [k,3] and [k].

        All but `nodes` may also be one value for all. Raises InputError for a node that does not exist, a radius below
        zero or a bound that is not finite.
        """
        node = np.atleast_1d(np.asarray(nodes, np.int64))
        self._nodes.select(np.unique(node))
        count = len(node)
        center, radius = _checked_bounds(bounds_center, bounds_radius, count)
        columns = {
            "node": node, "mesh": meshes, "submesh": submeshes, "material": materials, "visible": visible,
        }  # fmt: skip
        try:
            checked = {name: np.broadcast_to(np.asarray(values), (count,)) for name, values in columns.items()}
        except ValueError as error:
            raise InputError(f"{count} instances: a column has another length ({error})") from error
        rows = self._allocate(count)
        where = self.select(rows)
        for name, values in {**checked, "bounds_center": center, "bounds_radius": radius}.items():
            self._data[name][where] = values
        self._stale_spheres = self._stale_drawn = True
        return rows

    def remove(self, rows: Rows) -> None:
        """Remove `rows`."""
        where = self.select(rows)
        self._release(np.arange(where.start, where.stop) if isinstance(where, slice) else np.unique(where))
        self._data["node"][where] = -1
        self._stale_spheres = self._stale_drawn = True

    def remove_of_nodes(self, node_rows: ArrayLike) -> I8:
        """Remove all instances on `node_rows`; return the rows removed."""
        rows = np.flatnonzero(self.alive & np.isin(self.node, node_rows))
        if rows.size:
            self.remove(rows)
        return rows

    def put(self, values: RowValues) -> None:
        super().put(values)
        self._stale_spheres = self._stale_drawn = True

    def set_visible(self, rows: Rows, values: ArrayLike) -> None:
        """Set the instances' own visibility, bool [k] or one for all."""
        self._data["visible"][self.select(rows)] = np.asarray(values, np.bool_)
        self._stale_drawn = True

    def set_material(self, rows: Rows, materials: ArrayLike) -> None:
        """Set material ids [k] or one for all."""
        self._data["material"][self.select(rows)] = materials
        self.structure_rev += 1

    def set_bounds(self, rows: Rows, centers: ArrayLike, radii: ArrayLike) -> None:
        """Set the spheres in mesh space, [k,3] and [k]. Raises InputError as `add_many`."""
        where = self.select(rows)
        center, radius = _checked_bounds(centers, radii, _length(where))
        self._data["bounds_center"][where] = center
        self._data["bounds_radius"][where] = radius
        self._stale_spheres = True

    def set_world_spheres(self, rows: I8, centers: F8, radii: F8) -> None:
        """Overrule the world spheres of `rows` (world, metres) until their nodes move: for what bends, as skins do."""
        relative = centers - self.cull_origin
        slack = np.abs(relative).sum(axis=1) * CULL_SLACK
        self._data["world_center"][rows] = centers
        self._data["world_radius"][rows] = radii * (1.0 + 2.0**-23)
        self._cull[:3, rows] = relative.T
        self._cull[3, rows] = radii * (1.0 + 2.0**-23) + slack
        self.bounds_rev += 1

    def update(self) -> None:
        """Bring world spheres and `drawn` up to date with the nodes, which must have been updated first."""
        nodes = self._nodes
        seen = (nodes.transform_rev, nodes.visible_rev)
        if not (self._stale_spheres or self._stale_drawn or seen != self._seen):
            return
        if self._stale_drawn or seen[1] != self._seen[1]:
            self._update_drawn()
        if self._stale_spheres or seen[0] > self._seen[0] + 1:
            self._update_all()
        elif seen[0] != self._seen[0]:
            self._update_changed()
        self._seen = seen

    def _update_drawn(self) -> None:
        self._stale_drawn = False
        self.drawn_rev += 1
        data, count = self._data, len(self)
        drawn = data["alive"][:count] & data["visible"][:count]
        if count and len(self._nodes):
            drawn &= self._nodes.visible_world[data["node"][:count]]
        data["drawn"][:count] = drawn

    def _update_all(self) -> None:
        self._stale_spheres = False
        count, node = len(self), self.node
        capacity = len(self._data["alive"])
        if self._cull.shape[1] != capacity:
            self._cull = np.ones((5, capacity), np.float32)
        self._run = None
        if count and self.alive_count == count and node[-1] - node[0] == count - 1 and (np.diff(node) == 1).all():
            self._run = int(node[0])
        # a removed row's node is -1: it reads some node's transform, and nobody reads it
        everything = slice(0, count)
        if count and len(self._nodes):
            self._turn(everything)
            self._move(everything, recentre=True)

    def _update_changed(self) -> None:
        nodes, node, rev = self._nodes, self.node, self._nodes.transform_rev
        if len(self) == 0:
            return
        if len(nodes.changed) == nodes.alive_count:
            rows: slice | I8 = slice(0, len(self))
        else:
            rows = np.flatnonzero(nodes.world_rev[node] == rev)
            if rows.size == 0:
                return
        if len(nodes.changed_linear) == nodes.alive_count:
            self._turn(rows)
        elif len(nodes.changed_linear):
            turned = np.flatnonzero(nodes.turn_rev[node] == rev)
            if turned.size:
                self._turn(turned)
        self._move(rows)

    def _turn(self, rows: slice | I8) -> None:
        """Recompute what depends on the linear part: the centre's offset from the node, and the radius."""
        data, world = self._data, self._nodes.world
        for some in blocks(rows):
            linear = world[self._nodes_of(some), :, :3]
            with np.errstate(over="ignore", invalid="ignore"):
                data["offset"][some] = apply(linear, data["bounds_center"][some])
                radius = largest_scale(linear) * data["bounds_radius"][some]
                # rounded up, so that float32 never makes a sphere smaller
                data["world_radius"][some] = radius * (1.0 + 2.0**-23)

    def _move(self, rows: slice | I8, recentre: bool = False) -> None:
        """Place the spheres at their nodes, and their float32 copies for culling."""
        data, cull, world = self._data, self._cull, self._nodes.world
        center = data["world_center"]
        with np.errstate(over="ignore", invalid="ignore"):
            for some in blocks(rows):
                center[some] = world[self._nodes_of(some), :, 3] + data["offset"][some]
            if recentre:
                self.cull_origin = _middle(self.world_center[self.alive])
            for some in blocks(rows):
                slack = np.zeros(_length(some), np.float32)
                for axis in range(3):
                    relative = (center[some, axis] - self.cull_origin[axis]).astype(np.float32)
                    cull[axis, some] = relative
                    slack += np.abs(relative, out=relative)
                slack *= CULL_SLACK
                slack += data["world_radius"][some]
                cull[3, some] = slack
        self.bounds_rev += 1

    def _nodes_of(self, rows: slice | I8) -> slice | I4:
        if self._run is not None and isinstance(rows, slice):
            return slice(rows.start + self._run, rows.stop + self._run)
        nodes: I4 = self._data["node"][rows]
        return nodes


def _length(rows: slice | I8) -> int:
    return rows.stop - rows.start if isinstance(rows, slice) else len(rows)


def _checked_bounds(centers: ArrayLike, radii: ArrayLike, count: int) -> tuple[F8, F4]:
    try:
        center = np.broadcast_to(np.asarray(centers, np.float64), (count, 3))
        radius = np.broadcast_to(np.asarray(radii, np.float32), (count,))
    except ValueError as error:
        raise InputError(f"{count} instances need {count} bounds: {error}") from error
    if not (np.isfinite(center).all() and np.isfinite(radius).all() and (radius >= 0).all()):
        raise InputError("instance bounds must be finite, radii at least 0")
    return center, radius


def _middle(centers: F8) -> F8:
    """Return a whole-metre point amid the centres: the median, which one stray object cannot move."""
    near = centers[(np.abs(centers) < _FARTHEST).all(axis=1)]
    if len(near) == 0:
        return np.zeros(3)
    middle: F8 = np.rint(np.median(near, axis=0))
    return middle
