"""TOML files laid over each other: `extends` of effects, `parent` of materials. Each key still knows its file.

Tables are merged key by key; everything else, arrays too, is replaced. `false` takes an inherited table away.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from engine.core.errors import Place
from engine.core.toml_source import KeyPath, TomlSource, with_caret


@dataclass(frozen=True, slots=True)
class Merged:
    """`data`: the merged tables, those of the base first. `sources`: the file itself, then what it inherits from."""

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
                if has(source.data, keypath[:length]):
                    return source, source.place(keypath, value=value)
        return self.sources[0], self.sources[0].place(keypath)

    def describe(self, keypath: KeyPath, message: str, *, value: bool = False) -> tuple[str, Place]:
        """The message with its source line and caret, and its place."""
        source, place = self.locate(keypath, value=value)
        return with_caret(message, source.text, place), place


def merged(
    sources: Sequence[TomlSource], files: Sequence[Path], own: frozenset[str] = frozenset(),
    prepare: Callable[[dict[str, Any], int], Mapping[str, Any]] | None = None,
) -> Merged:  # fmt: skip
    """Lay `sources` (the file itself, then what it inherits from) over each other. Keys in `own` are not inherited.

    `prepare`: what of the data of the file with an index is laid over the rest."""
    data: dict[str, Any] = {}
    for index in reversed(range(len(sources))):
        given = sources[index].data
        kept = {key: value for key, value in given.items() if index == 0 or key not in own}
        data = _over(data, prepare(kept, index) if prepare is not None else kept)
    return Merged(data, tuple(sources), tuple(files))


def has(data: Any, keypath: KeyPath) -> bool:
    """Whether there is a value at that key."""
    for part in keypath:
        is_index = isinstance(data, list) and isinstance(part, int) and part < len(data)
        if not is_index and not (isinstance(data, dict) and part in data):
            return False
        data = data[part]
    return True


def _over(base: dict[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    result = dict(base)
    for key, value in over.items():
        old = result.get(key)
        if value is False and isinstance(old, dict):
            del result[key]
            continue
        result[key] = _over(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
    return result
