"""LightTable: point, spot and directional lights on nodes, and their checked inputs."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.scene import LightAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.scene.nodes import NodeTable
from engine.scene.table import Rows, RowValues, Table

I8 = NDArray[np.int64]

#: LightAsset.type by number.
LIGHT_TYPES = ("directional", "point", "spot")
#: Above these a light is surely a mistake in the file; radiance stays representable.
MAX_INTENSITY, MAX_COLOR, MAX_RANGE = 1e9, 1e4, 1e9

_SCHEMA = {
    "node": (np.int32, (), -1),
    "type": (np.int32, (), 0),
    "color": (np.float64, (3,), 1.0),
    "intensity": (np.float64, (), 1.0),
    "range": (np.float64, (), 0.0),
    "inner": (np.float64, (), 0.0),
    "outer": (np.float64, (), math.pi / 4),
}

#: One light in the world. `radiant` = color * intensity (lux or candela); `direction` is the way the light shines;
#: `range` 0 = endless; `light`, `node` are rows.
WORLD_LIGHT = np.dtype(
    [
        ("position", np.float64, 3),
        ("direction", np.float32, 3),
        ("radiant", np.float32, 3),
        ("range", np.float32),
        ("cos_inner", np.float32),
        ("cos_outer", np.float32),
        ("type", np.int32),
        ("light", np.int32),
        ("node", np.int32),
    ]
)


class LightTable(Table):
    """Lights by row; each shines along its node's -Z. Float64, so that saving gives back what was loaded."""

    def __init__(self, nodes: NodeTable) -> None:
        super().__init__("light", _SCHEMA)
        self._nodes = nodes
        #: rises with every change of a light's own values
        self.rev = 0
        self._cached: tuple[tuple[int, ...], NDArray[np.void]] | None = None

    @property
    def node(self) -> NDArray[np.int32]:
        """i4[n]: row of the node."""
        return self._view("node")

    @property
    def type(self) -> NDArray[np.int32]:
        """i4[n]: index into LIGHT_TYPES."""
        return self._view("type")

    @property
    def color(self) -> NDArray[np.float64]:
        """f8[n,3]: scene-linear Rec.709."""
        return self._view("color")

    @property
    def intensity(self) -> NDArray[np.float64]:
        """f8[n]: lux (directional) or candela (point, spot)."""
        return self._view("intensity")

    @property
    def range(self) -> NDArray[np.float64]:
        """f8[n]: metres, 0 = endless."""
        return self._view("range")

    @property
    def inner(self) -> NDArray[np.float64]:
        """f8[n]: half angle of a spot's full-bright cone, radians."""
        return self._view("inner")

    @property
    def outer(self) -> NDArray[np.float64]:
        """f8[n]: half angle at which a spot's light ends, radians."""
        return self._view("outer")

    def add(self, node: int, light: LightAsset | None = None, findings: Findings | None = None, path: str = "") -> int:
        """Add a light on `node` and return its row; its values are checked by `sanitize`, into `findings`."""
        self._nodes.select(node)
        row = int(self._allocate(1)[0])
        self._data["node"][row] = node
        self._write(row, sanitize(light or LightAsset(), findings, path))
        return row

    def set(self, row: int, findings: Findings | None = None, **values: Any) -> None:
        """Change fields of LightAsset by name, checked by `sanitize`. Raises InputError for an unknown field."""
        self.select(row)
        try:
            light = replace(self.asset(row), **values)
        except TypeError as error:
            raise InputError(f"unknown light value among {', '.join(values)}") from error
        self._write(row, sanitize(light, findings, f"lights[{row}]"))

    def asset(self, row: int) -> LightAsset:
        """Return one light as a LightAsset."""
        self.select(row)
        r, g, b = (float(c) for c in self.color[row])
        return LightAsset(
            LIGHT_TYPES[self.type[row]], (r, g, b), float(self.intensity[row]), float(self.range[row]),
            float(self.inner[row]), float(self.outer[row]),
        )  # fmt: skip

    def put(self, values: RowValues) -> None:
        super().put(values)
        self.rev += 1

    def remove(self, rows: Rows) -> None:
        """Remove `rows`."""
        where = self.select(rows)
        self._release(np.arange(where.start, where.stop) if isinstance(where, slice) else np.unique(where))
        self._data["node"][where] = -1

    def remove_of_nodes(self, node_rows: ArrayLike) -> I8:
        """Remove all lights on `node_rows`; return the rows removed."""
        rows = np.flatnonzero(self.alive & np.isin(self.node, node_rows))
        if rows.size:
            self.remove(rows)
        return rows

    def shining(self) -> I8:
        """Return the rows of lights that give light: alive, on a visible node, with intensity and colour above 0."""
        if len(self) == 0:
            return np.zeros(0, np.int64)
        on = self.alive & self._nodes.visible_world[self.node] & (self.intensity > 0.0) & (self.color > 0.0).any(axis=1)
        return np.flatnonzero(on)

    def world(self) -> NDArray[np.void]:
        """Return the shining lights in the world, WORLD_LIGHT[k] in row order, as of the last update. Cached."""
        nodes = self._nodes
        key = (nodes.transform_rev, nodes.visible_rev, self.rev, self.structure_rev)
        if self._cached is None or self._cached[0] != key:
            self._cached = (key, self._build())
        return self._cached[1]

    def _build(self) -> NDArray[np.void]:
        rows = self.shining()
        out = np.zeros(len(rows), WORLD_LIGHT)
        node = self.node[rows]
        world = self._nodes.world[node] if len(rows) else np.zeros((0, 3, 4))
        back = world[:, :, 2]
        with np.errstate(over="ignore", invalid="ignore"):
            length = np.linalg.norm(back, axis=1, keepdims=True)
            good = (length > 0.0) & np.isfinite(length)
            # a node scaled to nothing has no direction: it shines along the world's -Z
            out["direction"] = np.where(good, -back / np.where(good, length, 1.0), [0.0, 0.0, -1.0])
        out["position"] = np.nan_to_num(world[:, :, 3])
        out["radiant"] = self.color[rows] * self.intensity[rows, None]
        out["range"] = self.range[rows]
        out["cos_inner"] = np.cos(self.inner[rows])
        out["cos_outer"] = np.cos(self.outer[rows])
        out["type"] = self.type[rows]
        out["light"], out["node"] = rows, node
        out.flags.writeable = False
        return out

    def _write(self, row: int, light: LightAsset) -> None:
        data = self._data
        data["type"][row] = LIGHT_TYPES.index(light.type)
        data["color"][row] = light.color
        data["intensity"][row] = light.intensity
        data["range"][row] = light.range
        data["inner"][row], data["outer"][row] = light.inner_angle, light.outer_angle
        self.rev += 1


