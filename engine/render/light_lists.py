"""LightLists: the buffers behind the light lists of tiles, how large they are, and what the last frames counted.

    LightRows.bounds ─► bounds, groups ┐
    depth ─► tile_bounds (per tile) ───┤
                                       ├─► view_mask ─► bin_mask (a bin = 4 x 4 tiles) ─► counts ─► light_list
A bin holds a bit per light of the scene, so a tile only tries what its bin kept; 32 lights with bits in one word are
neighbours in space, so that their common box can drop them all at once. Tiles count first. On a software rasteriser,
and elsewhere where nothing is known of such a frame yet, the sum is read and the room made before lists are written;
other frames take what the last ones wanted. Where the room is short, a tile takes none and its header says "all
lights": that frame is slow and right, `overflow` says so, and a later one has the room.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.gpu.types import Buffer, Device
from engine.render.light_groups import GROUP, bounds_rows, group_rows
from engine.render.light_rows import LightBounds
from engine.render.lighting import FIRST_SLICE, SLICE_GROWTH, SLICES, Lighting

#: tiles of a bin, in x and y: one workgroup
BIN = 4
#: bytes of a tile's bounds: five vec4 (shaders/lib/tile_bounds.glsl)
TILE_BYTES = 80
#: counters of a frame: entries taken, lists that found no room, entries wanted / 256 and the rest of that, summed list
#: by list; lights tried; needed by tiles, whether that was counted, needed by pixels
COUNTERS = 8
TAKEN, NO_ROOM, WANTED_256, WANTED_REST, TRIED, NEEDED, COUNTED, IN_PIXELS = range(COUNTERS)
#: frames until counters are read: by then they are there
LATENCY = 3
#: room of the light list before anything was counted, entries a tile
FIRST_ROOM = 32
#: of the light list at most; what a tile lacks then, all lights stand for
MOST_BYTES = 1 << 28
#: where shaders that light find the lists and the tiles' bounds
LIST_BINDING, TILE_BINDING, BIN_MASK_BINDING, BIN_DEPTH_BINDING, BOUNDS_BINDING = 5, 6, 8, 9, 10


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
        self.groups: Buffer = device.buffer(32, label="light groups")
        self.tiles: Buffer = device.buffer(TILE_BYTES, label="light tiles")
        self.view_mask: Buffer = device.buffer(4, label="lights in view")
        self.bin_depth: Buffer = device.buffer(16, label="bin depth")
        self.bin_mask: Buffer = device.buffer(4, label="lights of bins")
        self.bin_parts: Buffer = device.buffer(4, label="words of bins")
        self.list: Buffer = device.buffer(64, label="light lists")
        self._counters = [device.buffer(4 * COUNTERS, label="light counters") for _ in range(LATENCY)]
        self._pending: list[int] = [0] * LATENCY
        self._frame = 0
        self._bounds_seen: LightBounds | None = None
        self._counted: set[tuple[int, ...]] = set()
        self._key: tuple[int, ...] = ()
        self.columns = self.rows = self.words = self.parts = 0
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
        return sum(buffer.size for buffer in self._buffers)

    @property
    def _buffers(self) -> tuple[Buffer, ...]:
        return (
            self.bounds, self.groups, self.tiles, self.view_mask, self.bin_depth, self.bin_mask, self.bin_parts,
            self.list,
        )  # fmt: skip

    def upload_bounds(self, bounds: LightBounds) -> None:
        """Bring the lights' bounds onto the device; does nothing while they are the same object."""
        if bounds is self._bounds_seen:
            return
        self._bounds_seen = bounds
        self.bounds = self._fit(self.bounds, 32 * max(len(bounds.radius), 1))
        if len(bounds.radius):
            self.bounds.write(bounds_rows(bounds))
            groups = group_rows(bounds)
            self.groups = self._fit(self.groups, groups.nbytes)
            self.groups.write(groups)

    def prepare(self, lighting: Lighting, width: int, height: int, lights: int) -> None:
        """Make room for a view of this size and so many lights, and for what earlier frames wanted."""
        self._frame += 1
        self.size = lighting.tile
        self.columns, self.rows = -(-width // lighting.tile), -(-height // lighting.tile)
        self.words = max(1, -(-lights // GROUP))
        self.parts = -(-self.words // 64) * 2
        bins = self.bins[0] * self.bins[1]
        self.tiles = self._fit(self.tiles, self.columns * self.rows * TILE_BYTES)
        self.view_mask = self._fit(self.view_mask, 4 * self.words)
        self.bin_depth = self._fit(self.bin_depth, 16 * bins)
        self.bin_mask = self._fit(self.bin_mask, 4 * bins * self.words)
        self.bin_parts = self._fit(self.bin_parts, 4 * bins * self.parts)
        self._key = (width, height, lights, lighting.tile, lighting.lists)
        self._fit_list(self.columns * self.rows * min(max(lights, 1), FIRST_ROOM))

    def begin(self) -> None:
        """Lists are made now: count from 0."""
        self.counters.write(np.zeros(COUNTERS, np.uint32))
        self._pending[self._frame % LATENCY] = self.columns * self.rows

    @property
    def unsure(self) -> bool:
        """Whether this frame has to wait for its count: it costs nothing where the processor draws; elsewhere a stall,
        once for each size of view, number of lights and size of tiles."""
        return self._device.caps.software or self._key not in self._counted

    def counted(self) -> bool:
        """The tiles of this frame have counted: read how much, and make room. Returns whether the list is another."""
        self._counted.add(self._key)
        counts = np.frombuffer(self.counters.read(), np.uint32).astype(np.int64)
        before = self.capacity
        self._fit_list(int(counts[WANTED_256] * 256 + counts[WANTED_REST]))
        return self.capacity != before

    def forget(self) -> None:
        """This frame has no lists."""
        self.columns = self.rows = 0
        self.shading_storage = {}

    def read(self, *, wait: bool) -> ListStats:
        """What was counted: in this frame if `wait`, else in one that is done by now."""
        slot = self._frame % LATENCY if wait else (self._frame + 1) % LATENCY
        if self._pending[slot]:
            counts = np.frombuffer(self._counters[slot].read(), np.uint32).astype(np.int64)
            counted = bool(counts[COUNTED])
            self._wanted = int(counts[WANTED_256] * 256 + counts[WANTED_REST])
            self.stats = ListStats(
                self._pending[slot], int(counts[TRIED]), self._wanted, int(counts[NEEDED]) if counted else -1,
                int(counts[NO_ROOM]), int(counts[IN_PIXELS]) if counted else -1,
            )  # fmt: skip
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
        for buffer in (*self._buffers, *self._counters):
            buffer.release()

    _wanted = 0

    def _fit_list(self, entries: int) -> None:
        wanted = max(entries, self._wanted)
        limit = min(self._device.caps.max_ssbo_bytes, MOST_BYTES) // 4
        if wanted > self.capacity:  # a quarter more, so that growing lists do not grow it in every frame
            self.list = self._fit(self.list, 4 * min(max(wanted + wanted // 4, 16), max(limit, 16)))
        self.shading_storage = {
            LIST_BINDING: self.list, TILE_BINDING: self.tiles, BIN_MASK_BINDING: self.bin_mask,
            BIN_DEPTH_BINDING: self.bin_depth, BOUNDS_BINDING: self.bounds,
        }  # fmt: skip

    def _fit(self, buffer: Buffer, size: int) -> Buffer:
        if buffer.size >= size:
            return buffer
        label = buffer.label
        buffer.release()
        return self._device.buffer(size, label=label)
