"""Whether the IES files that a scene's lights name can be read."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from engine.assets.ies import read_ies
from engine.core.errors import InputError
from engine.core.findings import Findings


def check_profiles(profiles: Iterable[str], folder: Path, findings: Findings) -> None:
    """Add what is wrong with the files of those paths, relative to `folder`."""
    for path in dict.fromkeys(p for p in profiles if p):
        notes = Findings(str(folder / path))
        try:
            read_ies(folder / path, notes)
        except InputError as error:
            notes.error("light.profile", error.message, hint=error.hint or "the light shines evenly without it")
        findings.items.extend(notes)
