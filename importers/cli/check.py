"""`lucarna check PATH…`: what is wrong with sources and engine files, and what is over budget; writes nothing else."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.core.errors import InputError, LucarnaError, Place, UsageError
from engine.core.findings import Finding, Findings, Severity
from importers.cli.output import count_text, print_findings, print_json
from importers.cli.settings_flags import add_settings, given_settings

if TYPE_CHECKING:
    from importers.settings import ImportSettings

TASK = "importers.checks.files:perform"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("paths", nargs="+", metavar="PATH", help="a source or engine file, or a folder to search")
    parser.add_argument("--budget", action="append", default=[], metavar="NAME=N,…",
                        help="limits, as triangles=50000,bones=64,texture-bytes=16000000 (also [budgets] in "
                        "project.toml)")  # fmt: skip
    parser.add_argument("--jobs", type=int, default=0, metavar="N", help="worker processes (default: one per core)")
    parser.add_argument("--strict", action="store_true", help="exit with 1 for warnings, too")
    parser.add_argument("--json", action="store_true", help="print one JSON value instead of text")
    parser.add_argument("--sarif", type=Path, metavar="FILE", help="also write the findings as SARIF 2.1.0")
    add_settings(parser)


def run(args: argparse.Namespace) -> int:
    """Exit code: 0 nothing wrong, 1 errors (with --strict also warnings), 2 wrong usage."""
    from importers.checks.budgets import parse_budgets
    from importers.workers.process import usable_cores

    if args.jobs < 0:
        raise UsageError(f"--jobs {args.jobs}: give 1 or more, or 0 for one per core")
    said = parse_budgets(",".join(args.budget))
    flags = given_settings(args)
    bad, reports, found = False, [], {}
    for path, findings, failure in _check_all(args, flags, said, args.jobs or usable_cores()):
        bad |= bool(failure) or findings.has_errors
        bad |= args.strict and any(finding.severity is Severity.WARNING for finding in findings)
        reports.append({"path": str(path), "error": failure, "findings": [f.to_json() for f in findings]})
        found[path] = [*findings, *([_as_finding(path, failure)] if failure else [])]
        if not args.json:
            if failure:
                print(f"lucarna: error: {failure}", file=sys.stderr)
            else:
                print(f"{path}: {count_text(findings)}")
                print_findings(findings)
    if args.json:
        print_json(reports)
    if args.sarif is not None:
        import json

        from engine.core.atomic import write_text
        from importers.checks.sarif import sarif_log

        write_text(args.sarif, json.dumps(sarif_log(found, Path.cwd()), indent=1, ensure_ascii=False) + "\n")
    return 1 if bad else 0


def _check_all(
    args: argparse.Namespace, flags: dict[str, Any], said: dict[str, float], size: int
) -> Iterator[tuple[Path, Findings, str]]:
    """(file, findings, why it cannot be read) in a stable order, worked on in parallel."""
    from importers.checks.files import checkable_files
    from importers.farm.single import works_in_process
    from importers.presets import SettingsResolver
    from importers.workers.pool import WorkerPool

    resolver = SettingsResolver(preset=args.preset, flags=flags)
    budgets = _Budgets(said)
    files: list[tuple[Path, str]] = []
    for text in args.paths:
        try:
            files += [(path, "") for path in checkable_files(Path(text))]
        except InputError as error:
            files.append((Path(text), str(error)))
    pool = None if works_in_process() else WorkerPool(min(size, len(files)))

    def check(item: tuple[Path, str]) -> tuple[Path, Findings, str]:
        path, failure = item
        try:
            if not failure:
                settings = resolver.resolve(path).settings
                return path, _check_one(path, settings, budgets.of(path), pool), ""
        except LucarnaError as error:
            failure = str(error)
        return path, Findings(str(path)), failure

    threads = ThreadPoolExecutor(pool.size if pool is not None else 1)
    try:
        yield from threads.map(check, files)
    finally:
        threads.shutdown(wait=False, cancel_futures=True)
        if pool is not None:
            pool.close()


def _check_one(path: Path, settings: ImportSettings, budgets: dict[str, float], pool: Any) -> Findings:
    from importers.cache import findings_of
    from importers.farm.single import limits_for
    from importers.workers.pool import in_process

    request = {"source": str(path), "settings": settings.differences(), "budgets": budgets}
    if pool is None:
        reply = in_process(TASK, request)
    else:
        reply = pool.run(TASK, request, path, limits_for(settings), "the check")
    findings = findings_of(reply["findings"], path, rename=False)
    findings.left_out = reply["left_out"]
    return findings


class _Budgets:
    """The limits for each file: those of its project, overruled by the command line's."""

    def __init__(self, said: dict[str, float]) -> None:
        self._said = said
        self._folders: dict[Path, dict[str, float]] = {}

    def of(self, path: Path) -> dict[str, float]:
        from importers.checks.budgets import budgets_of
        from importers.presets import read_budgets

        if path.parent not in self._folders:
            table, source = read_budgets(path)
            self._folders[path.parent] = budgets_of(table, source) if source is not None else {}
        return self._folders[path.parent] | self._said


def _as_finding(path: Path, failure: str) -> Finding:
    return Finding(Severity.ERROR, "file.unreadable", failure, Place(str(path)))
