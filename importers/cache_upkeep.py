"""What the cache holds, and pruning it: the least recently used goes first. Safe while others read and write it.

    converted/<key>/    whole sources       textures/, env/, fbx_names/, opened/, refused/   single files
    thumbnails/         pictures of asset files (editor.thumbnail_maker)
    unpacked/           textures decoded for software rasterisers (engine.resources.unpack, under 512 MiB)
    programs/           compiled shader programs (engine.gpu.program_cache, which keeps itself under 256 MiB)

An entry is renamed before it is deleted, so nobody finds half of one; who was copying it makes it again. A shared store
is not pruned from here: object stores have rules for that.
"""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from engine.core.errors import UsageError
from engine.core.paths import user_cache_dir
from importers.cache import RECORD, owner

#: what is an entry in each folder of the cache: a whole folder, or a file. Others (references) are not ours to prune.
FOLDERS = {
    "converted": True, "textures": False, "env": False, "fbx_names": False, "opened": False, "refused": False,
    "programs": False, "thumbnails": False, "unpacked": False,
}  # fmt: skip
#: seconds after which what no living process owns is litter
ABANDONED = 3600.0
_UNITS = {"": 1, "b": 1, "kb": 10**3, "mb": 10**6, "gb": 10**9, "tb": 10**12, "kib": 2**10, "mib": 2**20, "gib": 2**30}
_TIMES = {"s": 1, "m": 60, "h": 3600, "d": 86400, "w": 604800}


@dataclass(frozen=True, slots=True)
class Kept:
    """One entry: its folder or file, bytes, and when it was last used (seconds since 1970). `litter`: left by a
    process that died."""

    path: Path
    kind: str
    size: int
    used: float
    litter: bool = False


def entries(root: Path | None = None) -> list[Kept]:
    """Everything in the cache, the least recently used first."""
    root = root or user_cache_dir()
    found = [kept for kind, whole in FOLDERS.items() for kept in _entries(root / kind, kind, whole)]
    return sorted(found, key=lambda kept: (not kept.litter, kept.used, str(kept.path)))


def prune(
    max_size: int | None = None, older_than: float | None = None, *, dry_run: bool = False, root: Path | None = None,
    now: float | None = None,
) -> list[Kept]:  # fmt: skip
    """Remove litter, what was not used for `older_than` seconds, and then the least recently used until all fits into
    `max_size` bytes. Returns what was (would be) removed."""
    now = time.time() if now is None else now
    everything = entries(root)
    left = sum(kept.size for kept in everything)
    removed = []
    for kept in everything:
        old = older_than is not None and now - kept.used > older_than
        if kept.litter or old or (max_size is not None and left > max_size):
            left -= kept.size
            removed.append(kept)
            if not dry_run:
                _remove(kept.path)
    return removed


def parse_size(text: str) -> int:
    """`5GB`, `500 MB`, `1GiB`, `1000` -> bytes. Raises UsageError."""
    number, unit = _split(text)
    if number < 0 or unit not in _UNITS:
        raise UsageError(f"{text!r} is no size", hint="as 5GB, 500MB, 1GiB or a number of bytes")
    return int(number * _UNITS[unit])


def parse_age(text: str) -> float:
    """`30d`, `12h`, `45m` -> seconds. Raises UsageError."""
    number, unit = _split(text)
    if number < 0 or unit not in _TIMES:
        raise UsageError(f"{text!r} is no age", hint="as 30d, 12h, 2w or 45m")
    return number * _TIMES[unit]


def _split(text: str) -> tuple[float, str]:
    text = text.strip().lower()
    digits = text.rstrip("abcdefghijklmnopqrstuvwxyz ")
    try:
        return float(digits.replace("_", "")), text[len(digits) :].strip()
    except ValueError:
        return -1.0, ""


def _entries(folder: Path, kind: str, whole: bool) -> Iterator[Kept]:
    try:
        paths = sorted(folder.iterdir())
    except OSError:
        return
    for path in paths:
        try:
            if path.name.startswith("."):
                if path.name.endswith(".tmp") and time.time() - path.stat().st_mtime > ABANDONED:
                    yield Kept(path, kind, _size(path), path.stat().st_mtime, litter=True)
            elif whole and path.is_dir():
                record = path / RECORD
                used = record.stat().st_mtime if record.is_file() else 0.0
                yield Kept(path, kind, _size(path), used, litter=not record.is_file())
            elif path.is_file():
                info = path.stat()
                yield Kept(path, kind, info.st_size, max(info.st_mtime, info.st_atime))
        except OSError:
            continue  # somebody else removed it


def _size(path: Path) -> int:
    return sum(p.stat().st_size for p in path.rglob("*") if p.is_file()) if path.is_dir() else path.stat().st_size


def _remove(path: Path) -> None:
    try:
        if path.is_dir():
            aside = Path(tempfile.mkdtemp(prefix=f".pruned.{owner()}.", suffix=".tmp", dir=path.parent))
            path.rename(aside / "entry")
            shutil.rmtree(aside, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
    except OSError:
        return  # in use (Windows), or gone already: the next prune
