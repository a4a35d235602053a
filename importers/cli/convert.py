"""`lucarna convert SOURCE… --out DIR`: sources become engine files; what is up to date is left alone."""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from engine.core.errors import UsageError
from importers.cli.output import print_json
from importers.cli.settings_flags import add_settings, given_settings
from importers.workers.process import usable_cores

if TYPE_CHECKING:
    from importers.farm.plan import Plan
    from importers.farm.run import Farm
    from importers.presets import SettingsResolver


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("sources", nargs="+", metavar="SOURCE", help="a source file, a folder to search, or a pattern such as **/*.glb")
    add("--out", type=Path, metavar="DIR", help="the folder to write into; made if need be")
    add("--jobs", type=int, default=0, metavar="N", help="worker processes (default: one per core)")
    add("--force", action="store_true", help="convert everything anew, without the caches")
    add("--dry-run", action="store_true", help="say what would be done and why; write nothing")
    add("--explain", action="store_true", help="say why each source was converted, and which outputs changed")
    add("--watch", action="store_true", help="go on, and convert again whenever something changes; ends by Ctrl-C")
    add("--verify", action="store_true", help="compare outputs by their bytes, not by size and time")
    add("--clean", action="store_true", help="remove the outputs of sources that are gone")
    add("--cache", default=os.environ.get("LUCARNA_SHARED_CACHE", ""), metavar="URL",
        help="a cache that machines share: any fsspec URL (extra `farm`; default: $LUCARNA_SHARED_CACHE)")  # fmt: skip
    add("--scheduler", default="", metavar="ADDRESS", help="work on a Dask cluster, as tcp://host:8786 (extra `farm`)")
    add("--save-settings", action="store_true",
        help="write the settings given here into the sidecars (NAME.EXT.import) of the sources, and convert nothing "
        "unless --out is given")  # fmt: skip
    add("--json", action="store_true", help="print one JSON value instead of text")
    add("--quiet", action="store_true", help="print errors and the last line only")
    add("--verbose", action="store_true", help="print notes and outputs of every source, however many there are")
    add_settings(parser)


def run(args: argparse.Namespace) -> int:
    """Exit code: 0 all well, 1 a source is bad, 2 wrong usage, 3 something could not be written."""
    if args.jobs < 0:
        raise UsageError(f"--jobs {args.jobs}: give 1 or more, or 0 for one per core")
    if args.out is None and not args.save_settings:
        raise UsageError("--out is missing", hint="say where the files go: --out DIR")
    if args.watch and (args.dry_run or args.json):
        raise UsageError("--watch does not go with --dry-run or --json")
    settings = given_settings(args)
    if args.save_settings:
        _save_settings(args, settings)
        if args.out is None:
            return 0
        settings = {}
    from importers.cli.convert_report import Report
    from importers.farm.plan import make_plan, unasked_images
    from importers.presets import SettingsResolver

    resolver = SettingsResolver(preset="" if args.save_settings else args.preset, flags=settings)
    started = time.monotonic()
    plan = make_plan(args.sources, args.out, resolver)
    report = Report(args, len(plan.jobs), started)
    farm = _farm(args, report)
    for outcome in plan.refused:
        report.done(outcome)
    if args.dry_run:
        return report.dry_run(farm, plan)
    try:
        outcomes = [*plan.refused, *farm.run(plan.jobs, args.jobs or usable_cores())]
        removed = _clean(args.out) if args.clean else []
    finally:
        report.close()
    code = report.finish(outcomes, removed, unasked_images(plan, outcomes))
    if args.watch:
        from importers.farm.watch import watch

        watch(lambda: _plan_again(args, resolver), plan, outcomes, farm, args.jobs or usable_cores(), report)
    return code


def _farm(args: argparse.Namespace, report: object) -> Farm:
    from importers.cli.convert_report import Report
    from importers.farm.run import Farm, LocalWorkers, Options, Workers

    assert isinstance(report, Report)

    def workers(size: int) -> Workers:
        if args.scheduler:
            from importers.farm.cluster import ClusterWorkers

            return ClusterWorkers(args.scheduler, args.cache)
        return LocalWorkers(size)

    return Farm(Options(args.out, args.force, args.verify, args.cache), workers, report.start, report.done)


def _plan_again(args: argparse.Namespace, resolver: SettingsResolver) -> Plan:
    from importers.farm.plan import make_plan
    from importers.presets import SettingsResolver

    # sidecars, presets and project files may have changed
    return make_plan(args.sources, args.out, SettingsResolver(resolver.base, resolver.preset, resolver.flags))


def _save_settings(args: argparse.Namespace, settings: dict[str, object]) -> None:
    from importers.farm.plan import make_plan
    from importers.presets import SettingsResolver, save_sidecar

    if not settings and not args.preset:
        raise UsageError("--save-settings without a setting", hint="name some, as --max-texture-size 512 or --preset P")
    plan = make_plan(args.sources, args.out or Path(os.devnull), SettingsResolver())
    for outcome in plan.refused:
        print(f"lucarna: error: {outcome.error}", file=sys.stderr)
    for job in plan.jobs:
        path = save_sidecar(job.source, settings, args.preset or None)
        if not args.json:
            print(f"{path}: {'written' if path.is_file() else 'not needed: nothing differs'}")
    if args.json and args.out is None:
        print_json([str(job.source) + ".import" for job in plan.jobs])


def _clean(out: Path) -> list[str]:
    from importers.farm.clean import remove_orphans

    return remove_orphans(out)
