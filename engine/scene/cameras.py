"""CameraTable: lenses on nodes."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.scene import CameraAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.math import transform
from engine.scene.nodes import NodeTable
from engine.scene.table import Rows, RowValues, Table

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]

CAMERA_TYPES = ("perspective", "orthographic")

_DEFAULT = CameraAsset()
_SCHEMA = {
    "node": (np.int32, (), -1),
    "type": (np.int32, (), 0),
    "yfov": (np.float64, (), _DEFAULT.yfov),
    "ymag": (np.float64, (), _DEFAULT.ymag),
    "znear": (np.float64, (), _DEFAULT.znear),
    "zfar": (np.float64, (), _DEFAULT.zfar),
    "aspect": (np.float64, (), _DEFAULT.aspect),
}


class CameraTable(Table):
    """Cameras by row; each looks along its node's -Z. The node's scale does not count."""

    def __init__(self, nodes: NodeTable) -> None:
        super().__init__("camera", _SCHEMA)
        self._nodes = nodes
        #: rises with every change of a camera's own values
        self.rev = 0

    @property
    def node(self) -> NDArray[np.int32]:
        """i4[n]: row of the node."""
        return self._view("node")

    def add(
        self, node: int, camera: CameraAsset | None = None, findings: Findings | None = None, path: str = ""
    ) -> int:
        """Add a camera on `node` and return its row; its values are checked by `sanitize`, into `findings`."""
        self._nodes.select(node)
        row = int(self._allocate(1)[0])
        self._data["node"][row] = node
        self._write(row, sanitize(camera or CameraAsset(), findings, path))
        return row

    def set(self, row: int, findings: Findings | None = None, **values: Any) -> None:
        """Change fields of CameraAsset by name, checked by `sanitize`. Raises InputError for an unknown field."""
        self.select(row)
        try:
            camera = replace(self.asset(row), **values)
        except TypeError as error:
            raise InputError(f"unknown camera value among {', '.join(values)}") from error
        self._write(row, sanitize(camera, findings, f"cameras[{row}]"))

    def asset(self, row: int) -> CameraAsset:
        """Return one camera as a CameraAsset."""
        self.select(row)
        numbers = {f.name: float(self._data[f.name][row]) for f in fields(CameraAsset) if f.name != "type"}
        return CameraAsset(type=CAMERA_TYPES[self._data["type"][row]], **numbers)

    def world_from_camera(self, row: int) -> F8:
        """Return the rigid world_from_camera f8[4,4] of a camera, as of the last update, without any scale."""
        self.select(row)
        t, q, _ = transform.decompose(self._nodes.world_matrix(int(self._data["node"][row])))
        return transform.compose(t, q, np.ones(3))

    def of_node(self, node: int) -> int:
        """Return the first camera on `node`, or -1."""
        rows = np.flatnonzero(self.alive & (self.node == node))
        return int(rows[0]) if rows.size else -1

    def put(self, values: RowValues) -> None:
        super().put(values)
        self.rev += 1

    def remove(self, rows: Rows) -> None:
        """Remove `rows`."""
        where = self.select(rows)
        self._release(np.arange(where.start, where.stop) if isinstance(where, slice) else np.unique(where))
        self._data["node"][where] = -1

    def remove_of_nodes(self, node_rows: ArrayLike) -> I8:
        """Remove all cameras on `node_rows`; return the rows removed."""
        rows = np.flatnonzero(self.alive & np.isin(self.node, node_rows))
        if rows.size:
            self.remove(rows)
        return rows

    def _write(self, row: int, camera: CameraAsset) -> None:
        self._data["type"][row] = CAMERA_TYPES.index(camera.type)
        for f in fields(CameraAsset):
            if f.name != "type":
                self._data[f.name][row] = getattr(camera, f.name)
        self.rev += 1


def sanitize(camera: CameraAsset, findings: Findings | None = None, path: str = "") -> CameraAsset:
    """Return `camera` with every value usable; each change becomes a warning in `findings`.

    A value that is no positive finite number becomes the default; zfar and aspect may be 0 (infinite, of the window);
    a zfar at or before znear becomes 0; an unknown type becomes perspective.
    """
    notes = findings if findings is not None else Findings()

    def fixed(name: str, low: float, high: float, *, zero: bool = False) -> float:
        value, default = float(getattr(camera, name)), float(getattr(_DEFAULT, name))
        if low < value < high or (zero and value == 0.0):
            return value
        notes.warn("camera.value", f"camera {name} {value:g} set to {default:g}", path, f"between {low:g} and {high:g}")
        return default

    kind = camera.type
    if kind not in CAMERA_TYPES:
        notes.warn("camera.type", f"unknown camera type {kind!r}, taken as perspective", path)
        kind = "perspective"
    result = CameraAsset(
        kind,
        yfov=fixed("yfov", 0.0, math.pi),
        ymag=fixed("ymag", 0.0, 1e9),
        # an orthographic box may begin at or behind the camera
        znear=fixed("znear", 0.0 if kind == "perspective" else -1e9, 1e9),
        zfar=fixed("zfar", 0.0, math.inf, zero=True),
        aspect=fixed("aspect", 0.0, 1e6, zero=True),
    )
    if result.zfar and result.zfar <= result.znear:
        notes.warn("camera.value", f"camera zfar {result.zfar:g} is not beyond znear {result.znear:g}, set to 0", path)
        result.zfar = 0.0
    return result
