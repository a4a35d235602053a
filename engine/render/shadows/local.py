"""LocalShadows: the tiles of a frame's local lights, who casts into each, and when one must be drawn again."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.core.findings import Findings
from engine.gpu.types import Buffer, Device
from engine.render.shadows.atlas import MIN_TILE, divide
from engine.render.shadows.casters import finite_bounds, last_moved
from engine.render.shadows.faces import WIDEST, cube_axes, filter_radius, seen_by, spot_axes, widened
from engine.render.view import View
from engine.scene.scene import Scene

F8 = NDArray[np.float64]

#: of LIGHT_TYPES; all from POINT on are local, and but for spots they shine all around or nearly so
POINT, SPOT = 1, 2
#: texels that lookups of a soft spot may go beyond its cone
SOFT_GUARD = 12.0
#: metres; depth in a tile is NEAR / distance, and nearer things are drawn at its end (reversed, endless)
NEAR = 1e-6
#: vec4s per tile in the buffer
ROWS = 5


@dataclass(frozen=True, slots=True)
class Tile:
    """A square of the atlas, in texels, and what it sees: `axes` f8[3,3] (rows right, up, forward) from `position`
    f8[3] (world), `tangent` of half its angle; nothing that casts is `far` metres away. Equal `key`s are equal
    pictures. `blur`: texels that a filter may reach."""

    x: int
    y: int
    width: int
    position: F8
    axes: F8
    tangent: float
    key: tuple[object, ...]
    far: float = 1.0
    blur: float = 0.0

    def clip_from_origin(self, origin: F8) -> F8:
        """f8[4,4] from the origin-relative world to the tile's clip space (reversed depth, endless)."""
        matrix = np.zeros((4, 4))
        right, up, forward = self.axes
        matrix[0, :3], matrix[1, :3], matrix[3, :3] = right / self.tangent, up / self.tangent, forward
        matrix[:, 3] = -matrix[:, :3] @ (self.position - origin)
        matrix[2, 3] = NEAR
        return matrix

    def unit_from_origin(self, origin: F8) -> F8:
        """The same with w = 1 at `far`: a power of two, so that depths keep their bits."""
        return self.clip_from_origin(origin) / self.far


