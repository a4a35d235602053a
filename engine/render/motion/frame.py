"""FrameMotion: what a frame knows of the frame before."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.gpu.types import Buffer
from engine.render.draw_states import Batch

#: pixels; of what was not in front of the camera
NOWHERE = 30000.0


@dataclass(slots=True)
class FrameMotion:
    """`known`: the frame before tells about this one; if not, nothing moves. `frames`: how many of this run came before
    this one. `before_from_now` f8[4,4]: from the clip space of this frame to that of the one before, both without
    jitter. `clip_before` f8[4,4]: from the world relative to the origin of before. `jitter`: pixels that the
    picture is shifted right and down by."""

    known: bool = False
    frames: int = 0
    before_from_now: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))
    clip_before: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))
    jitter: tuple[float, float] = (0.0, 0.0)
    #: the camera stands still
    still: bool = True
    #: frames since anything at all changed that could be seen
    frozen: int = 0
    #: what moved and is seen, solid; drawn with `ids` and `commands`
    batches: list[Batch] = field(default_factory=list)
    ids: Buffer | None = None
    commands: Buffer | None = None
    #: rows of now before those of before: nodes, joints, words of the morph table
    nodes: int = 0
    joints: int = 0
    morphs: int = 0
