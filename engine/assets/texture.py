"""TextureAsset: pixels in their GPU format with all mips; the formats and their block sizes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

#: format -> (block width in texels, bytes per block). Block width 1 = uncompressed.
FORMATS: dict[str, tuple[int, int]] = {
    "r8": (1, 1), "rg8": (1, 2), "rgba8": (1, 4), "rgba8-srgb": (1, 4),
    "r16f": (1, 2), "rg16f": (1, 4), "rgba16f": (1, 8), "r32f": (1, 4), "rg32f": (1, 8), "rgba32f": (1, 16),
    "bc1": (4, 8), "bc1-srgb": (4, 8), "bc3": (4, 16), "bc3-srgb": (4, 16), "bc4": (4, 8), "bc5": (4, 16),
    "bc6h": (4, 16), "bc7": (4, 16), "bc7-srgb": (4, 16),
}  # fmt: skip


def level_size(format: str, width: int, height: int, depth: int = 1) -> int:
    """Bytes of one image of `format`."""
    block, size = FORMATS[format]
    return -(-width // block) * -(-height // block) * depth * size


def mip_extent(extent: int, level: int) -> int:
    return max(1, extent >> level)


@dataclass(slots=True)
class TextureAsset:
    """A 2D texture, array (`layers` > 1), cube (`cube`, layers is a multiple of 6: +x -x +y -y +z -z) or volume.

    `levels[layer][level]` is the bytes of that image, rows top to bottom, tightly packed (memory-mapped where read
    from a file). `extras` keeps what the container said besides.
    """

    format: str
    width: int
    height: int
    levels: list[Sequence[bytes | memoryview]]
    depth: int = 1
    cube: bool = False
    name: str = ""
    extras: dict[str, object] = field(default_factory=dict)

    @property
    def layers(self) -> int:
        return len(self.levels)

    @property
    def mip_count(self) -> int:
        return len(self.levels[0])

    @property
    def byte_size(self) -> int:
        return sum(len(level) for layer in self.levels for level in layer)
