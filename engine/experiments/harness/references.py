"""Ground truths that take long, kept in the user's cache: by name, by a hash of all that went in, and by seed."""

from __future__ import annotations

import hashlib
import json
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.atomic import atomic_path
from engine.core.paths import user_cache_dir

Arrays = dict[str, NDArray[Any]]

#: part of every key: raise it when the way references are kept changes
VERSION = 1


class ReferenceCache:
    """`get` returns the arrays of a truth, computed once. Files are rebuildable and safe to delete."""

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder if folder is not None else user_cache_dir() / "references"
        self.used: dict[str, str] = {}

    def path(self, name: str, key: Mapping[str, Any], seed: int = 0) -> Path:
        """Where a reference lies: its name, 16 hex digits of SHA-256 over everything in `key`, and the seed."""
        text = json.dumps({"version": VERSION, "name": name, **key}, sort_keys=True, default=_as_json)
        return self.folder / f"{name}-{hashlib.sha256(text.encode()).hexdigest()[:16]}-seed{seed}.npz"

    def get(self, name: str, key: Mapping[str, Any], make: Callable[[], Arrays], *, seed: int = 0) -> Arrays:
        """The arrays that `make` gives, from the cache where they are there. `key` says all that they depend on.

        A truth that is noisy says so in an array `noise_floor` (one number). A damaged file is made anew.
        """
        found = self.find(name, key, seed=seed)
        return found if found is not None else self.put(name, key, make(), seed=seed)

    def find(self, name: str, key: Mapping[str, Any], *, seed: int = 0) -> Arrays | None:
        """The arrays if they are there and sound."""
        path = self.path(name, key, seed)
        self.used[name] = path.stem
        return _read(path)

    def put(self, name: str, key: Mapping[str, Any], arrays: Mapping[str, Any], *, seed: int = 0) -> Arrays:
        """Keep `arrays`; returns them."""
        made = {k: np.asarray(v) for k, v in arrays.items()}
        with atomic_path(self.path(name, key, seed)) as temporary, temporary.open("wb") as file:
            np.savez_compressed(file, **made)  # type: ignore[arg-type]  # numpy's stub takes allow_pickle from **kwds
        return made


def _read(path: Path) -> Arrays | None:
    if not path.is_file():
        return None
    try:
        # opened here: numpy leaves a damaged file open
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile):
        return None


def _as_json(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return {"shape": value.shape, "sha256": hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()}
    if isinstance(value, (np.integer, np.floating)):
        return value.item()
    if isinstance(value, (set, frozenset)):
        return sorted(value)
    return str(value)
