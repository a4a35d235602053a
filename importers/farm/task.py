"""One import, on the worker's side: find its key; where the cache has no such entry, do the work and put it there."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from engine.core.errors import FormatError, InputError, Place
from engine.core.paths import user_cache_dir
from importers import cache
from importers.farm.record import limits_of, relative
from importers.farm.trace import Trace
from importers.fingerprint import Digests, Input, digest_or_missing, inputs_of, key_of
from importers.naming import safe_name
from importers.registry import find_importer
from importers.settings import ImportSettings
from importers.versions import CONVERT_VERSION

TASK = "importers.farm.task:perform"


def request_for(
    source: Path, name: str, settings: ImportSettings, *, force: bool = False, ignored: frozenset[str] = frozenset(),
    store: str = "",
) -> dict[str, Any]:  # fmt: skip
    """The JSON that `perform` takes. `force`: do the work even if the cache has its result."""
    return {
        "source": str(source), "name": name, "settings": settings.differences(), "force": force,
        "ignored": sorted(ignored), "store": store,
    }  # fmt: skip


def perform(request: dict[str, Any], progress: Callable[[str, float], None]) -> dict[str, Any]:
    """Import request["source"]; with `threads`, other threads of this process do other things.

    Returns the record's parts (see record.Record) with `cached`, `timings` and, where the source was refused, `error`
    and `exit_code`; other failures are raised."""
    source, settings = Path(request["source"]), ImportSettings().replace(**_typed(request["settings"]))
    if request["force"]:
        settings = settings.replace(use_texture_cache=False)
    timings: dict[str, float] = {}
    clock = time.perf_counter()
    importer = find_importer(source)
    reply: dict[str, Any] = {
        "key": "", "importer": importer.name, "version": importer.version, "convert_version": CONVERT_VERSION,
        "settings": settings.output_values(), "limits": limits_of(settings), "cached": False, "error": "",
        "exit_code": 0, "outputs": [], "findings": [], "scene": "", "timings": timings,
    }  # fmt: skip
    inputs = [Input(source.name, source, digest_or_missing(source))]
    extra: list[Input] = []
    with Trace((user_cache_dir(),), own_thread=bool(request.get("threads"))) as trace:
        try:
            inputs = inputs_of(source, importer, settings)
            timings["key"] = time.perf_counter() - clock
            name = safe_name(request["name"])
            key = key_of(inputs, importer, settings, "" if name == safe_name(source.stem) else name)
            reply["key"] = key
            store = cache.Cache(request["store"])
            entry = None if request["force"] else store.recall(key, source)
            reply["cached"] = entry is not None
            if entry is None:
                known = {str(item.path.absolute()) for item in inputs}

                def read_besides() -> list[Input]:
                    files = (Path(path) for path in list(trace.files) if path not in known)
                    return [Input(p.name, p, digest_or_missing(p)) for p in files if p.resolve() != source.resolve()]

                entry = store.make(
                    key, source, importer, settings, name, progress, read_besides, timings, replace=request["force"]
                )
            extra = entry.extra(source)
            reply |= {"outputs": entry.outputs, "findings": entry.findings, "scene": entry.scene}
        except InputError as error:
            reply |= {"error": str(error), "exit_code": error.exit_code, "refusal": describe_error(error)}
    base = source.parent
    rows = [[item.name, relative(item.path, base), item.digest] for item in [*inputs, *extra]]
    unique = {row[1]: row for row in reversed(rows)}
    reply["inputs"] = [rows[0], *(row for path, row in sorted(unique.items()) if path != rows[0][1])]
    digests = Digests(frozenset(request["ignored"]))
    listed = [*trace.folders] if reply["inputs"][1:] or trace.folders else []
    reply["listed"] = sorted([relative(folder, base), digests.listing(folder)] for folder in listed)
    return reply


def describe_error(error: InputError) -> dict[str, Any]:
    """As JSON, for the other side of a process border."""
    kind = "format" if isinstance(error, FormatError) else "input"
    return {"kind": kind, "message": error.message, "hint": error.hint, "where": asdict(error.where)}


def error_from(refusal: dict[str, Any]) -> InputError:
    """The error that `describe_error` described."""
    tree = FormatError if refusal["kind"] == "format" else InputError
    return tree(refusal["message"], where=Place(**refusal["where"]), hint=refusal["hint"])


def _typed(values: dict[str, Any]) -> dict[str, Any]:
    """Settings as JSON gives them: lists become tuples again."""
    return {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}
