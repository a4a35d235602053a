"""TextureSpec: the format and size of a graph resource, relative to the view, and the bytes it takes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from engine.assets.texture import FORMATS, level_size, mip_extent
from engine.gpu.types import TextureDesc

KINDS = ("2d", "2d-array", "cube", "3d")

#: bytes per texel of the formats that only targets have
TARGET_BYTES = {"rg11b10f": 4, "rgb10a2": 4, "r32ui": 4, "rg32ui": 8, "d32f": 4}


@dataclass(frozen=True, slots=True)
class TextureSpec:
    """What a pass asks for. `size` in pixels, or (when None) `scale` times the view's size, rounded up.

    `mips` 0 means the full chain. `layers` counts array layers, 6 for a cube, the depth of a 3d texture.
    """

    format: str
    scale: float = 1.0
    size: tuple[int, int] | None = None
    kind: str = "2d"
    mips: int = 1
    layers: int = 1

    def problems(self) -> list[str]:
        """What is wrong with this spec, in words; empty when nothing is."""
        found = []
        if self.format not in FORMATS and self.format not in TARGET_BYTES:
            found.append(f"has the unknown format {self.format!r}")
        if self.kind not in KINDS:
            found.append(f"has the unknown kind {self.kind!r}; expected one of {', '.join(KINDS)}")
        if self.size is None and not (math.isfinite(self.scale) and self.scale > 0.0):
            found.append(f"has the scale {self.scale!r}; expected a number above 0")
        if self.size is not None and min(self.size) < 1:
            found.append(f"has the size {self.size[0]}x{self.size[1]}; expected at least 1x1")
        if self.mips < 0 or self.layers < 1:
            found.append(f"has {self.mips} mips and {self.layers} layers; expected mips >= 0, layers >= 1")
        return found

    def resolve(self, view_size: tuple[int, int], label: str = "") -> TextureDesc:
        """The texture of this spec for a view of `view_size` pixels."""
        if self.size is None:
            width, height = (max(1, math.ceil(extent * self.scale)) for extent in view_size)
        else:
            width, height = self.size
        depth = self.layers if self.kind == "3d" else 1
        layers = 6 if self.kind == "cube" else 1 if self.kind == "3d" else self.layers
        full = max(width, height, depth).bit_length()
        return TextureDesc(
            format=self.format, width=width, height=height, kind=self.kind, layers=layers, depth=depth,
            mips=min(self.mips, full) if self.mips else full, label=label,
        )  # fmt: skip


def texture_bytes(desc: TextureDesc) -> int:
    """Bytes of all mips, layers and samples of a texture (tightly packed; drivers may pad)."""
    total = 0
    for level in range(desc.mips):
        width, height = mip_extent(desc.width, level), mip_extent(desc.height, level)
        depth = mip_extent(desc.depth, level)
        if desc.format in TARGET_BYTES:
            total += width * height * depth * TARGET_BYTES[desc.format]
        else:
            total += level_size(desc.format, width, height, depth)
    return total * desc.layers * desc.samples


def human_bytes(count: int) -> str:
    """`3686400` -> `3.5 MiB`."""
    if count < 1024:
        return f"{count} B"
    value, unit = count / 1024.0, "KiB"
    for larger in ("MiB", "GiB"):
        if value < 1024.0:
            break
        value, unit = value / 1024.0, larger
    return f"{value:.1f} {unit}"
