"""What Assimp may open: regular files in the source's own folder, each noted with its bytes' digest.

Assimp follows whatever path a file names, up and out of its folder; through these callbacks it cannot.
Source: cfileio.h of Assimp (aiFileIO, aiFile).
"""

from __future__ import annotations

import ctypes as c
import hashlib
from pathlib import Path

_SUCCESS, _FAILURE = 0, -1


class File(c.Structure):
    pass


class FileIO(c.Structure):
    pass


_Read = c.CFUNCTYPE(c.c_size_t, c.POINTER(File), c.c_void_p, c.c_size_t, c.c_size_t)
_Tell = c.CFUNCTYPE(c.c_size_t, c.POINTER(File))
_Flush = c.CFUNCTYPE(None, c.POINTER(File))
_Seek = c.CFUNCTYPE(c.c_int, c.POINTER(File), c.c_size_t, c.c_int)
_Open = c.CFUNCTYPE(c.c_void_p, c.POINTER(FileIO), c.c_char_p, c.c_char_p)
_Close = c.CFUNCTYPE(None, c.POINTER(FileIO), c.POINTER(File))
File._fields_ = [
    ("read", _Read), ("write", _Read), ("tell", _Tell), ("size", _Tell), ("seek", _Seek), ("flush", _Flush),
    ("user", c.c_void_p),
]  # fmt: skip
FileIO._fields_ = [("open", _Open), ("close", _Close), ("user", c.c_void_p)]


class FileAccess:
    """Opens files for Assimp. `seen`: name relative to the source's folder -> digest ("" where there is none).

    `most`: bytes of all files that are open together; beyond it a file counts as missing."""

    def __init__(self, source: Path, outside: bool, most: int) -> None:
        self.seen: dict[str, str] = {}
        self.refused: list[str] = []
        self._source = source.resolve()
        self._root = self._source.parent
        self._outside = outside
        self._left = most
        self._files: dict[int, tuple[File, bytes, list[int]]] = {}
        # kept here: ctypes does not keep callbacks alive
        self._callbacks = (
            _Read(self._read), _Read(lambda *_: 0), _Tell(self._tell), _Tell(self._size), _Seek(self._seek),
            _Flush(lambda _: None),
        )  # fmt: skip
        self._entry = (_Open(self._open), _Close(self._close))
        self.io = FileIO(*self._entry, None)

    def _open(self, _: object, name: bytes, mode: bytes) -> int | None:
        if b"w" in mode or b"a" in mode:
            return None
        path = self._allowed(name.decode("utf-8", "surrogateescape"))
        if path is None:
            return None
        try:
            data = path.read_bytes() if path.is_file() and path.stat().st_size <= self._left else None
        except OSError:
            data = None
        if path != self._source:
            short = path.relative_to(self._root).as_posix() if path.is_relative_to(self._root) else str(path)
            self.seen[short] = "" if data is None else hashlib.blake2b(data, digest_size=16).hexdigest()
        if data is None:
            return None
        self._left -= len(data)
        file = File(*self._callbacks, None)
        address = c.addressof(file)
        self._files[address] = (file, data, [0])
        return address

    def _allowed(self, name: str) -> Path | None:
        """The file of that name in the source's folder; None (noted) for one that lies elsewhere."""
        try:
            path = (self._root / name.replace("\\", "/")).resolve()
        except (OSError, ValueError, RuntimeError):
            return None
        if path == self._source or self._outside or path.is_relative_to(self._root):
            return path
        self.refused.append(name.replace("\\", "/").rpartition("/")[2])
        return None

    def _close(self, _: object, file: object) -> None:
        entry = self._files.pop(self._address(file), None)
        if entry is not None:
            self._left += len(entry[1])

    def _read(self, file: object, target: int, size: int, count: int) -> int:
        _, data, place = self._files[self._address(file)]
        if not size or not count:
            return 0
        whole = min(count, (len(data) - place[0]) // size)
        c.memmove(target, data[place[0] : place[0] + whole * size], whole * size)
        place[0] += whole * size
        return whole

    def _tell(self, file: object) -> int:
        return self._files[self._address(file)][2][0]

    def _size(self, file: object) -> int:
        return len(self._files[self._address(file)][1])

    def _seek(self, file: object, offset: int, origin: int) -> int:
        _, data, place = self._files[self._address(file)]
        # an unsigned offset that means a step back
        signed = offset - (1 << 64) if offset >> 63 else offset
        wanted = (0, place[0], len(data))[origin] + signed if 0 <= origin <= 2 else -1
        if not 0 <= wanted <= len(data):
            return _FAILURE
        place[0] = wanted
        return _SUCCESS

    @staticmethod
    def _address(file: object) -> int:
        return c.addressof(file.contents)  # type: ignore[attr-defined]  # a pointer made by ctypes
