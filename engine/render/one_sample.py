"""What needs one sample a pixel: filters of the finished picture, the mean of frames, depth of field.

Where a pixel has several samples they do nothing. A choice of one of them therefore brings the number of samples along
where a person makes it (command line, panel, palette); settings that say both are taken as they are, and told about.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

#: settings that need it, and their value that wants nothing
NEEDING: dict[str, object] = {"antialias": "none", "depth_of_field": False}
NEEDS = "needs 1 sample a pixel"


def along(chosen: Mapping[str, Any], samples: int) -> dict[str, int]:
    """What is set along with checked values: one sample a pixel, where one of them needs it and none says how many."""
    needed = any(name in chosen and chosen[name] != off for name, off in NEEDING.items())
    return {"samples": 1} if needed and samples > 1 and "samples" not in chosen else {}


def idle(settings: Mapping[str, Any]) -> dict[str, str]:
    """Those of the settings that do nothing for it, and why."""
    samples = int(settings.get("samples", 1))
    if samples <= 1:
        return {}
    wanted = [name for name, off in NEEDING.items() if name in settings and settings[name] != off]
    return dict.fromkeys(wanted, f"{NEEDS}, and samples is {samples}")


def reason(samples: int, otherwise: str) -> str:
    """Why a pass is left out of a frame whose pixels have so many samples."""
    return f"it {NEEDS}, and there are {samples}" if samples > 1 else otherwise
