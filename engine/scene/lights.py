"""LightTable: lights on nodes (directional, point, spot, rectangle, disk), and their checked inputs."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.scene import LightAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.math.blackbody import HIGHEST, LOWEST, black_body
from engine.scene.nodes import NodeTable
from engine.scene.table import Rows, RowValues, Table

I8 = NDArray[np.int64]

#: LightAsset.type by number.
LIGHT_TYPES = ("directional", "point", "spot", "rectangle", "disk")
#: the first of LIGHT_TYPES that has an area
FIRST_AREA = 3
#: Above these a light is surely a mistake in the file; radiance stays representable.
MAX_INTENSITY, MAX_COLOR, MAX_RANGE, MAX_SIZE = 1e9, 1e4, 1e9, 1e6

_SCHEMA = {
    "node": (np.int32, (), -1),
    "type": (np.int32, (), 0),
    "color": (np.float64, (3,), 1.0),
    "intensity": (np.float64, (), 1.0),
    "range": (np.float64, (), 0.0),
    "inner": (np.float64, (), 0.0),
    "outer": (np.float64, (), math.pi / 4),
    "width": (np.float64, (), 1.0),
    "height": (np.float64, (), 1.0),
    "two_sided": (np.bool_, (), False),
    "temperature": (np.float64, (), 0.0),
    "profile": (np.int32, (), -1),
    "casts_shadow": (np.bool_, (), False),
    "radius": (np.float64, (), 0.0),
}

#: One light in the world. `radiant` = color * intensity (lux, candela or nit); `direction` is the way the light shines,
#: `right` the node's X beside it; `range` 0 = endless; `half_size` of area lights, else both the radius; `profile`
#: indexes LightTable.profiles, -1 = none; `light`, `node` are rows.
WORLD_LIGHT = np.dtype(
    [
        ("position", np.float64, 3),
        ("direction", np.float32, 3),
        ("radiant", np.float32, 3),
        ("range", np.float32),
        ("cos_inner", np.float32),
        ("cos_outer", np.float32),
        ("type", np.int32),
        ("right", np.float32, 3),
        ("half_size", np.float32, 2),
        ("two_sided", np.bool_),
        ("profile", np.int32),
        ("casts_shadow", np.bool_),
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
        #: paths of IES files that lights name; only ever longer, so that a remembered row's index stays right
        self.profiles: list[str] = []
        self._cached: tuple[tuple[int, ...], NDArray[np.void]] | None = None
        self._cached_transforms = -1

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
        """f8[n]: lux (directional), candela (point, spot) or nit (rectangle, disk)."""
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

    @property
    def width(self) -> NDArray[np.float64]:
        """f8[n]: metres along the node's X, of area lights."""
        return self._view("width")

    @property
    def height(self) -> NDArray[np.float64]:
        """f8[n]: metres along the node's Y, of area lights."""
        return self._view("height")

    @property
    def two_sided(self) -> NDArray[np.bool_]:
        """bool[n]: whether an area light shines along +Z too."""
        return self._view("two_sided")

    @property
    def temperature(self) -> NDArray[np.float64]:
        """f8[n]: kelvin, 0 = none."""
        return self._view("temperature")

    @property
    def profile(self) -> NDArray[np.int32]:
        """i4[n]: index into `profiles`, -1 = none."""
        return self._view("profile")

    @property
    def casts_shadow(self) -> NDArray[np.bool_]:
        """bool[n]: whether things hide its light (of a directional one: no matter)."""
        return self._view("casts_shadow")

    @property
    def radius(self) -> NDArray[np.float64]:
        """f8[n]: metres, of what shines in a point or spot light."""
        return self._view("radius")

    def add(self, node: int, light: LightAsset | None = None, findings: Findings | None = None, path: str = "") -> int:
        """Add a light on `node` and return its row; its values are checked by `sanitize`, into `findings`."""
        self._nodes.select(node)
        row = int(self._allocate(1)[0])
        self._data["node"][row] = node
        self._write(row, sanitize(light or LightAsset(), findings, path))
        return row

    def add_many(
        self, nodes: ArrayLike, light: LightAsset, color: ArrayLike | None = None, intensity: ArrayLike | None = None
    ) -> I8:
        """Add a light like `light` on each of `nodes` [n]; `color` f8[n,3] and `intensity` f8[n] are each one's own.

        Returns their rows. Values are kept within the limits of `sanitize`.
        """
        node_rows = np.asarray(nodes, np.int64).reshape(-1)
        self._nodes.select(node_rows)
        like = sanitize(light)
        rows = self._allocate(len(node_rows))
        data = self._data
        data["node"][rows] = node_rows
        colors = np.nan_to_num(np.asarray(like.color if color is None else color, np.float64))
        powers = np.nan_to_num(np.asarray(like.intensity if intensity is None else intensity, np.float64))
        values: dict[str, Any] = {
            "type": LIGHT_TYPES.index(like.type), "color": np.clip(colors, 0.0, MAX_COLOR),
            "intensity": np.clip(powers, 0.0, MAX_INTENSITY), "range": like.range, "inner": like.inner_angle,
            "outer": like.outer_angle, "width": like.width, "height": like.height, "two_sided": like.two_sided,
            "temperature": like.temperature, "profile": self.profile_index(like.profile),
            "casts_shadow": like.casts_shadow, "radius": like.radius,
        }  # fmt: skip
        for name, value in values.items():
            data[name][rows] = value
        self.rev += 1
        return rows

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
        profile = int(self.profile[row])
        return LightAsset(
            LIGHT_TYPES[self.type[row]], (r, g, b), float(self.intensity[row]), float(self.range[row]),
            float(self.inner[row]), float(self.outer[row]), float(self.width[row]), float(self.height[row]),
            bool(self.two_sided[row]), float(self.temperature[row]), self.profiles[profile] if profile >= 0 else "",
            bool(self.casts_shadow[row]), float(self.radius[row]),
        )  # fmt: skip

    def profile_index(self, path: str) -> int:
        """Return the index of `path` in `profiles`, which it is added to; -1 for ""."""
        if path and path not in self.profiles:
            self.profiles.append(path)
        return self.profiles.index(path) if path else -1

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
        """Return the shining lights in the world, WORLD_LIGHT[k] in row order, as of the last update.

        The same array as long as neither a light nor its node changed: a scene may move around its lights.
        """
        nodes = self._nodes
        key = (nodes.visible_rev, self.rev, self.structure_rev, nodes.structure_rev)
        if self._cached is not None and self._cached[0] == key:
            cached = self._cached[1]
            moved = nodes.transform_rev != self._cached_transforms
            if not moved or not (nodes.world_rev[cached["node"]] > self._cached_transforms).any():
                self._cached_transforms = nodes.transform_rev
                return cached
        self._cached = (key, self._build())
        self._cached_transforms = nodes.transform_rev
        return self._cached[1]

    def tint(self) -> NDArray[np.float64]:
        """Return f8[n,3]: `color` times that of the temperature, where there is one."""
        warm = self.temperature > 0.0
        if not warm.any():
            return self.color
        out: NDArray[np.float64] = self.color * np.where(warm[:, None], black_body(self.temperature), 1.0)
        return out

    def _build(self) -> NDArray[np.void]:
        rows = self.shining()
        out = np.zeros(len(rows), WORLD_LIGHT)
        node = self.node[rows]
        world = self._nodes.world[node] if len(rows) else np.zeros((0, 3, 4))
        back, back_good = _unit(world[:, :, 2])
        # a node scaled to nothing has no direction: it shines along the world's -Z
        back = np.where(back_good, back, [0.0, 0.0, 1.0])
        out["direction"] = -back
        out["position"] = np.nan_to_num(world[:, :, 3])
        area = self.type[rows] >= FIRST_AREA
        turned = area | (self.profile[rows] >= 0)
        if turned.any():
            out["right"][turned] = _beside(world[turned, :, 0], back[turned])
        out["radiant"] = self.tint()[rows] * self.intensity[rows, None]
        out["range"] = self.range[rows]
        out["cos_inner"] = np.cos(self.inner[rows])
        out["cos_outer"] = np.cos(self.outer[rows])
        out["type"] = self.type[rows]
        size = np.stack([self.width[rows], self.height[rows]], axis=1) / 2.0
        round_ = (out["type"] == 1) | (out["type"] == 2)
        out["half_size"] = np.where(area[:, None], size, np.where(round_, self.radius[rows], 0.0)[:, None])
        out["two_sided"] = area & self.two_sided[rows]
        out["profile"] = np.where(area | (out["type"] == 0), -1, self.profile[rows])
        out["casts_shadow"] = self.casts_shadow[rows] & (out["type"] != 0)
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
        data["width"][row], data["height"][row] = light.width, light.height
        data["two_sided"][row] = light.two_sided
        data["temperature"][row] = light.temperature
        data["profile"][row] = self.profile_index(light.profile)
        data["casts_shadow"][row] = light.casts_shadow
        data["radius"][row] = light.radius
        self.rev += 1


