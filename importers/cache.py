"""The cache of converted sources: a source's content names a folder, so moving or touching a file costs nothing.

    <user cache>/converted/<key>/   X.scene.json, … and `import.json` (what the import found)

A folder is made aside and renamed into place: it is there whole or not at all, whoever else is at work. Deleting the
cache is always safe; importers/cache_upkeep.py tells its size and prunes it. With a shared store (any fsspec URL, see
importers/cache_store.py) an entry that is not here is fetched from there, and what is made here is put there, too.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import shutil
import socket
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.core.atomic import relaxed
from engine.core.errors import LucarnaError, OutputError, Place
from engine.core.findings import Finding, Findings, Severity
from engine.core.paths import user_cache_dir
from importers.settings import ImportSettings

if TYPE_CHECKING:
    from importers.cache_store import Store
    from importers.fingerprint import Input
    from importers.registry import Importer

Progress = Callable[[str, float], None]

RECORD = "import.json"
SCENE_SUFFIX = ".scene.json"


@dataclass(slots=True)
class Entry:
    """One converted source in the cache. `outputs`: {name, size, digest} of each file, the scene last; `findings`:
    JSON; `besides`: [name, path, digest] of files that were read without being among the key's inputs."""

    folder: Path
    scene: str
    outputs: list[dict[str, Any]] = field(default_factory=list)
    findings: list[dict[str, Any]] = field(default_factory=list)
    besides: list[list[str]] = field(default_factory=list)

    def extra(self, source: Path) -> list[Input]:
        from importers.fingerprint import Input

        return [Input(name, source.parent / path, digest) for name, path, digest in self.besides]


class Cache:
    """The local cache, and behind it the shared store at `url` where one is given."""

    def __init__(self, url: str = "") -> None:
        self.root = user_cache_dir() / "converted"
        self._url = url

    def _store(self) -> Store | None:
        if not self._url:
            return None
        from importers.cache_store import Store

        return Store(self._url)

    def recall(self, key: str, source: Path) -> Entry | None:
        """The entry of an earlier conversion; None where there is none. A damaged one is removed."""
        folder = self.root / key
        entry = read_entry(folder)
        if entry is None:
            if (folder / RECORD).exists():
                shutil.rmtree(folder, ignore_errors=True)
            store = self._store()
            entry = self._fetch(store, key) if store is not None else None
        if entry is None or any(_digest(item.path) != item.digest for item in entry.extra(source)):
            return None
        try:
            os.utime(folder / RECORD)  # the least recently used are pruned first
        except OSError:
            return entry
        return entry

    def make(
        self, key: str, source: Path, importer: Importer, settings: ImportSettings, name: str,
        progress: Progress | None, read_besides: Callable[[], list[Input]], timings: dict[str, float],
        replace: bool = False,
    ) -> Entry:  # fmt: skip
        """Import `source` and publish the result under `key`. Raises InputError, FormatError, OutputError."""
        import time

        from importers.convert import stage
        from importers.farm.record import relative

        staging = self._staging(key)
        try:
            clock = time.perf_counter()
            model = importer.load(source, settings)
            timings["read"] = time.perf_counter() - clock
            if progress is not None:
                progress(f"read {source.name}", 0.2)
            with relaxed(staging):  # entries are compared with their digests whenever they are copied
                scene = stage(model, importer, source, staging, settings, timings, progress, name).name
            besides = [[item.name, relative(item.path, source.parent), item.digest] for item in read_besides()]
            files = sorted((p for p in staging.iterdir()), key=lambda p: (p.name == scene, p.name))
            outputs = [{"name": p.name, "size": p.stat().st_size, "digest": _digest(p)} for p in files]
            entry = Entry(self.root / key, scene, outputs, [f.to_json() for f in model.findings], besides)
            record = {"scene": scene, "outputs": outputs, "findings": entry.findings, "besides": besides}
            (staging / RECORD).write_text(json.dumps(record, sort_keys=True), encoding="utf-8")
            self._publish(staging, key, replace)
        except OSError as error:
            raise _unwritable(error, self.root) from error
        finally:
            shutil.rmtree(staging, ignore_errors=True)
        store = self._store()
        if store is not None:
            store.put(key, entry.folder, [str(item["name"]) for item in outputs] + [RECORD])
        return entry

    def take_in(self, key: str, archive: bytes) -> None:
        """Publish an entry that another machine made and sent. One that is damaged is dropped. Raises OutputError."""
        from importers.cache_store import unpack

        if read_entry(self.root / key) is None:
            self._adopt(key, lambda staging: unpack(io.BytesIO(archive), staging))

    def _fetch(self, store: Store, key: str) -> Entry | None:
        return self._adopt(key, lambda staging: store.get(key, staging))

    def _adopt(self, key: str, fill: Callable[[Path], bool]) -> Entry | None:
        """Publish what `fill` puts into a folder, if it is whole and sound."""
        staging = self._staging(key)
        try:
            if not fill(staging):
                return None
            entry = read_entry(staging)
            if entry is None or any(_digest(staging / str(item["name"])) != item["digest"] for item in entry.outputs):
                return None  # damaged on its way: make it here
            self._publish(staging, key, False)
            return read_entry(self.root / key)
        except OSError as error:
            raise _unwritable(error, self.root) from error
        finally:
            shutil.rmtree(staging, ignore_errors=True)

    def _staging(self, key: str) -> Path:
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            return Path(tempfile.mkdtemp(prefix=f".{key}.{owner()}.", suffix=".tmp", dir=self.root))
        except OSError as error:
            raise _unwritable(error, self.root) from error

    def _publish(self, staging: Path, key: str, replace: bool) -> None:
        """Give `staging` the name of its entry. With `replace` an entry that is not these very bytes is taken away."""
        folder = self.root / key
        try:
            entry = read_entry(folder)
            if entry is not None and (not replace or _same_bytes(entry, read_entry(staging))):
                return
            if folder.exists():
                aside = Path(tempfile.mkdtemp(prefix=f".{key}.{owner()}.", suffix=".tmp", dir=self.root))
                folder.rename(aside / "old")
                shutil.rmtree(aside, ignore_errors=True)
            staging.rename(folder)
        except OSError as error:
            # Another process may have published the same content first: then that is the result.
            if read_entry(folder) is None:
                raise _unwritable(error, folder) from error


