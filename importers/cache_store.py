"""A cache that several machines share: one archive per entry, `URL/<key>.zip`, on anything that fsspec reaches.

    file:///mnt/farm/cache    s3://bucket/cache    memory://cache (tests)    an absolute path

Archives are stored uncompressed, with fixed times, under a temporary name that is renamed: a reader sees a whole one or
none. What comes back is checked against its digests before it is used, so a damaged archive costs time only.
Needs the extra `farm`.
"""

from __future__ import annotations

import uuid
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

from engine.core.errors import LucarnaError, OutputError, UsageError

#: an archive that claims more is not ours
MAX_BYTES = 64 << 30


class Store:
    """The store at `url`. Raises UsageError for a URL of no known kind, LucarnaError without the extra."""

    def __init__(self, url: str) -> None:
        try:
            import fsspec
        except ImportError as error:
            raise LucarnaError("a shared cache needs fsspec", hint="pip install 'lucarna[farm]'") from error
        try:
            self._system, self._root = fsspec.core.url_to_fs(url)
        except (ValueError, ImportError, OSError) as error:
            raise UsageError(
                f"the cache {url!r} cannot be used: {error}", hint="give a path or an fsspec URL"
            ) from error
        self._url = url

    def _path(self, key: str) -> str:
        return f"{self._root.rstrip('/')}/{key}.zip"

    def get(self, key: str, folder: Path) -> bool:
        """Unpack the entry `key` into `folder`; False where there is none, or none that is sound.

        Raises OutputError where the folder cannot be written."""
        try:
            if not self._system.exists(self._path(key)):
                return False
            with self._system.open(self._path(key), "rb") as file:
                return unpack(file, folder)
        except FileNotFoundError:
            return False
        except OSError as error:
            raise self._failed("read", error) from error

    def put(self, key: str, folder: Path, names: Sequence[str]) -> None:
        """Store the files `names` of `folder` as entry `key`. Raises OutputError."""
        target = self._path(key)
        temporary = f"{target}.{uuid.uuid4().hex}.tmp"
        try:
            self._system.makedirs(self._root, exist_ok=True)
            with self._system.open(temporary, "wb") as file, zipfile.ZipFile(file, "w") as archive:
                for name in sorted(names):
                    archive.writestr(zipfile.ZipInfo(name), (folder / name).read_bytes())
            self._system.mv(temporary, target)
        except OSError as error:
            raise self._failed("written", error) from error
        finally:
            self._discard(temporary)

    def _discard(self, path: str) -> None:
        try:
            if self._system.exists(path):
                self._system.rm_file(path)
        except OSError:
            return

    def _failed(self, what: str, error: Any) -> OutputError:
        return OutputError(f"the shared cache cannot be {what}: {error}", where=self._url, hint="check --cache")


def unpack(file: IO[bytes], folder: Path) -> bool:
    """Put the files of an archive into `folder`; False where it is none of ours, or damaged. Raises OutputError."""
    try:
        with zipfile.ZipFile(file) as archive:
            members = archive.infolist()
            plain = all(Path(m.filename).name == m.filename and m.compress_type == zipfile.ZIP_STORED for m in members)
            if not plain or sum(m.file_size for m in members) > MAX_BYTES:
                return False
            for member in members:
                data = archive.read(member)
                try:
                    (folder / member.filename).write_bytes(data)
                except OSError as error:
                    raise OutputError(f"cannot write: {error.strerror or error}", where=folder) from error
        return True
    except (zipfile.BadZipFile, EOFError, ValueError, NotImplementedError):
        return False