def sanitize(light: LightAsset, findings: Findings | None = None, path: str = "") -> LightAsset:
    """Return `light` with every value usable; each change becomes a warning in `findings`.

    Not a number counts as 0, negative as 0, too large as the maximum; an outer angle lies in [0, pi/2], an inner one
    in [0, outer]; an unknown type becomes a point light.
    """
    notes = findings if findings is not None else Findings()
    kind = light.type
    if kind not in LIGHT_TYPES:
        notes.warn("light.type", f"unknown light type {kind!r}, taken as point", path, f"use {', '.join(LIGHT_TYPES)}")
        kind = "point"

    def limit(name: str, value: float, high: float) -> float:
        fixed = min(max(float(value), 0.0), high) if value == value else 0.0
        if fixed != value:
            notes.warn("light.range-of-value", f"light {name} {value:g} set to {fixed:g}", path, f"0 to {high:g}")
        return fixed

    color = (*light.color, 0.0, 0.0, 0.0)
    outer = limit("outer_angle", light.outer_angle, math.pi / 2)
    return LightAsset(
        kind,
        (limit("color", color[0], MAX_COLOR), limit("color", color[1], MAX_COLOR), limit("color", color[2], MAX_COLOR)),
        limit("intensity", light.intensity, MAX_INTENSITY),
        limit("range", light.range, MAX_RANGE),
        limit("inner_angle", light.inner_angle, outer),
        outer,
    )
