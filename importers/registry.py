"""Which importer reads a file: by its extension, and where that says nothing, by its first bytes.

Adding a format is one `Importer` row here and a package of its own beside `gltf`; its module is imported when used.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from engine.core.errors import FormatError
from importers.ogre.sniff import is_ogre

if TYPE_CHECKING:
    from importers.model import ImportedModel
    from importers.settings import ImportSettings


@dataclass(frozen=True, slots=True)
class Importer:
    """`module` has `load(path, settings) -> ImportedModel` and `dependencies(path, settings) -> [(uri, path)]`.

    `version` is part of every cache key: raise it whenever the same source would give other bytes.
    """

    name: str
    module: str
    extensions: tuple[str, ...]
    version: int
    sniff: Callable[[bytes], bool]

    def load(self, path: Path, settings: ImportSettings) -> ImportedModel:
        """Read the source. Raises InputError, FormatError; lesser faults are findings of the model."""
        model: ImportedModel = importlib.import_module(self.module).load(path, settings)
        return model

    def dependencies(self, path: Path, settings: ImportSettings) -> list[tuple[str, Path]]:
        """(name in the source, file) of the files that the source reads besides itself."""
        found: list[tuple[str, Path]] = importlib.import_module(self.module).dependencies(path, settings)
        return found


def _is_gltf(head: bytes) -> bool:
    return head.startswith(b"glTF") or (head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{") and b'"asset"' in head)


def _is_fbx(head: bytes) -> bool:
    return head.startswith(b"Kaydara FBX Binary") or (head.lstrip().startswith(b";") and b"FBX" in head[:200])


IMPORTERS = (
    Importer("glTF", "importers.gltf.reader", (".gltf", ".glb"), 1, _is_gltf),
    Importer("FBX", "importers.fbx.reader", (".fbx",), 1, _is_fbx),
    Importer("Ogre", "importers.ogre.reader", (".mesh", ".mesh.xml"), 1, is_ogre),
)


def source_extensions() -> tuple[str, ...]:
    """All extensions that some importer reads, lower case."""
    return tuple(extension for importer in IMPORTERS for extension in importer.extensions)


def find_importer(path: Path) -> Importer:
    """The importer for `path`. Raises FormatError, naming what can be read, where there is none."""
    extension = path.suffix.lower()
    for importer in IMPORTERS:
        if extension in importer.extensions:
            return importer
    if path.is_file():
        with path.open("rb") as file:
            head = file.read(4096)
        for importer in IMPORTERS:
            if importer.sniff(head):
                return importer
    known = ", ".join(source_extensions())
    what = extension or "files without an extension"
    raise FormatError(f"no importer reads {what}", where=path, hint=f"known: {known}")
