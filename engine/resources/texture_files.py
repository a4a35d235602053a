"""TextureFiles: texture files by path as layers of the pool, read once, and again when they change on disk.

get(path) ──► read_dds ──► pool.add ──► PooledTexture          what cannot be read: None, and a finding
reread() ──► changed files ──► the same layer where the size stayed, else another one
             cannot be read any more ──► the last good pixels stay; `errors` says why
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from engine.assets.dds import read_dds
from engine.assets.texture import TextureAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.core.watched import Watched
from engine.resources.texture_pool import PooledTexture, TexturePool


class TextureFiles:
    """`errors`: file -> why its newest contents are not shown; `kept`: those whose last good pixels are."""

    def __init__(self, pool: TexturePool, findings: Findings) -> None:
        self._pool = pool
        self._findings = findings
        self._textures: dict[Path, PooledTexture] = {}
        self._watched = Watched()
        self.errors: dict[Path, InputError] = {}

    def get(self, file: Path) -> PooledTexture | None:
        """The texture of a file (resolved path); None where it cannot be read."""
        if file not in self._textures:
            texture = self._read(file)
            if texture is None:
                return None
            self._textures[file] = self._pool.add(texture)
        return self._textures[file]

    def load(self, files: Iterable[Path]) -> None:
        """Read many at once, with their arrays allocated once."""
        read: dict[Path, TextureAsset] = {}
        for file in dict.fromkeys(files):
            if file not in self._textures:
                texture = self._read(file)
                if texture is not None:
                    read[file] = texture
        self._pool.reserve(list(read.values()))
        for file, texture in read.items():
            self._textures[file] = self._pool.add(texture)

    def kept(self, file: Path) -> bool:
        return file in self._textures

    def changed(self) -> bool:
        """Whether a file is not as it was when last looked at. Any thread may ask."""
        return bool(self._watched.changed())

    def invalidate(self) -> None:
        self._watched.invalidate()

    def reread(self) -> Mapping[Path, bool]:
        """Read changed files again: file -> whether its pixels now are another layer's (else the materials that read it
        stay as they are)."""
        taken: dict[Path, bool] = {}
        for file in sorted(self._watched.take()):
            try:
                texture = read_dds(file)
            except InputError as error:
                self.errors[file] = error
                continue
            self.errors.pop(file, None)
            old = self._textures.get(file)
            self._textures[file] = self._pool.add(texture) if old is None else self._pool.replace(old, texture)
            taken[file] = self._textures[file] != old
        return taken

    def _read(self, file: Path) -> TextureAsset | None:
        self._watched.add([file])
        try:
            return read_dds(file)
        except InputError as error:
            self._findings.error("texture.unreadable", str(error), hint="drawn in magenta; convert the source again")
            return None
