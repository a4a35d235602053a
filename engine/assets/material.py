"""MaterialAsset: which effect, with which features, values and textures (`*.material.toml`)."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

QUEUES = ("background", "opaque", "alpha_test", "transparent", "overlay")
WRAPS = ("repeat", "mirror", "clamp")
LEVELS = ("low", "medium", "high")
#: fields of a TextureRef that the sampler group of an effect's slot may say instead
SAMPLING = ("wrap_u", "wrap_v", "min_filter", "mag_filter")
FILTERS = ("nearest", "linear", "nearest_mip_nearest", "linear_mip_nearest", "nearest_mip_linear", "linear_mip_linear")


@dataclass(slots=True)
class TextureRef:
    """A texture in a slot: `path` (POSIX, relative to the material file), sampling, and its uv transform.

    uv' = T(offset) R(rotation) S(scale) uv, with the rotation counter-clockwise in radians (KHR_texture_transform).
    An empty `path` means: wanted but missing; it draws as magenta. `stated`: of wrap_u, wrap_v, min_filter and
    mag_filter those that are meant even where they are the default; others give way to the effect's sampler group.
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
    stated: tuple[str, ...] = ()


@dataclass(slots=True)
class MaterialAsset:
    """`params`, `textures`: by the names that the effect declares. `features`: switched by hand, beside those that the
    textures imply. `extensions` keeps what the source said and the effect cannot show yet. `level`: of the effect's
    techniques (low | medium | high), by hand; '' as the view's quality says.

    `parent`: path of the material that this one comes from, relative to its file; what is here is all of it, inherited
    or not. `files`: the file and its parents. `origin`: dotted key of an inherited value -> the file that says it."""

    name: str
    effect: str = "surface"
    queue: str = "opaque"
    features: list[str] = field(default_factory=list)
    params: dict[str, Any] = field(default_factory=dict)
    textures: dict[str, TextureRef] = field(default_factory=dict)
    extensions: dict[str, Any] = field(default_factory=dict)
    level: str = ""
    parent: str = ""
    files: tuple[Path, ...] = field(default=(), compare=False)
    origin: dict[str, Path] = field(default_factory=dict, compare=False)
