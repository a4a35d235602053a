"""The uniform block of the passes of light between surfaces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Buffer

if TYPE_CHECKING:  # frames have programs, and these know requests that know this block
    from engine.render.frame import RenderFrame
from engine.render.gi.choice import BOUNCED, RESTING

BLOCK = layout(
    [
        Field("before_clip", "mat4"),  # relative to this frame's origin -> clip space of the frame before
        Field("before_depth", "vec4"),  # dot(., (p, 1)): view depth in the frame before
        Field("size", "vec4"),  # of the layers: width, height, 1 / width, 1 / height
        Field("scale", "vec2"),  # pixels of the view per texel of the layers
        Field("radius", "float"),  # metres that are gathered from
        Field("separation", "float"),  # metres between the layers at least, and that a surface counts as thick
        Field("strength", "float"),
        Field("boost", "float"),  # of what surfaces reflect again
        Field("distance", "float"),  # metres that reflections reach
        Field("turn", "float"),  # of the pattern from frame to frame, 0 to 1
        Field("known", "float"),  # 1 where the frame before can be asked
        Field("keep", "float"),  # part of what was known that stays
        Field("confidence", "float"),  # 1: the picture is that of what is known
        Field("rests", "float"),  # 1: nothing changed for so long that the plain mean is right
        Field("jitter", "vec2"),  # pixels of the view that the picture is shifted by
    ],
    rule="std140",
)
#: the layers' GLSL in front of surface shaders
PRELUDE = BLOCK.block_glsl("PassBlock_gi", 1, "gi") + "\n"
NAME = "gi"
#: of what the frames before gathered, in each new one, until all has been at rest for a while
KEEP = 0.9


def layer_size(frame: RenderFrame) -> tuple[int, int]:
    """Width and height of the layers."""
    stride = frame.facts.indirect.stride
    return max(1, -(-frame.view.width // stride)), max(1, -(-frame.view.height // stride))


def fill(frame: RenderFrame) -> NDArray[np.void]:
    """One row of BLOCK for this frame."""
    row, settings, look = np.zeros((), BLOCK.dtype), frame.view.settings, frame.look["indirect"]
    width, height = layer_size(frame)
    row["size"] = width, height, 1.0 / width, 1.0 / height
    row["scale"] = frame.view.width / width, frame.view.height / height
    for name in ("radius", "separation", "distance", "before_clip", "before_depth", "turn", "known"):
        row[name] = look[name]
    row["strength"] = settings.gi_strength if frame.facts.indirect.wanted else 0.0
    row["boost"] = settings.gi_boost
    rests = frame.motion.frozen - BOUNCED
    row["keep"] = (1.0 - 1.0 / min(1.0 / (1.0 - KEEP) + max(rests, 0), RESTING)) if look["known"] else 0.0
    row["rests"] = rests > 0
    row["jitter"] = frame.motion.jitter
    row["confidence"] = float(frame.facts.debug_view == "indirect_confidence")
    return row


def block_of(frame: RenderFrame, *, known: bool = True, on: bool = True) -> Buffer:
    """The buffer of this frame's row. Not `known`: what the frames before had is not there; not `on`: the pass runs for
    nothing and must add nothing."""
    row, name = fill(frame), NAME
    if not known:
        row["known"] = row["keep"] = 0.0
        name += " anew"
    if not on:
        row["strength"] = 0.0
        name += " off"
    return frame.pass_block(name, row)
