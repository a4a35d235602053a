"""`lucarna convert SOURCE… --out DIR`: sources become engine files."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.core.errors import InputError, LucarnaError, UsageError
from importers.cli.output import count_text, print_findings, print_json, size_text, terminal_progress
from importers.settings import PRESETS, ImportSettings

if TYPE_CHECKING:
    from importers.convert import ConvertResult


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("sources", nargs="+", metavar="SOURCE", help="a source file, or a folder to search")
    parser.add_argument("--out", required=True, metavar="DIR", help="the folder to write into; made if need be")
    parser.add_argument("--preset", choices=PRESETS, default="normal", help="texture effort (default: %(default)s)")
    parser.add_argument("--max-texture-size", type=int, default=0, metavar="N", help="halve larger images to fit")
    parser.add_argument("--force", action="store_true", help="encode textures anew, without the cache")
    parser.add_argument("--allow-outside", action="store_true", help="follow URIs that leave the source's folder")
    parser.add_argument("--jobs", type=int, default=0, metavar="N", help="texture threads (default: one per core)")
    parser.add_argument("--json", action="store_true", help="print one JSON value instead of text")


def run(args: argparse.Namespace) -> int:
    if args.jobs < 0:
        raise UsageError(f"--jobs {args.jobs}: give 1 or more, or 0 for one per core")
    settings = ImportSettings(
        preset=args.preset, max_texture_size=args.max_texture_size, allow_outside=args.allow_outside,
        use_texture_cache=not args.force, jobs=args.jobs,
    )  # fmt: skip
    from importers.convert import convert

    failed: LucarnaError | None = None
    any_errors, reports = False, []
    for source, out, name in _plan(args.sources, Path(args.out)):
        started = time.perf_counter()
        try:
            result = convert(source, out, settings, None if args.json else terminal_progress(), name)
        except InputError as error:
            # The other sources may be sound: name this one and go on
            failed = error
            reports.append({"source": str(source), "error": str(error), "outputs": [], "findings": []})
            print(f"lucarna: error: {error}", file=sys.stderr)
            continue
        seconds = time.perf_counter() - started
        any_errors |= result.findings.has_errors
        reports.append(_describe(source, result, seconds))
        if not args.json:
            _print_result(source, result, seconds)
    if args.json:
        print_json(reports)
    return 1 if failed is not None or any_errors else 0


def _plan(sources: list[str], out: Path) -> list[tuple[Path, Path, str]]:
    """(source, output folder, name). Folders keep their inner structure; names that would collide get the extension."""
    from importers.convert import sources_in

    plan: list[tuple[Path, Path, str]] = []
    taken: set[tuple[Path, str]] = set()
    for text in sources:
        root = Path(text)
        for source in sources_in(root):
            folder = out / source.parent.relative_to(root) if root.is_dir() else out
            name, number = source.stem, 1
            if (folder, name.casefold()) in taken:
                name = f"{source.stem}_{source.suffix[1:].lower()}"
            base = name
            while (folder, name.casefold()) in taken:
                number += 1
                name = f"{base}_{number}"
            taken.add((folder, name.casefold()))
            plan.append((source, folder, name))
    return plan


def _describe(source: Path, result: ConvertResult, seconds: float) -> dict[str, Any]:
    return {
        "source": str(source),
        "scene": str(result.scene),
        "outputs": [{"path": str(p), "bytes": p.stat().st_size} for p in result.outputs],
        "findings": [finding.to_json() for finding in result.findings],
        "seconds": {"total": seconds} | result.timings,
    }


def _print_result(source: Path, result: ConvertResult, seconds: float) -> None:
    steps = ", ".join(f"{name} {value * 1000:.0f} ms" for name, value in result.timings.items())
    print(f"{source}: {len(result.outputs)} file(s) in {seconds:.2f} s ({steps}); {count_text(result.findings)}")
    for path in result.outputs:
        print(f"  {path}  {size_text(path.stat().st_size)}")
    print_findings(result.findings)
