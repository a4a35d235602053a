"""The cache of converted sources: a source's content names a folder, so moving or touching a file costs nothing.

    <user cache>/converted/<key>/   X.scene.json, … and `import.json` (what the import found)

A folder is made aside and renamed into place: it is there whole or not at all. Deleting the cache is always safe.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.core.errors import OutputError, Place
from engine.core.findings import Finding, Findings, Severity
from engine.core.paths import user_cache_dir
from importers.settings import ImportSettings

if TYPE_CHECKING:
    from importers.convert import Progress

_RECORD = "import.json"
SCENE_SUFFIX = ".scene.json"


def scene_for(
    path: Path, *, settings: ImportSettings | None = None, progress: Progress | None = None, force: bool = False
) -> tuple[Path, Findings]:
    """The scene of `path`, a *.scene.json itself or a source, which is converted once per content and settings.

    The findings are those of the conversion, also where it was done long ago. `force` converts anew.
    Raises InputError, FormatError, OutputError.
    """
    path = Path(path)
    if path.name.lower().endswith(SCENE_SUFFIX):
        return path, Findings(str(path))
    # here: opening a converted scene needs none of it
    from importers.convert import stage
    from importers.fingerprint import source_key
    from importers.registry import find_importer

    settings = settings or ImportSettings()
    importer = find_importer(path)
    key = source_key(path, importer, settings)
    folder = user_cache_dir() / "converted" / key
    if not force:
        known = _recall(folder, path)
        if known is not None:
            return known
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        staging = Path(tempfile.mkdtemp(prefix=f".{key}.", suffix=".tmp", dir=folder.parent))
    except OSError as error:
        raise OutputError(
            f"cannot write to the cache: {error.strerror or error}", where=folder.parent,
            hint="set LUCARNA_CACHE to a folder that you may write to",
        ) from error  # fmt: skip
    try:
        model = importer.load(path, settings)
        scene = stage(model, importer, path, staging, settings, {}, progress, key=key)
        record = {"scene": scene.name, "findings": [f.to_json() for f in model.findings]}
        (staging / _RECORD).write_text(json.dumps(record, sort_keys=True), encoding="utf-8")
        _publish(staging, folder, force)
    finally:
        shutil.rmtree(staging, ignore_errors=True)
    return folder / scene.name, model.findings


def clear() -> None:
    """Remove all converted scenes and encoded textures."""
    for name in ("converted", "textures"):
        shutil.rmtree(user_cache_dir() / name, ignore_errors=True)


def _publish(staging: Path, folder: Path, replace: bool) -> None:
    try:
        if replace and folder.exists():
            shutil.rmtree(folder)
        staging.rename(folder)
    except OSError as error:
        # Another process may have published the same content first: then that is the result.
        if not (folder / _RECORD).is_file():
            raise OutputError(f"cannot write to the cache: {error.strerror or error}", where=folder) from error


def _recall(folder: Path, source: Path) -> tuple[Path, Findings] | None:
    """The scene and findings of an earlier conversion; None where there is none, or it is damaged (then removed)."""
    record = folder / _RECORD
    if not record.is_file():
        return None
    try:
        data: dict[str, Any] = json.loads(record.read_text(encoding="utf-8"))
        scene = folder / data["scene"]
        findings = Findings(str(source))
        for item in data["findings"]:
            place = Place(str(source), item["where"]["line"], item["where"]["column"], item["where"]["path"])
            findings.items.append(
                Finding(Severity(item["severity"]), item["code"], item["message"], place, item["hint"])
            )
    except (OSError, ValueError, KeyError, TypeError):
        shutil.rmtree(folder, ignore_errors=True)
        return None
    return (scene, findings) if scene.is_file() else None
