"""Skin palettes on the GPU: per joint of every skin a 3x4 affine, from mesh space to the origin-relative world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.findings import Findings
from engine.gpu.types import Buffer, Device
from engine.resources.residency import Residency
from engine.scene.scene import Scene


class PaletteRows:
    """`buffer`: three vec4 rows per joint; uploaded when a joint or the origin moved, never where there is no skin.
    Behind them, where something asked for it, those of the frame before. `rows` f4[joints,3,4]: never written over."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self.buffer: Buffer = device.buffer(48, label="palettes")
        self.rows: NDArray[np.float32] = np.zeros((0, 3, 4), np.float32)
        self._seen: tuple[object, ...] = ()

    def put_before(self, rows: NDArray[np.float32]) -> int:
        """Have the palettes of the frame before, as many, behind those of now; returns how many joints lie before."""
        if self.buffer.size < 2 * self.rows.nbytes:
            self.buffer.release()
            self.buffer = self._device.buffer(2 * self.rows.nbytes, label="palettes")
            self.buffer.write(self.rows)
        self.buffer.write(rows, self.rows.nbytes)
        return len(self.rows)

    def update(self, scene: Scene, origin: NDArray[np.float64]) -> None:
        skins = scene.skins
        seen = (id(scene), skins.structure_rev, scene.transform_rev, origin.tobytes())
        if len(skins) == 0 or seen == self._seen:
            return
        self._seen = seen
        rows = self.rows = skins.palette(origin)
        if self.buffer.size < rows.nbytes:
            self.buffer.release()
            self.buffer = self._device.buffer(rows.nbytes, label="palettes")
        self.buffer.write(rows)

    def release(self) -> None:
        self.buffer.release()


class SkinningCheck:
    """Keeps skins linear whose effects have no feature `dual_quaternion`: they would take its palettes for matrices.

    `findings`: which these are, of the scene last looked at."""

    def __init__(self, residency: Residency) -> None:
        self._residency = residency
        self.findings = Findings()
        self._seen: tuple[object, ...] = ()

    def check(self, scene: Scene) -> None:
        skins, table = scene.skins, scene.instances
        seen = (id(scene), scene.structure_rev, self._residency.structure_rev)
        if seen == self._seen:
            return
        dual = np.append(skins.dual, False)[skins.of_nodes(table.node)] & table.alive
        effects = {m: self._residency.material(m).effect for m in np.unique(table.material[dual]).tolist()}
        lacking = [m for m, e in effects.items() if "skinning" in e.features and "dual_quaternion" not in e.features]
        short = dual & np.isin(table.material, lacking)
        self.findings = Findings()
        for node in np.unique(table.node[short]).tolist():
            names = sorted({effects[m].name for m in table.material[short & (table.node == node)].tolist()})
            self.findings.warn(
                "skin.effect", f"{scene.nodes.name[node]!r} is skinned linearly: no dual_quaternion in effect "
                f"{', '.join(names)}", f"nodes[{node}]", "add the feature to the effect, or set the skinning to linear",
            )  # fmt: skip
        skins.keep_linear(frozenset(np.unique(table.node[short]).tolist()))
        self._seen = (id(scene), scene.structure_rev, self._residency.structure_rev)
