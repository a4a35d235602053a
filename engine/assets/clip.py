"""ClipAsset: one animation clip (`.lanim`): channels of keys for nodes' translation, rotation, scale and weights."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from engine.assets.key_codes import KeyCodes

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

    @property
    def codes(self) -> KeyCodes | None:
        """The keys as they are stored where that is not float32: then `values` are decoded when first asked for."""
        return None

    def of_node(self, node: int) -> Channel:
        """The same keys for another node."""
        return self if node == self.node else replace(self, node=node)


class CodedChannel(Channel):
    """A channel of keys in 16 bits. `values` are read-only; setting them makes it a channel of float32 keys."""

    __slots__ = ("_codes", "_decoded")

    def __init__(
        self, node: int, path: str, interpolation: str, times: NDArray[np.float32],
        values: NDArray[np.float32] | KeyCodes, target: str = "",
    ) -> None:  # fmt: skip
        self._codes: KeyCodes | None = None
        self._decoded: NDArray[np.float32] | None = None
        if isinstance(values, KeyCodes):
            self._codes = values
        else:
            self._decoded = values
        self.node, self.path, self.interpolation, self.times, self.target = node, path, interpolation, times, target

    @property
    def codes(self) -> KeyCodes | None:
        return self._codes

    @property
    def values(self) -> NDArray[np.float32]:
        if self._decoded is None:
            assert self._codes is not None
            self._decoded = self._codes.decode()
            self._decoded.setflags(write=False)
        return self._decoded

    @values.setter
    def values(self, values: NDArray[np.float32]) -> None:
        self._decoded, self._codes = values, None

    def of_node(self, node: int) -> Channel:
        if node == self.node or self._codes is None:
            return super().of_node(node)
        return CodedChannel(node, self.path, self.interpolation, self.times, self._codes, self.target)


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
