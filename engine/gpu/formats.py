"""What one texel and one vertex attribute are made of, for every backend."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import DTypeLike

from engine.assets.texture import FORMATS, mip_extent
from engine.core.errors import UsageError
from engine.gpu.types import TextureDesc

#: block width in texels and bytes per block, as in engine.assets.texture.FORMATS, with the target formats added
BLOCKS: dict[str, tuple[int, int]] = {
    **FORMATS, "rg11b10f": (1, 4), "rgb10a2": (1, 4), "r32ui": (1, 4), "rg32ui": (1, 8), "d32f": (1, 4),
    "d32f-s8": (1, 8),
}  # fmt: skip

#: format -> (number type, channels) that Texture.read gives; packed formats come unpacked as f4, blocks decoded
READ_AS: dict[str, tuple[str, int]] = {
    "r8": ("<u1", 1), "rg8": ("<u1", 2), "rgba8": ("<u1", 4), "rgba8-srgb": ("<u1", 4),
    "r16f": ("<f2", 1), "rg16f": ("<f2", 2), "rgba16f": ("<f2", 4),
    "r32f": ("<f4", 1), "rg32f": ("<f4", 2), "rgba32f": ("<f4", 4),
    "rg11b10f": ("<f4", 3), "rgb10a2": ("<f4", 4), "r32ui": ("<u4", 1), "rg32ui": ("<u4", 2), "d32f": ("<f4", 1),
    "d32f-s8": ("<f4", 1),  # its depth
    # blocks come decoded by the driver
    "bc1": ("<u1", 4), "bc1-srgb": ("<u1", 4), "bc3": ("<u1", 4), "bc3-srgb": ("<u1", 4), "bc4": ("<u1", 1),
    "bc5": ("<u1", 2), "bc6h": ("<f2", 4), "bc7": ("<u1", 4), "bc7-srgb": ("<u1", 4),
}  # fmt: skip

INTEGER = frozenset({"r32ui", "rg32ui"})
DEPTH = frozenset({"d32f", "d32f-s8"})
#: those of DEPTH with 8 bits of stencil
STENCIL = frozenset({"d32f-s8"})
SRGB = frozenset(name for name in BLOCKS if name.endswith("-srgb"))
COMPRESSED = frozenset(name for name, (block, _) in BLOCKS.items() if block > 1)
#: formats that image load/store takes
STORABLE = frozenset(BLOCKS) - COMPRESSED - SRGB - DEPTH
#: formats that a colour attachment takes
RENDERABLE = frozenset(BLOCKS) - COMPRESSED - DEPTH


def image_size(desc: TextureDesc, level: int) -> tuple[int, int]:
    """Width and height of one level, in texels."""
    return mip_extent(desc.width, level), mip_extent(desc.height, level)


def image_bytes(desc: TextureDesc, level: int) -> int:
    """Bytes of one image (one layer or slice) of `level`, tightly packed."""
    width, height = image_size(desc, level)
    block, size = BLOCKS[desc.format]
    return -(-width // block) * -(-height // block) * size


def texture_bytes(desc: TextureDesc) -> int:
    """Bytes of all images of a texture, without what the driver adds."""
    total = 0
    for level in range(desc.mips):
        images = mip_extent(desc.depth, level) if desc.kind == "3d" else desc.layers
        total += image_bytes(desc, level) * images
    return total * desc.samples


def read_shape(desc: TextureDesc, level: int) -> tuple[DTypeLike, tuple[int, int, int]]:
    """dtype and shape [height, width, channels] of Texture.read."""
    dtype, channels = READ_AS[desc.format]
    width, height = image_size(desc, level)
    return np.dtype(dtype), (height, width, channels)


@dataclass(frozen=True, slots=True)
class VertexFormat:
    """`base`: f2 f4 i1 i2 i4 u1 u2 u4; `normalized`: reaches the shader as float in [0,1] or [-1,1]; `integer`: as
    int or uint; else as float."""

    base: str
    components: int
    normalized: bool

    @property
    def integer(self) -> bool:
        return not self.normalized and self.base[0] in "iu"

    @property
    def size(self) -> int:
        return int(self.base[1]) * self.components


_VERTEX = re.compile(r"(f2|f4|i1|i2|i4|u1|u2|u4|snorm8|snorm16|unorm8|unorm16)x([1-4])")
_NORMALIZED = {"snorm8": "i1", "snorm16": "i2", "unorm8": "u1", "unorm16": "u2"}


@cache
def vertex_format(name: str) -> VertexFormat:
    """Parse `f4x3`, `snorm16x4`, `u2x4` …; UsageError for anything else."""
    match = _VERTEX.fullmatch(name)
    if not match:
        raise UsageError(f"unknown vertex format {name!r}", hint="write f4x3, f2x2, snorm16x4, unorm8x4, u2x4, u4x1 …")
    kind = match[1]
    return VertexFormat(_NORMALIZED.get(kind, kind), int(match[2]), kind in _NORMALIZED)
