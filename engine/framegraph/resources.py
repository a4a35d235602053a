"""TextureSpec: the format and size of a graph resource, relative to the view, and the bytes it takes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from engine.gpu.formats import DEPTH, RENDERABLE, texture_bytes
from engine.gpu.types import TextureDesc

__all__ = ["FORMATS", "KINDS", "TextureSpec", "human_bytes", "texture_bytes"]

KINDS = ("2d", "2d-array", "cube", "3d")

#: what a pass can write
FORMATS = RENDERABLE | DEPTH


@dataclass(frozen=True, slots=True)
class TextureSpec:
    """What a pass asks for. `size` in pixels, or (when None) `scale` times the view's size, rounded up.

    `mips` 0 means the full chain. `layers` counts array layers, 6 for a cube, the depth of a 3d texture.
    `samples` > 1 makes it multisampled.
    """

    format: str
    scale: float = 1.0
    size: tuple[int, int] | None = None
    kind: str = "2d"
    mips: int = 1
    layers: int = 1
    samples: int = 1

    def problems(self) -> list[str]:
        """What is wrong with this spec, in words; empty when nothing is."""
        found = []
        if self.format not in FORMATS:
            found.append(
                f"has the format {self.format!r}, which is no target; expected one of {', '.join(sorted(FORMATS))}"
            )
        if self.kind not in KINDS:
            found.append(f"has the unknown kind {self.kind!r}; expected one of {', '.join(KINDS)}")
        if self.size is None and not (math.isfinite(self.scale) and self.scale > 0.0):
            found.append(f"has the scale {self.scale!r}; expected a number above 0")
        if self.size is not None and min(self.size) < 1:
            found.append(f"has the size {self.size[0]}x{self.size[1]}; expected at least 1x1")
        if self.mips < 0 or self.layers < 1:
            found.append(f"has {self.mips} mips and {self.layers} layers; expected mips >= 0, layers >= 1")
        if self.samples < 1 or (self.samples > 1 and (self.kind != "2d" or self.mips != 1)):
            found.append(f"has {self.samples} samples; several need the kind 2d and one mip")
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
            mips=min(self.mips, full) if self.mips else full, samples=self.samples, label=label,
        )  # fmt: skip


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
