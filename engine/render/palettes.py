"""Skin palettes on the GPU: per joint of every skin a 3x4 affine, from mesh space to the origin-relative world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.gpu.types import Buffer, Device
from engine.scene.scene import Scene


class PaletteRows:
    """`buffer`: three vec4 rows per joint; uploaded when a joint or the origin moved, never where there is no skin."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self.buffer: Buffer = device.buffer(48, label="palettes")
        self._seen: tuple[object, ...] = ()

    def update(self, scene: Scene, origin: NDArray[np.float64]) -> None:
        skins = scene.skins
        seen = (id(scene), skins.structure_rev, scene.transform_rev, origin.tobytes())
        if len(skins) == 0 or seen == self._seen:
            return
        self._seen = seen
        rows = skins.palette(origin)
        if self.buffer.size < rows.nbytes:
            self.buffer.release()
            self.buffer = self._device.buffer(rows.nbytes, label="palettes")
        self.buffer.write(rows)

    def release(self) -> None:
        self.buffer.release()
