"""Content keys: what a source is, wherever it lies. No time stamp is trusted."""

from __future__ import annotations

import hashlib
from pathlib import Path

from engine.core.errors import InputError
from importers.registry import Importer
from importers.settings import ImportSettings

#: raised when `convert` itself would write other bytes for the same model
CONVERT_VERSION = 1


def digest_of(*parts: bytes | str) -> str:
    """A 32-digit hexadecimal BLAKE2b digest of length-prefixed parts."""
    state = hashlib.blake2b(digest_size=16)
    for part in parts:
        data = part.encode("utf-8", "backslashreplace") if isinstance(part, str) else part
        state.update(len(data).to_bytes(8, "little"))
        state.update(data)
    return state.hexdigest()


def source_key(path: Path, importer: Importer, settings: ImportSettings) -> str:
    """The key of a source: its name and bytes, its dependencies' bytes, the settings and the importer's version.

    A dependency that cannot be read counts as missing. Raises InputError, FormatError where the source is unreadable.
    """
    parts = [importer.name, str(importer.version), str(CONVERT_VERSION), settings.key(), path.name, _digest_file(path)]
    for name, file in sorted(importer.dependencies(path, settings)):
        try:
            parts += [name, _digest_file(file)]
        except InputError:
            parts += [name, "missing"]
    return digest_of(*parts)


def _digest_file(path: Path) -> str:
    if not path.is_file():
        raise InputError("there is no such file", where=path)
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16)).hexdigest()
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror or error}", where=path) from error
