"""ImportSettings: everything that changes what an import writes, and the limits that keep a hostile source harmless."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass

from engine.core.errors import UsageError

#: Texture encoding effort, from quick looks to final assets.
PRESETS = ("draft", "normal", "high", "final")


@dataclass(frozen=True, slots=True)
class ImportSettings:
    """How a source becomes our files. The same source and settings give the same bytes.

    `preset`: encoder effort, one of PRESETS. `max_texture_size`: larger images are halved until they fit, in texels
    (0 = as they are). `compress`: block-compress textures. `allow_outside`: follow URIs that leave the source's folder.
    The `max_*` limits refuse sources that ask for more than a machine should give; they are no part of `key()`,
    because they decide whether a file loads, never what it becomes.
    """

    preset: str = "normal"
    max_texture_size: int = 0
    compress: bool = True
    allow_outside: bool = False
    use_texture_cache: bool = True
    jobs: int = 0
    max_file_bytes: int = 2 << 30
    max_decoded_bytes: int = 2 << 30
    max_json_depth: int = 128
    max_image_pixels: int = 16384 * 16384
    max_worker_seconds: float = 300.0
    max_worker_bytes: int = 4 << 30

    def __post_init__(self) -> None:
        if self.preset not in PRESETS:
            raise UsageError(f"unknown preset {self.preset!r}", hint=f"choose one of {', '.join(PRESETS)}")
        if self.max_texture_size < 0:
            raise UsageError(f"max_texture_size is {self.max_texture_size}", hint="give texels, or 0 for no limit")

    def key(self) -> str:
        """A stable text of the settings that change the output, for cache keys and provenance."""
        return json.dumps(
            {
                "preset": self.preset,
                "max_texture_size": self.max_texture_size,
                "compress": self.compress,
                "allow_outside": self.allow_outside,
            },
            sort_keys=True,
        )

    def replace(self, **changes: object) -> ImportSettings:
        """A copy with `changes`; raises UsageError as the constructor does."""
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]  # the constructor checks the values
