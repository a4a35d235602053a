"""`extends`: an effect file merged over another; each key still knows the file it came from."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from engine.core.errors import Place, ShaderError
from engine.core.toml_source import KeyPath, TomlSource, load_toml, with_caret
from engine.materials.suggest import hint

SUFFIX = ".effect.toml"


@dataclass(frozen=True, slots=True)
class Merged:
    """`data`: the merged tables, those of the base first. `sources`: the file itself, then what it extends."""

    data: dict[str, Any]
    sources: tuple[TomlSource, ...]
    files: tuple[Path, ...]

    @property
    def source_hash(self) -> str:
        digest = hashlib.sha256()
        for source in self.sources:
            digest.update(source.text.encode("utf-8") + b"\0")
        return digest.hexdigest()

    def locate(self, keypath: KeyPath, *, value: bool = False) -> tuple[TomlSource, Place]:
        """The file that gives `keypath` (or its nearest ancestor), and the place in it."""
        for length in range(len(keypath), -1, -1):
            for source in self.sources:
                if _has(source.data, keypath[:length]):
                    return source, source.place(keypath, value=value)
        return self.sources[0], source.place(keypath)

    def describe(self, keypath: KeyPath, message: str, *, value: bool = False) -> tuple[str, Place]:
        """The message with its source line and caret, and its place."""
        source, place = self.locate(keypath, value=value)
        return with_caret(message, source.text, place), place


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
    data: dict[str, Any] = {}
    for source in reversed(sources):
        own = {k: v for k, v in source.data.items() if source is sources[0] or k not in {"extends", "name", "doc"}}
        data = _merge(data, own)
    return Merged(data, tuple(sources), tuple(files))


def _merge(base: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    """Tables are merged, everything else is replaced."""
    result = dict(base)
    for key, value in over.items():
        old = result.get(key)
        result[key] = _merge(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
    return result


def _has(data: Any, keypath: KeyPath) -> bool:
    for part in keypath:
        is_index = isinstance(data, list) and isinstance(part, int) and part < len(data)
        if not is_index and not (isinstance(data, dict) and part in data):
            return False
        data = data[part]
    return True
