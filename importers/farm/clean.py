"""Outputs whose source is gone: found by their records."""

from __future__ import annotations

from pathlib import Path

from importers.farm.record import FOLDER, read_record
from importers.fingerprint import digest_or_missing


def remove_orphans(out: Path) -> list[str]:
    """Remove, below `out`, the outputs and records of sources that are no longer there; returns the files removed.
    What somebody changed by hand stays, and so does whatever no record names."""
    removed = []
    for path in sorted(out.rglob(f"{FOLDER}/*.json")):
        record = read_record(path)
        if record is None or not record.source or (path.parent / record.source).exists():
            continue
        folder = path.parent.parent
        for item in record.outputs:
            if digest_or_missing(folder / item["name"]) == item["digest"]:
                (folder / item["name"]).unlink(missing_ok=True)
                removed.append(str(folder / item["name"]))
        path.unlink(missing_ok=True)
    return removed
