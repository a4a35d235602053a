"""The record of a conversion: what it was made of, and from that the reasons why it is out of date.

Beside the outputs, so that it moves with them: `DIR/.lucarna/NAME.json`. Paths of inputs are relative to the source's
folder, so a tree that is moved as a whole stays up to date.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from engine.core.atomic import write_text
from engine.core.paths import user_cache_dir
from importers.farm.job import Job, Output
from importers.fingerprint import MISSING, Digests, digest_of
from importers.registry import Importer
from importers.settings import ImportSettings
from importers.versions import CONVERT_VERSION

FOLDER = ".lucarna"
SCHEMA = "lucarna.converted/1"


@dataclass(slots=True)
class Record:
    """`source`: its path from the record's folder; `inputs`: (name, path, digest), the source first; `listed`:
    (folder, digest of its names); `stamps`: mtime in ns of each output. `error`, `exit_code`: where the source was
    refused; `limits`: under which limits."""

    key: str
    importer: str
    version: int
    settings: dict[str, Any]
    inputs: list[list[str]]
    listed: list[list[str]]
    outputs: list[dict[str, Any]] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)
    findings: list[dict[str, Any]] = field(default_factory=list)
    scene: str = ""
    source: str = ""
    error: str = ""
    exit_code: int = 0
    limits: dict[str, Any] = field(default_factory=dict)
    convert_version: str = CONVERT_VERSION
    schema: str = SCHEMA

    def made(self) -> list[Output]:
        return [Output(o["name"], o["size"], o["digest"], False) for o in self.outputs]


@dataclass(slots=True)
class Verdict:
    """`reasons`: why the record does not hold, empty where it does; `uncertain`: only a folder's listing changed, so
    that the importer must be asked whether it would read other files now."""

    reasons: list[str] = field(default_factory=list)
    uncertain: bool = False

    @property
    def fresh(self) -> bool:
        return not self.reasons


def record_path(job: Job) -> Path:
    return job.folder / FOLDER / f"{job.name}.json"


def refusal_path(job: Job) -> Path:
    """Where a refusal is remembered: in the cache, as nothing of it belongs into the output folder."""
    identity = digest_of(str(job.source.absolute()), job.name, job.settings.key(), job.settings.key("limits"))
    return user_cache_dir() / "refused" / f"{identity}.json"


def read_record(path: Path) -> Record | None:
    """None where there is none, or none that we understand."""
    try:
        data = json.loads(path.read_bytes())
        if data.get("schema") != SCHEMA:
            return None
        record = Record(**data)
        for item in record.outputs:
            Output(**item)
        if not all(len(item) == 3 for item in record.inputs) or not all(len(item) == 2 for item in record.listed):
            return None
        return record
    except (OSError, ValueError, TypeError, AttributeError, KeyError, RecursionError):
        return None


def write_record(path: Path, record: Record, source: Path) -> None:
    """Raises OutputError."""
    record.source = relative(source.absolute(), path.parent.absolute())
    write_text(path, json.dumps(asdict(record), separators=(",", ":"), sort_keys=True))


def judge(record: Record | None, job: Job, importer: Importer, digests: Digests, *, hash_outputs: bool) -> Verdict:
    """Whether what `record` says still holds. Outputs are compared by size and time, by bytes with `hash_outputs`
    or where the time differs."""
    if record is None:
        return Verdict(["it was not converted before"])
    reasons = _versions(record, importer)
    reasons += _settings(record.settings, job.settings.output_values(), job)
    if record.error:
        reasons += _settings(record.limits, limits_of(job.settings), job)
    base = str(job.source.parent)
    for number, (name, path, before) in enumerate(record.inputs):
        # texts: this is done for every file of every run, and Path costs more than hashing
        now = digests.file(str(job.source) if number == 0 else os.path.join(base, path))  # noqa: PTH118  (speed)
        if now != before:
            what = "the source" if number == 0 else "the dependency"
            how = "is gone" if now == MISSING else "has appeared" if before == MISSING else "has other bytes"
            reasons.append(f"{what} {name} {how}")
    if not record.error:
        reasons += _outputs(record, job, digests, hash_outputs)
    if reasons:
        return Verdict(reasons)
    changed = [path for path, before in record.listed if digests.listing(os.path.join(base, path)) != before]  # noqa: PTH118  (speed)
    if changed:
        shown = ", ".join(changed[:3])
        return Verdict([f"files came to or left the folder {shown}"], uncertain=True)
    return Verdict()


def limits_of(settings: ImportSettings) -> dict[str, Any]:
    return settings.output_values("limits")


def relative(path: Path | str, base: Path) -> str:
    """`path` against `base`, absolute where there is no way (another drive)."""
    try:
        return os.path.relpath(path, base)
    except ValueError:
        return str(path)


def _versions(record: Record, importer: Importer) -> list[str]:
    if record.importer != importer.name:
        return [f"it was read by the {record.importer} importer, now by {importer.name}"]
    reasons = []
    if record.version != importer.version:
        reasons.append(f"the {importer.name} importer has version {importer.version}, had {record.version}")
    if record.convert_version != CONVERT_VERSION:
        reasons.append(f"the writer has version {CONVERT_VERSION}; it had {record.convert_version}")
    return reasons


def _settings(before: dict[str, Any], now: dict[str, Any], job: Job) -> list[str]:
    reasons = []
    plain = {name: list(value) if isinstance(value, tuple) else value for name, value in now.items()}
    if plain == before:
        return []
    for name in sorted(plain.keys() | before.keys()):
        if plain.get(name) != before.get(name):
            origin = job.origins.get(name, "by default")
            reasons.append(f"the setting {name} is {plain.get(name)!r} ({origin}), was {before.get(name)!r}")
    return reasons


def _outputs(record: Record, job: Job, digests: Digests, hash_outputs: bool) -> list[str]:
    reasons = []
    stamps: Sequence[int | None] = record.stamps if len(record.stamps) == len(record.outputs) else [None] * 10_000
    folder = str(job.folder)
    for item, stamp in zip(record.outputs, stamps, strict=False):
        path = os.path.join(folder, item["name"])  # noqa: PTH118  (speed)
        try:
            info = os.stat(path)  # noqa: PTH116  (speed)
        except OSError:
            reasons.append(f"the output {item['name']} is gone")
            continue
        if info.st_size != item["size"] or (
            (hash_outputs or info.st_mtime_ns != stamp) and digests.file(path) != item["digest"]
        ):
            reasons.append(f"the output {item['name']} was changed by something else")
    return reasons
