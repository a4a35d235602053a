"""Node transforms for the GPU: float64 world rows become float32 rows relative to a point near the camera.

The point (the *origin*) sits on a coarse grid, so a moving camera uploads nothing until it leaves its cell, and a scene
at 10^6 m keeps its digits.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.gpu.types import Buffer, Device
from engine.scene.scene import Scene


def origin_near(position: NDArray[np.float64], znear: float) -> NDArray[np.float64]:
    """The grid point next to `position`. The cell is about 1,000 near distances: float32 resolves 1e-4 of the nearest
    visible thing anywhere in it."""
    cell = 2.0 ** math.floor(math.log2(max(znear, 1e-9) * 1000.0))
    return np.round(position / cell) * cell


class TransformRows:
    """`buffer`: three vec4 rows (a row-major 3x4 affine) per node, storage buffer; behind them, where something asked
    for it, as many of the frame before (`put_before`)."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self.buffer: Buffer = device.buffer(48, label="transforms")
        self.origin: NDArray[np.float64] = np.full(3, np.nan)
        self._rows = np.zeros((0, 3, 4), np.float32)
        self._rev = -1
        #: rises when a row changed
        self.changes = 0

    @property
    def rows(self) -> NDArray[np.float32]:
        """f4[n,3,4] of now; written over by the next update."""
        return self._rows

    def put_before(self, rows: NDArray[np.float32]) -> int:
        """Have the rows of the frame before, f4[n,3,4], behind those of now; returns how many nodes lie before them."""
        count = len(self._rows)
        if self.buffer.size < 2 * count * 48:
            self.buffer.release()
            self.buffer = self._device.buffer(2 * count * 48, label="transforms")
            self.buffer.write(self._rows)
        self.buffer.write(rows, count * 48)
        return count

    def update(self, scene: Scene, origin: NDArray[np.float64], changed: NDArray[np.intp] | None) -> None:
        """Bring the buffer up to date. `changed`: node rows whose world moved since the last call, None = all."""
        world = scene.nodes.world
        count = len(world)
        if count == 0:
            return
        if len(self._rows) != count or self.buffer.size < count * 48:
            self._rows = np.zeros((count, 3, 4), np.float32)
            if self.buffer.size < count * 48:
                self.buffer.release()
                self.buffer = self._device.buffer(max(48, count * 48), label="transforms")
            changed = None
        if not np.array_equal(origin, self.origin):
            self.origin = origin.copy()
            changed = None
        if changed is None:
            first, last = 0, count
        elif len(changed) == 0:
            return
        else:
            first, last = int(changed.min()), int(changed.max()) + 1
        self.changes += 1
        rows = self._rows[first:last]
        with np.errstate(over="ignore", invalid="ignore"):  # beyond float32 is infinitely far: culled, not drawn
            rows[...] = world[first:last]
            np.subtract(world[first:last, :, 3], origin, out=rows[:, :, 3], casting="same_kind")
        self.buffer.write(rows, first * 48)

    def release(self) -> None:
        self.buffer.release()
