"""Content keys: what a source is, wherever it lies. No time stamp is trusted."""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from engine.core.errors import InputError
from importers.registry import Importer
from importers.settings import ImportSettings
from importers.versions import CONVERT_VERSION

MISSING = "missing"


@dataclass(frozen=True, slots=True)
class Input:
    """A file that an import reads: its name in the source, where it is, and its digest or MISSING."""

    name: str
    path: Path
    digest: str


def digest_of(*parts: bytes | str) -> str:
    """A 32-digit hexadecimal BLAKE2b digest of length-prefixed parts."""
    state = hashlib.blake2b(digest_size=16)
    for part in parts:
        data = part.encode("utf-8", "backslashreplace") if isinstance(part, str) else part
        state.update(len(data).to_bytes(8, "little"))
        state.update(data)
    return state.hexdigest()


def inputs_of(path: Path, importer: Importer, settings: ImportSettings) -> list[Input]:
    """The source itself, then its dependencies by name. One that cannot be read counts as missing.

    Raises InputError, FormatError where the source is unreadable."""
    found = [Input(path.name, path, digest_file(path))]
    for name, file in sorted(importer.dependencies(path, settings)):
        found.append(Input(name, file, digest_or_missing(file)))
    return found


def key_of(inputs: Sequence[Input], importer: Importer, settings: ImportSettings, name: str = "") -> str:
    """The key of what an import of `inputs` gives. `name`: what its files are called, where not as the source is."""
    parts = [importer.name, str(importer.version), CONVERT_VERSION, settings.key(), name]
    for item in inputs:
        parts += [item.name, item.digest]
    return digest_of(*parts)


def source_key(path: Path, importer: Importer, settings: ImportSettings) -> str:
    """The key of a source: its name and bytes, its dependencies' bytes, the settings and the importer's version.

    Raises InputError, FormatError where the source is unreadable."""
    return key_of(inputs_of(path, importer, settings), importer, settings)


def digest_file(path: Path) -> str:
    """The digest of a file's bytes. Raises InputError."""
    if not path.is_file():
        raise InputError("there is no such file", where=path)
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, _blake).hexdigest()
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror or error}", where=path) from error


def digest_or_missing(path: Path) -> str:
    """The digest of a file's bytes; MISSING where it cannot be read or is no regular file."""
    return _digest_text(str(path))


def _digest_text(path: str) -> str:
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):  # noqa: PTH116  (a text: Path costs more than hashing)
            return MISSING
        with open(path, "rb") as file:  # noqa: PTH123  (as above)
            return hashlib.file_digest(file, _blake).hexdigest()
    except (OSError, ValueError):
        return MISSING


def _blake() -> hashlib.blake2b:
    return hashlib.blake2b(digest_size=16)


@dataclass(slots=True)
class Digests:
    """Digests of files and of folders' listings, each looked at once. `ignored`: what listings leave out (absolute)."""

    ignored: frozenset[str] = frozenset()
    _files: dict[str, str] = field(default_factory=dict)
    _listings: dict[str, str] = field(default_factory=dict)

    def file(self, path: Path | str) -> str:
        text = str(path)
        if text not in self._files:
            self._files[text] = _digest_text(text)
        return self._files[text]

    def listing(self, folder: Path | str) -> str:
        """Of the names in a folder; hidden ones, and what we write ourselves, do not count."""
        text = str(folder)
        if text not in self._listings:
            try:
                names = sorted(n for n in os.listdir(text) if not n.startswith("."))  # noqa: PTH208  (names alone: fast)
                names = [n for n in names if os.path.join(text, n) not in self.ignored]  # noqa: PTH118  (as above)
                self._listings[text] = digest_of(*names)
            except OSError:
                self._listings[text] = MISSING
        return self._listings[text]