def _unit(vectors: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return [k,3] of unit length and bool[k,1]: which of them have a direction."""
    with np.errstate(over="ignore", invalid="ignore"):
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        good = (length > 0.0) & np.isfinite(length)
        return np.where(good, vectors, 0.0) / np.where(good, length, 1.0), good


def _beside(right: NDArray[np.float64], back: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return unit vectors [k,3] at right angles to `back`, next to `right` where that is one."""
    right, _ = _unit(right)
    right, good = _unit(right - (right * back).sum(axis=1, keepdims=True) * back)
    axis = np.where(np.abs(back[:, :1]) < 0.9, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    other, _ = _unit(np.cross(axis, back))
    result: NDArray[np.float64] = np.where(good, right, other)
    return result


def sanitize(light: LightAsset, findings: Findings | None = None, path: str = "") -> LightAsset:
    """Return `light` with every value usable; each change becomes a warning in `findings`.

    Not a number counts as 0, negative as 0, too large as the maximum; an outer angle lies in [0, pi/2], an inner one
    in [0, outer]; a temperature is 0 or that of something that glows; an unknown type becomes a point light.
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
    temperature = limit("temperature", light.temperature, HIGHEST)
    if 0.0 < temperature < LOWEST:
        notes.warn("light.range-of-value", f"light temperature {temperature:g} set to {LOWEST:g}", path, "0 for none")
        temperature = LOWEST
    return LightAsset(
        kind,
        (limit("color", color[0], MAX_COLOR), limit("color", color[1], MAX_COLOR), limit("color", color[2], MAX_COLOR)),
        limit("intensity", light.intensity, MAX_INTENSITY),
        limit("range", light.range, MAX_RANGE),
        limit("inner_angle", light.inner_angle, outer),
        outer,
        limit("width", light.width, MAX_SIZE),
        limit("height", light.height, MAX_SIZE),
        bool(light.two_sided),
        temperature,
        light.profile,
        bool(light.casts_shadow),
        limit("radius", light.radius, MAX_SIZE),
    )
