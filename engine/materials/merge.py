"""`extends`: an effect file merged over another (engine.core.toml_merge)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from engine.core.errors import ShaderError
from engine.core.toml_merge import Merged, merged
from engine.core.toml_source import load_toml, with_caret
from engine.materials.suggest import hint

SUFFIX = ".effect.toml"


def effect_name(path: Path) -> str:
    """`surface` of `…/surface.effect.toml`."""
    return path.name.removesuffix(SUFFIX)


def candidates(search: Sequence[Path]) -> dict[str, Path]:
    """All effect files in the search folders and their `effects/`; the first of a name counts."""
    found: dict[str, Path] = {}
    for folder in search:
        for place in (folder, folder / "effects"):
            if place.is_dir():
                for file in sorted(place.glob(f"*{SUFFIX}")):
                    found.setdefault(effect_name(file), file)
    return found


def load_merged(path: Path, search: Sequence[Path]) -> Merged:
    """Read `path` and what it extends. Raises InputError; ShaderError when `extends` leads nowhere or in a circle."""
    files, sources = [path], [load_toml(path)]
    while isinstance(base := sources[-1].data.get("extends"), str):
        known = candidates([files[-1].parent, *search])
        message, advice = f"extends {base!r}, which is not there", hint(base, known)
        if base in known:
            file = known[base]
            if file.resolve() not in [f.resolve() for f in files]:
                files.append(file)
                sources.append(load_toml(file))
                continue
            message, advice = f"extends {base!r}, which extends this again", "break the circle"
        place = sources[-1].place(("extends",), value=True)
        raise ShaderError(with_caret(message, sources[-1].text, place), where=place, hint=advice)
    return merged(sources, files, frozenset({"extends", "name", "doc"}))
