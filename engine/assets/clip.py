"""ClipAsset: one animation clip (`.lanim`): channels of keys for nodes' translation, rotation, scale and weights."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

PATHS = {"translation": 3, "rotation": 4, "scale": 3, "weights": 0}
INTERPOLATIONS = ("step", "linear", "cubic")


@dataclass(slots=True)
class Channel:
    """Keys of one property of one node. `node`: index into the scene's nodes; `target`: that node's name.

    `times` f4[k] seconds, strictly rising; `values` f4[k,c] for step and linear, f4[k,3,c] for cubic
    (in-tangent, value, out-tangent, as glTF). Rotations are xyzw.
    """

    node: int
    path: str
    interpolation: str
    times: NDArray[np.float32]
    values: NDArray[np.float32]
    target: str = ""


@dataclass(slots=True)
class ClipAsset:
    """`start`: the source's own time (s) of this clip's 0; `frame_rate`: its frames per second, 0 = unknown."""

    name: str
    channels: list[Channel] = field(default_factory=list)
    start: float = 0.0
    frame_rate: float = 0.0

    @property
    def duration(self) -> float:
        """Seconds from 0 to the last key of any channel."""
        return max((float(c.times[-1]) for c in self.channels if len(c.times)), default=0.0)
