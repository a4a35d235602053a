"""MaterialAsset: which effect, with which features, values and textures (`*.material.toml`)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

QUEUES = ("background", "opaque", "alpha_test", "transparent", "overlay")
WRAPS = ("repeat", "mirror", "clamp")
FILTERS = ("nearest", "linear", "nearest_mip_nearest", "linear_mip_nearest", "nearest_mip_linear", "linear_mip_linear")


@dataclass(slots=True)
class TextureRef:
    """A texture in a slot: `path` (POSIX, relative to the material file), sampling, and its uv transform.

    uv' = T(offset) R(rotation) S(scale) uv, with the rotation counter-clockwise in radians (KHR_texture_transform).
    An empty `path` means: wanted but missing; it draws as magenta.
    """

    path: str
    wrap_u: str = "repeat"
    wrap_v: str = "repeat"
    min_filter: str = "linear_mip_linear"
    mag_filter: str = "linear"
    uv_set: int = 0
    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)


@dataclass(slots=True)
class MaterialAsset:
    """`params`, `textures`: by the names that the effect declares. `features`: switched by hand, beside those that the
    textures imply. `extensions` keeps what the source said and the effect cannot show yet."""

    name: str
    effect: str = "surface"
    queue: str = "opaque"
    features: list[str] = field(default_factory=list)
    params: dict[str, Any] = field(default_factory=dict)
    textures: dict[str, TextureRef] = field(default_factory=dict)
    extensions: dict[str, Any] = field(default_factory=dict)