@dataclass(slots=True)
class LocalShadows:
    """`atlas`: width of the map, 0 where no light casts; `tiles`; `casters` bool[tiles, instances]; `buffer`: what
    shaders/lib/local_shadows.glsl reads. `findings`: which lights go without shadow, and why."""

    device: Device
    buffer: Buffer = field(init=False)
    atlas: int = 0
    tiles: list[Tile] = field(default_factory=list)
    casters: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0), np.bool_))
    findings: Findings = field(default_factory=Findings)
    #: whether the size of one of the lights softens its shadows
    soft: bool = False
    _seen: tuple[object, ...] = ()
    _world: NDArray[np.void] | None = None
    _rows: bytes = b""

    def __post_init__(self) -> None:
        self.buffer = self.device.buffer(16, label="local shadows")

    def update(
        self, scene: Scene, view: View, lights: NDArray[np.void], casting: NDArray[np.bool_], *, receiving: bool,
        state: tuple[object, ...],
    ) -> bool:  # fmt: skip
        """Divide the atlas; True when what casts into it is not what it was at the last call.

        `lights`: WORLD_LIGHT rows in the order of the light buffer. bool[instances]: `casting`. `receiving`: whether
        anything shows shadows. `state`: whatever else changes what casters look like."""
        settings, camera = view.settings, view.camera
        seen = (
            id(scene), scene.transform_rev, scene.instances.bounds_rev, scene.instances.drawn_rev,
            camera.position.tobytes(), camera.ymag, settings.local_shadows, settings.local_shadow_size,
            settings.local_shadow_lights, settings.shadow_softness, settings.soft_lamps, state, receiving,
        )  # fmt: skip
        if seen == self._seen and lights is self._world:
            return False
        self._seen, self._world = seen, lights
        wanted = np.zeros(len(lights), np.bool_)
        if settings.local_shadows != "off" and receiving and casting.any():
            wanted = lights["type"] >= POINT
            if settings.local_shadows == "auto":
                wanted &= lights["casts_shadow"]
        self.findings, self.soft = Findings(), False
        before, self.tiles = [tile.key for tile in self.tiles], []
        rows = np.zeros((len(lights), 4), np.float32)
        masks: list[NDArray[np.bool_]] = []
        if wanted.any():
            rows = self._divide(scene, view, lights, np.flatnonzero(wanted), casting, state, rows, masks)
        self.atlas = _power_of_two(settings.local_shadow_size) if self.tiles else 0
        self._write(rows)
        if before == [tile.key for tile in self.tiles] and self.casters.shape == (len(masks), len(casting)):
            return False
        self.casters = np.array(masks) if masks else np.zeros((0, len(casting)), np.bool_)
        return True

    def _divide(
        self, scene: Scene, view: View, lights: NDArray[np.void], chosen: NDArray[np.intp],
        casting: NDArray[np.bool_], state: tuple[object, ...], rows: NDArray[np.float32],
        masks: list[NDArray[np.bool_]],
    ) -> NDArray[np.float32]:  # fmt: skip
        settings, table = view.settings, scene.instances
        solid = np.flatnonzero(casting & finite_bounds(scene))
        center, radius = table.world_center[solid], table.world_radius[solid].astype(np.float64)
        moved = last_moved(scene, solid)
        atlas = _power_of_two(settings.local_shadow_size)
        part = lights[chosen]
        cone = np.arccos(np.clip(part["cos_outer"].astype(np.float64), -1.0, 1.0))
        one = (part["type"] == SPOT) & (cone <= WIDEST)
        share, weight = _importance(view, part, center, radius)
        tiles = divide(share, weight, np.where(one, 1, 6), atlas, int(settings.local_shadow_lights))
        self._tell(part, tiles.width, settings.local_shadow_lights)
        size = np.hypot(part["half_size"][:, 0], part["half_size"][:, 1]).astype(np.float64)
        soft = (part["half_size"].max(axis=1, initial=0.0) > 0.0) & bool(settings.soft_lamps)
        self.soft = bool((soft & (tiles.width > 0)).any())
        cube = cube_axes()
        blocks = [rows]
        first = len(lights)
        for i in np.flatnonzero(tiles.width):
            light, width = part[i], int(tiles.width[i])
            position = light["position"].astype(np.float64)
            blur = filter_radius(SOFT_GUARD if soft[i] else float(settings.shadow_softness), width)
            inner = math.tan(max(cone[i], 1e-3)) if one[i] else 1.0
            tangent = widened(inner, width, blur)
            views = spot_axes(light["direction"].astype(np.float64))[None] if one[i] else cube
            away = center - position
            near = np.ones(len(solid), np.bool_)
            if light["range"] > 0.0:
                near = np.linalg.norm(away, axis=1) <= float(light["range"]) + size[i] + radius
            rows[chosen[i]] = (first, len(views), blur, float(soft[i]))
            far = _next_power_of_two(float((np.linalg.norm(away[near], axis=1) + radius[near]).max(initial=0.0)))
            for face, axes in enumerate(views):
                x, y = (int(v) for v in tiles.corner[i, face])
                inside = near & seen_by(axes, tangent, away, radius)
                mask = np.zeros(len(casting), np.bool_)
                mask[solid] = inside
                masks.append(mask)
                key = (
                    id(scene), x, y, width, position.tobytes(), axes.tobytes(), tangent,
                    np.packbits(mask).tobytes(), int(moved[inside].max(initial=0)), state, far,
                )  # fmt: skip
                tile = Tile(x, y, width, position, axes, tangent, key, far, blur)
                self.tiles.append(tile)
                blocks.append(_tile_rows(tile, atlas))
                first += ROWS
        return np.concatenate(blocks)

    def _tell(self, lights: NDArray[np.void], width: NDArray[np.int64], most: int) -> None:
        without = int((width == 0).sum())
        if not without:
            return
        why = f"no more than {most} may" if len(lights) > most else f"the atlas has no room left at {MIN_TILE} texels"
        self.findings.warn(
            "light.shadow", f"{without} of {len(lights)} lights that cast shadows go without: {why}",
            hint="raise local_shadow_lights or local_shadow_size, or let fewer lights cast",
        )  # fmt: skip

    def _write(self, rows: NDArray[np.float32]) -> None:
        data = rows.tobytes()
        if data == self._rows:
            return
        self._rows = data
        if self.buffer.size < len(data):
            self.buffer.release()
            self.buffer = self.device.buffer(len(data), label="local shadows")
        if data:
            self.buffer.write(data)

    def release(self) -> None:
        self.buffer.release()


def _importance(view: View, lights: NDArray[np.void], center: F8, radius: F8) -> tuple[F8, F8]:
    """Share of the widest tile, and weight, of each light (atlas.py)."""
    low, high = (center - radius[:, None]).min(axis=0), (center + radius[:, None]).max(axis=0)
    extent = max(float(np.linalg.norm(high - low)) / 2.0, 1e-30)
    own = lights["range"].astype(np.float64)
    reach = np.where(own > 0.0, np.minimum(own, extent), extent)
    away = np.linalg.norm(lights["position"] - view.camera.position, axis=1)
    distance = np.full(len(lights), view.camera.ymag) if view.camera.ymag > 0.0 else away
    share = np.minimum(1.0, reach / np.maximum(distance, 1e-30))
    return share, lights["radiant"].astype(np.float64) @ np.array([0.2126, 0.7152, 0.0722]) * share * share


def _tile_rows(tile: Tile, atlas: int) -> NDArray[np.float32]:
    """f4[ROWS,4]: right, middle u; up, middle v; forward, tangent; half width (uv), texel per metre, near, uv texel;
    far."""
    rows = np.zeros((ROWS, 4), np.float32)
    rows[:3, :3] = tile.axes
    rows[0, 3], rows[1, 3] = (tile.x + tile.width / 2) / atlas, (tile.y + tile.width / 2) / atlas
    rows[2, 3] = tile.tangent
    rows[3] = (tile.width / 2 / atlas, 2.0 * tile.tangent / tile.width, NEAR, 1.0 / atlas)
    rows[4, 0] = tile.far
    return rows


def _next_power_of_two(value: float) -> float:
    return 2.0 ** math.ceil(math.log2(min(max(value, 1e-30), 1e30)))


def _power_of_two(size: int) -> int:
    return 1 << (max(int(size), 1).bit_length() - 1)