def scene_for(
    path: Path, *, settings: ImportSettings | None = None, progress: Progress | None = None, force: bool = False
) -> tuple[Path, Findings]:
    """The scene of `path`, a *.scene.json itself or a source, which is converted once per content and settings.

    The sidecar and the project of the source have their say (importers.presets); `settings` is what they start from.
    The work is done in a worker process, unless LUCARNA_IN_PROCESS is set. The findings are those of the conversion,
    also where it was done long ago. `force` converts anew.
    Raises InputError, FormatError, OutputError.
    """
    path = Path(path)
    if path.name.lower().endswith(SCENE_SUFFIX):
        return path, Findings(str(path))
    from importers.farm.single import obtain  # here: opening a converted scene needs none of it

    entry = obtain(path, settings or ImportSettings(), progress, force)
    return entry.folder / entry.scene, findings_of(entry.findings, path)


def clear() -> None:
    """Remove all converted scenes and encoded textures."""
    for name in ("converted", "textures", "opened", "merged"):
        shutil.rmtree(user_cache_dir() / name, ignore_errors=True)


def read_entry(folder: Path) -> Entry | None:
    """The entry in `folder`; None where there is none, or it is not whole."""
    try:
        data: dict[str, Any] = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        entry = Entry(folder, data["scene"], data["outputs"], data["findings"], data["besides"])
        findings_of(entry.findings, folder)
        for item in entry.outputs:
            name = str(item["name"])
            if Path(name).name != name or (folder / name).stat().st_size != item["size"]:
                return None
        return entry
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


def findings_of(items: list[dict[str, Any]], source: Path, *, rename: bool = True) -> Findings:
    """Findings from their JSON; with `rename` their file is called as the source is called now."""
    findings = Findings(str(source))
    for item in items:
        place = Place(
            str(source) if rename else item["where"]["file"],
            item["where"]["line"],
            item["where"]["column"],
            item["where"]["path"],
        )
        findings.items.append(Finding(Severity(item["severity"]), item["code"], item["message"], place, item["hint"]))
    return findings


def _same_bytes(entry: Entry, other: Entry | None) -> bool:
    """Whether the files in `entry` are those that `other` lists."""
    return other is not None and entry.outputs == other.outputs and all(
        _digest(entry.folder / str(item["name"])) == item["digest"] for item in entry.outputs
    )  # fmt: skip


def owner() -> str:
    """Who makes a temporary folder: this machine and process, so that what the dead left can be told."""
    machine = hashlib.blake2b(socket.gethostname().encode("utf-8", "replace"), digest_size=4).hexdigest()
    return f"{machine}-{os.getpid()}"


def _digest(path: Path) -> str:
    from importers.fingerprint import digest_or_missing

    return digest_or_missing(path)


def _unwritable(error: OSError, where: Path) -> LucarnaError:
    hint = "set LUCARNA_CACHE to a folder that you may write to, and check the free space"
    return OutputError(f"cannot write to the cache: {error.strerror or error}", where=where, hint=hint)
