"""ProgramCache: compiled programs as the driver gives them out, kept from one start to the next.

    key = sha256(engine version, driver, every stage's whole text) ──► <user cache>/programs/<key>.bin
    file = header (magic, driver's format, length, sha256 of the rest) + the driver's bytes

A driver takes back what it gave out itself and nothing else, so its name and version are in the key, and what is
damaged or refused is made again. Nothing here raises: a cache that cannot be read or written is no cache. The defines
and generated blocks stand in the text. Off: LUCARNA_PROGRAM_CACHE=off; a size (`64MB`) limits it.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import struct
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from engine import __version__
from engine.core.atomic import relaxed, write_bytes
from engine.core.errors import OutputError
from engine.core.paths import user_cache_dir

log = logging.getLogger(__name__)

FOLDER, SUFFIX = "programs", ".bin"
#: switches it off, or limits its size
VARIABLE = "LUCARNA_PROGRAM_CACHE"
LIMIT = 256 << 20
#: what is left of the limit when it was reached
KEEP = 0.75
#: driver binaries are some 10 to 500 KB; what is larger than this is not read
MAX_BYTES = 64 << 20
_HEADER = struct.Struct("<4sIQ32s")
_MAGIC = b"LUP1"


@dataclass(frozen=True, slots=True)
class Binary:
    """A linked program in the driver's own `format`."""

    format: int
    data: bytes


class ProgramCache:
    """`identity`: vendor, renderer, version of the driver. `hits`, `misses`: what `get` found."""

    def __init__(self, identity: Iterable[str], *, folder: Path | None = None, limit: int = LIMIT) -> None:
        self.folder = folder or user_cache_dir() / FOLDER
        self.limit = limit
        self.hits = self.misses = 0
        self._salt = "\0".join((__version__, *identity)).encode()
        self._size = -1
        self._writable = True

    def key(self, stages: Iterable[tuple[str, str]]) -> str:
        """Of a program's stages: (name, whole text)."""
        digest = hashlib.sha256(self._salt)
        for stage, text in stages:
            body = text.encode()
            digest.update(f"\0{stage}\0{len(body)}\0".encode())
            digest.update(body)
        return digest.hexdigest()

    def get(self, key: str) -> Binary | None:
        """What was put there, unless it is damaged."""
        path = self._path(key)
        try:
            if path.stat().st_size > MAX_BYTES:
                raise ValueError("too large")
            raw = path.read_bytes()
            magic, format, length, digest = _HEADER.unpack_from(raw)
            data = raw[_HEADER.size :]
            if magic != _MAGIC or len(data) != length or hashlib.sha256(data).digest() != digest:
                raise ValueError("not whole")
        except FileNotFoundError:
            self.misses += 1
            return None
        except (OSError, ValueError, struct.error) as error:
            log.info("%s: %s; it is made again", path, error)
            self.forget(key)
            self.misses += 1
            return None
        with contextlib.suppress(OSError):  # of a cache that is only read
            os.utime(path)
        self.hits += 1
        return Binary(format, data)

    def put(self, key: str, binary: Binary) -> None:
        if not self._writable or not binary.data or len(binary.data) + _HEADER.size > min(self.limit, MAX_BYTES):
            return
        head = _HEADER.pack(_MAGIC, binary.format, len(binary.data), hashlib.sha256(binary.data).digest())
        try:
            with relaxed(self.folder):  # the sum tells whether it is whole
                write_bytes(self._path(key), head + binary.data)
        except OutputError as error:
            log.info("no program cache: %s", error)
            self._writable = False
            return
        self._grow(len(binary.data) + _HEADER.size)

    def forget(self, key: str) -> None:
        """Remove what the driver did not take, or is damaged."""
        try:
            self._path(key).unlink(missing_ok=True)
        except OSError:
            return  # open elsewhere (Windows), or not ours: it is written over

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}{SUFFIX}"

    def _grow(self, size: int) -> None:
        """Count what was written; at the limit the least recently used go."""
        self._size = self._size + size if self._size >= 0 else sum(s for _, s, _ in self._kept())
        if self._size <= self.limit:
            return
        kept = sorted(self._kept())
        self._size = sum(s for _, s, _ in kept)
        for _, bytes_, path in kept:
            if self._size <= KEEP * self.limit:
                break
            self._size -= bytes_
            self.forget(path.stem)

    def _kept(self) -> list[tuple[float, int, Path]]:
        found = []
        try:
            for path in self.folder.glob(f"*{SUFFIX}"):
                info = path.stat()
                found.append((info.st_mtime, info.st_size, path))
        except OSError:
            pass  # somebody else prunes
        return found


def open_cache(identity: Iterable[str]) -> ProgramCache | None:
    """The user's, as LUCARNA_PROGRAM_CACHE says; None where it is off."""
    said = os.environ.get(VARIABLE, "").strip().lower()
    if said in ("off", "0", "no", "false"):
        return None
    return ProgramCache(identity, limit=_bytes(said) or LIMIT)


def _bytes(text: str) -> int:
    """`64mb` -> bytes; 0 for what is no size."""
    units = {"kb": 10**3, "mb": 10**6, "gb": 10**9, "": 1}
    number = text.rstrip("abcdefghijklmnopqrstuvwxyz ")
    unit = text[len(number) :].strip()
    return int(number) * units[unit] if number.isdigit() and unit in units else 0
