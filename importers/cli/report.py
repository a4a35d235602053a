"""`lucarna report`: measure error against run time; write a page and its JSON twin; compare two of those."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from engine.core.errors import DeviceError, OutputError, UsageError

if TYPE_CHECKING:
    from engine.experiments.harness.experiment import Experiment
    from engine.gpu.types import Device
    from engine.report.records import Report, Result


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("names", nargs="*", metavar="NAME", help="experiments to run; without --out they are listed")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for report.html and report.json")
    parser.add_argument("--quick", action="store_true", help="fewer settings and runs, for CI and a first look")
    parser.add_argument(
        "--scene", type=Path, action="append", default=[], metavar="FILE",
        help="measure on this scene or source (may be repeated); without names: all that measure scenes",
    )  # fmt: skip
    parser.add_argument("--seed", type=int, default=1, help="seed of all random inputs (default 1)")
    parser.add_argument(
        "--compare", type=Path, nargs=2, metavar=("A.json", "B.json"), help="what got worse or better from A to B"
    )
    parser.add_argument("--json", action="store_true", help="print machine output")


def run(args: argparse.Namespace) -> int:
    if args.compare is not None:
        if args.names or args.out or args.scene:
            raise UsageError("--compare takes two files and nothing else")
        return _compare(args.compare[0], args.compare[1], as_json=args.json)
    if args.out is None and args.scene:
        raise UsageError("--scene without --out", hint="say where the report goes: --out DIR")
    if args.seed < 0:
        raise UsageError(f"--seed {args.seed} is negative", hint="give 0 or more")
    if args.out is not None and args.out.exists() and not args.out.is_dir():
        raise UsageError(f"--out {args.out}: a file of that name is there", hint="give a folder")
    for scene in args.scene:
        if not scene.exists():
            raise UsageError(f"--scene {scene}: no such file", hint="a *.scene.json, a project or a source file")
    from engine.experiments.harness import registry

    registry.include("importers.experiments")
    chosen = registry.select(args.names)
    if args.out is None:
        return _list(chosen, as_json=args.json)
    _make_folder(args.out)
    if args.scene and not args.names:  # the others have inputs of their own: a scene changes nothing there
        chosen = {name: experiment for name, experiment in chosen.items() if experiment.own_scene}
    return _measure(chosen, args)


def _make_folder(out: Path) -> None:
    """Now, as a folder that cannot be written to is better known before minutes of measuring than after."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder: {error.strerror or error}", where=out) from error


def _list(chosen: dict[str, Experiment], *, as_json: bool) -> int:
    if as_json:
        from importers.cli.output import print_json

        rows = {
            name: {"title": e.title, "method": e.method, "truth": e.truth, "scenes": e.own_scene}
            for name, e in chosen.items()
        }
        print_json(rows)
        return 0
    width = max(map(len, chosen), default=0)
    for name, experiment in chosen.items():
        print(f"{name:<{width}}  {experiment.title}{'  (takes --scene)' if experiment.own_scene else ''}")
    from engine.experiments.harness.registry import GROUPS

    for group, members in GROUPS.items():
        if set(members) <= set(chosen):
            print(f"{group:<{width}}  all of {', '.join(members)}")
    print("\n`lucarna report NAME… --out DIR` measures; without names, all of them.")
    return 0


def _measure(chosen: dict[str, Experiment], args: argparse.Namespace) -> int:
    from engine.experiments.harness import provenance
    from engine.report.records import Report
    from engine.report.writing import write_report

    device = _open_device()
    try:
        report = Report(
            device=provenance.device_name(device), driver=provenance.driver_name(device),
            versions=provenance.versions(), experiments=[], quick=args.quick, seed=args.seed,
            machine=provenance.machine_name(),
        )  # fmt: skip
        for i, (name, experiment) in enumerate(chosen.items(), 1):
            result = _run_one(name, experiment, device, args, f"{i}/{len(chosen)}")
            report.experiments.append(result)
            print(_line(result), file=sys.stderr if args.json else sys.stdout, flush=True)
    finally:
        if device is not None:
            device.release()
    page, twin = write_report(report, args.out)
    if args.json:
        from importers.cli.output import print_json

        print_json(report.to_json())
    else:
        print(f"{page}\n{twin}")
    return _exit_code(report)


def _open_device() -> Device | None:
    from engine.gpu import open_device

    try:
        return open_device("gl")
    except DeviceError as error:
        print(f"warning: {error}; what needs a device is left out", file=sys.stderr)
        return None


def _run_one(name: str, experiment: Experiment, device: Device | None, args: argparse.Namespace, where: str) -> Result:
    from engine.experiments.harness.context import Context
    from engine.experiments.harness.sweep import run_experiment
    from importers.cli.output import terminal_progress
    from importers.cli.report_tools import ImporterTools

    progress = terminal_progress()
    scenes = tuple(args.scene) if experiment.own_scene else ()
    context = Context(device=device, quick=args.quick, seed=args.seed, tools=ImporterTools(), scenes=scenes)
    if args.scene and not experiment.own_scene:
        print(f"warning: {name} has inputs of its own: --scene changes nothing there", file=sys.stderr)
        context.notes.append("Its inputs are its own: --scene changes nothing here.")
    say = None if progress is None else lambda text: progress(f"{where} {name}: {text}", 0.5)
    try:
        return run_experiment(name, experiment, context, say)
    finally:
        if progress is not None:
            progress("", 1.0)


def _line(result: Result) -> str:
    front = {True: "default on its front", False: "DEFAULT NOT ON ITS FRONT", None: "no front"}[result.default_on_front]
    if result.advisory and result.default_on_front is False:
        front = "there are better settings"
    orders = ", ".join(
        f"order {o.observed:.2f} (expected {o.expected:g})" if o.observed is not None else "order not seen"
        for o in result.orders
    )
    bad = [e for e in result.extremes if not e.ok]
    parts = [front, orders, f"{len(bad)} EXTREME CASES FAIL" if bad else "", f"{result.seconds:.1f} s"]
    return f"{result.name}: " + "; ".join(p for p in parts if p)


def _exit_code(report: Report) -> int:
    """1 when a default is beaten or an extreme case fails: a finding, as in `check`."""
    bad = any(
        (r.default_on_front is False and not r.advisory) or any(not e.ok for e in r.extremes)
        for r in report.experiments
    )
    return 1 if bad else 0


def _compare(a: Path, b: Path, *, as_json: bool) -> int:
    from engine.report.compare import compare
    from engine.report.writing import load_twin

    result = compare(load_twin(a), load_twin(b))
    if as_json:
        from importers.cli.output import print_json

        print_json(result.to_json())
    else:
        print("\n".join(result.lines()))
    return 1 if result.regressions else 0
