"""Version: what an effect's variants are made from, kept while its successor has yet to prove itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from engine.core.errors import Place, ShaderError
from engine.materials.effect import Effect


@dataclass(frozen=True, slots=True)
class Version:
    """`texts`: the contents of the shader files. `error`: why it is not in use, where it was refused."""

    effect: Effect
    texts: Mapping[Path, str]
    error: ShaderError | None = None

    def says(self, effect: Effect, texts: Mapping[Path, str]) -> bool:
        """Whether that is the same text again."""
        return effect.source_hash == self.effect.source_hash and includes(self.texts, texts)


def includes(known: Mapping[Path, str], texts: Mapping[Path, str]) -> bool:
    """Whether all of `texts` is known, word for word."""
    return all(known.get(path) == text for path, text in texts.items())


def changes(before: Mapping[Path, str], after: Mapping[Path, str]) -> list[Place]:
    """Where the change of each file that both have begins: the first line and column that differ."""
    found = []
    for path, text in after.items():
        old = before.get(path)
        if old is not None and old != text:
            shared = zip(old, text, strict=False)
            at = next((i for i, (a, b) in enumerate(shared) if a != b), min(len(old), len(text)))
            found.append(Place(str(path), text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at)))
    return found
