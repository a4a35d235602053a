"""LightLists: the buffers behind the light lists of tiles, how large they are, and what the last frames counted.

    LightRows.bounds ─► light_bounds ┐
    depth ─► tile_bounds (per tile) ─┤
                                     ├─► view_mask ─► bin_mask (a bin = 4 x 4 tiles) ─► headers + light_list
A bin holds a bit per light of the scene, so a tile only tries what its bin kept: 100,000 lights are tried once per bin.
A tile counts before it takes room in `light_list`. Where the room is short it takes none and its header says "all
lights": that frame is slow and right, `overflow` says so, and a later one has the room.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.gpu.types import Buffer, Device
from engine.render.light_rows import LightBounds
from engine.render.lighting import FIRST_SLICE, SLICE_GROWTH, SLICES, Lighting

#: tiles of a bin, in x and y: one workgroup
BIN = 4
#: bytes of a tile's bounds: five vec4 (shaders/lib/tile_bounds.glsl)
TILE_BYTES = 80
#: counters of a frame: entries taken, tiles that found no room, what these wanted / 256, lights tried, kept,
#: needed by tiles, whether that was counted, needed by pixels
COUNTERS = 8
#: frames until counters are read: by then they are there
LATENCY = 3
#: room of the light list at first, entries a tile
FIRST_ROOM = 128
#: where shaders that light find the lists and the tiles' bounds
LIST_BINDING, TILE_BINDING, BIN_MASK_BINDING, BIN_DEPTH_BINDING = 5, 6, 8, 9


@dataclass(frozen=True, slots=True)
class ListStats:
    """Of one frame: `tiles`; lights `tested`, `kept` in all lists, of those `needed` by a pixel of the tile and
    `in_pixels`, the sum over pixels (-1: not counted); `overflow` lists that had to mean "all lights"."""

    tiles: int = 0
    tested: int = 0
    kept: int = 0
    needed: int = -1
    overflow: int = 0
    in_pixels: int = -1


class LightLists:
    """Sized by `prepare` for a frame; `columns`, `rows` of tiles."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self.bounds: Buffer = device.buffer(32, label="light bounds")
        self.tiles: Buffer = device.buffer(TILE_BYTES, label="light tiles")
        self.view_mask: Buffer = device.buffer(4, label="lights in view")
        self.bin_depth: Buffer = device.buffer(16, label="bin depth")
        self.bin_mask: Buffer = device.buffer(4, label="lights of bins")
        self.list: Buffer = device.buffer(64, label="light lists")
        self._counters = [device.buffer(4 * COUNTERS, label="light counters") for _ in range(LATENCY)]
        self._pending: list[int] = [0] * LATENCY
        self._frame = 0
        self._bounds_seen: LightBounds | None = None
        self.columns = self.rows = self.words = 0
        self.size = 16
        self.stats = ListStats()
        self.shading_storage: dict[int, Buffer] = {}

    @property
    def capacity(self) -> int:
        """Entries of the light list."""
        return self.list.size // 4

    @property
    def bins(self) -> tuple[int, int]:
        return -(-self.columns // BIN), -(-self.rows // BIN)

    @property
    def counters(self) -> Buffer:
        """This frame's."""
        return self._counters[self._frame % LATENCY]

    @property
    def bytes(self) -> int:
        """Of the lists and all that leads to them."""
        parts = (self.bounds, self.tiles, self.view_mask, self.bin_depth, self.bin_mask, self.list)
        return sum(buffer.size for buffer in parts)

    def upload_bounds(self, bounds: LightBounds) -> None:
        """Bring the lights' bounds onto the device; does nothing while they are the same object."""
        if bounds is self._bounds_seen:
            return
        self._bounds_seen = bounds
        self.bounds = self._fit(self.bounds, 32 * max(len(bounds.radius), 1))
        if len(bounds.radius):
            self.bounds.write(bounds_rows(bounds))

    def prepare(self, lighting: Lighting, width: int, height: int, lights: int) -> None:
        """Make room for a view of this size and so many lights, and for what earlier frames wanted."""
        if self._device.caps.software:  # it runs no frames behind: the last one's counters are there
            self.read(wait=True)
        self._frame += 1
        self.size = lighting.tile
        self.columns, self.rows = -(-width // lighting.tile), -(-height // lighting.tile)
        self.words = max(1, -(-lights // 32))
        bins = self.bins[0] * self.bins[1]
        self.tiles = self._fit(self.tiles, self.columns * self.rows * TILE_BYTES)
        self.view_mask = self._fit(self.view_mask, 4 * self.words)
        self.bin_depth = self._fit(self.bin_depth, 16 * bins)
        self.bin_mask = self._fit(self.bin_mask, 4 * bins * self.words)
        self._fit_list(lights)
        self.shading_storage = {
            LIST_BINDING: self.list, TILE_BINDING: self.tiles, BIN_MASK_BINDING: self.bin_mask,
            BIN_DEPTH_BINDING: self.bin_depth,
        }  # fmt: skip
        slot = self._frame % LATENCY
        self._counters[slot].write(np.zeros(COUNTERS, np.uint32))
        self._pending[slot] = self.columns * self.rows

    def forget(self) -> None:
        """This frame has no lists."""
        self.columns = self.rows = 0
        self.shading_storage = {}

    def read(self, *, wait: bool) -> ListStats:
        """What was counted: in this frame if `wait`, else in one that is done by now."""
        slot = self._frame % LATENCY if wait else (self._frame + 1) % LATENCY
        if self._pending[slot]:
            counts = np.frombuffer(self._counters[slot].read(), np.uint32).astype(np.int64)
            counted = bool(counts[6])
            self.stats = ListStats(
                self._pending[slot], int(counts[3]), int(counts[4]), int(counts[5]) if counted else -1, int(counts[1]),
                int(counts[7]) if counted else -1,
            )  # fmt: skip
            self._wanted = int(counts[0] + counts[2] * 256)
            self._pending[slot] = 0
        return self.stats

    def view_fields(self, lighting: Lighting, znear: float) -> tuple[tuple[int, ...], tuple[float, ...]]:
        """`tiles` and `clusters` of the view block."""
        tiles = (self.size.bit_length() - 1, self.capacity, self.columns, self.rows)
        if not lighting.clustered:
            return tiles, (0.0, 0.0, 0.0, 0.0)
        scale = 1.0 / np.log2(SLICE_GROWTH)
        first = np.log2(FIRST_SLICE * max(znear, 1e-6))
        return tiles, (float(scale), float(1.0 - first * scale), float(SLICES), 0.0)

    def release(self) -> None:
        for buffer in (
            self.bounds, self.tiles, self.view_mask, self.bin_depth, self.bin_mask, self.list, *self._counters,
        ):  # fmt: skip
            buffer.release()

    _wanted = 0

    def _fit_list(self, lights: int) -> None:
        tiles = self.columns * self.rows
        first = tiles * min(max(lights, 1), FIRST_ROOM)
        wanted = max(first, self._wanted + self._wanted // 4, 16)
        limit = min(self._device.caps.max_ssbo_bytes, 1 << 28) // 4
        self.list = self._fit(self.list, 4 * min(wanted, max(limit, 16)))

    def _fit(self, buffer: Buffer, size: int) -> Buffer:
        if buffer.size >= size:
            return buffer
        label = buffer.label
        buffer.release()
        return self._device.buffer(size, label=label)


def bounds_rows(bounds: LightBounds) -> NDArray[np.float32]:
    """f4[n,2,4]: centre and radius (endless: 3e38), axis and cosine of the half angle."""
    rows = np.empty((len(bounds.radius), 2, 4), np.float32)
    rows[:, 0, :3] = bounds.center
    rows[:, 0, 3] = np.minimum(bounds.radius, np.float32(3e38))
    rows[:, 1, :3] = bounds.axis
    rows[:, 1, 3] = bounds.cos_angle
    return rows
