"""What a technique's level may require of a device (`requires = ["tessellation"]`), and which level is chosen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from engine.gpu.types import Caps

LEVELS = ("low", "medium", "high")
#: of the setting and of materials: the highest that the device can do
AUTO = "auto"

REQUIREMENTS: Mapping[str, Callable[[Caps], bool]] = MappingProxyType(
    {
        "hardware": lambda caps: not caps.software,
        "tessellation": lambda caps: caps.tessellation,
        "geometry": lambda caps: caps.geometry,
        "compute": lambda caps: caps.compute,
        "block_compression": lambda caps: caps.bc,
        "anisotropy": lambda caps: caps.max_anisotropy >= 2.0,
        "multisampling": lambda caps: caps.max_samples >= 4,
        "large_textures": lambda caps: caps.max_texture_size >= 8192,
        "large_storage": lambda caps: caps.max_ssbo_bytes >= 1 << 27,
        "reversed_depth": lambda caps: caps.reversed_z,
    }
)


def missing(requires: tuple[str, ...], caps: Caps | None) -> list[str]:
    """Those that the device does not meet; without a device all are taken as met."""
    return [] if caps is None else [word for word in requires if not REQUIREMENTS[word](caps)]


def choose(levels: Mapping[str, tuple[str, ...]], wanted: str, caps: Caps | None) -> tuple[str, str]:
    """(level, why): the highest up to `wanted` (a level or `auto`) whose requirements (`levels`: by level) the device
    meets; where there is none, the lowest above. ('', why) where the device can do none."""
    known = [level for level in LEVELS if level in levels]
    lacking = {level: missing(levels[level], caps) for level in known}
    most = len(LEVELS) - 1 if wanted == AUTO else LEVELS.index(wanted)
    below = [level for level in known if LEVELS.index(level) <= most]
    possible = [level for level in below if not lacking[level]]
    above = [level for level in known if level not in below and not lacking[level]]
    skipped = [f"{level} needs {' and '.join(lacking[level])}" for level in reversed(below) if lacking[level]]
    if possible:
        chosen = possible[-1]
        skipped = [text for text in skipped if LEVELS.index(text.split(" ", 1)[0]) > LEVELS.index(chosen)]
        why = "the only one" if len(known) == 1 else f"{wanted} is wanted" if wanted != AUTO else "the highest"
        if chosen == known[-1] and wanted not in (AUTO, chosen) and len(known) > 1:
            why = f"{wanted} is wanted, there is none above {chosen}"
    elif above:
        chosen, why = above[0], f"{wanted} is wanted, none so low can be drawn"
    else:
        chosen, why = "", "this device can do no level"
    return chosen, f"{why}{'; ' if skipped else ''}{'; '.join(skipped)}"
