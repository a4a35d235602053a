"""`lucarna export SCENE|FILE --out X.obj`: posed geometry back out of the engine."""

from __future__ import annotations

import argparse
from pathlib import Path

from engine.core.errors import UsageError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("source", metavar="SCENE|FILE", help="a *.scene.json, or any source that can be imported")
    parser.add_argument("--out", required=True, metavar="X.obj", help="the file to write: .obj")
    parser.add_argument("--clip", metavar="NAME", help="pose by this clip (with --time or --frame alone: the first)")
    moment = parser.add_mutually_exclusive_group()
    moment.add_argument("--time", type=float, metavar="S", help="seconds from the clip's start (default 0)")
    moment.add_argument(
        "--frame", type=float, metavar="N", help="frame number of the source, at its own frame rate (30 if it has none)"
    )
    parser.add_argument("--hidden", action="store_true", help="write hidden nodes, too")
    parser.add_argument("--allow-outside", action="store_true", help="follow URIs that leave the source's folder")
    parser.add_argument("--quiet", action="store_true", help="print errors only")


def run(args: argparse.Namespace) -> int:
    """Without --clip, --time and --frame the scene is written as it stands."""
    from engine.core.errors import InputError
    from importers.cli.output import print_findings
    from importers.export_obj import export_obj, find_clip, load_geometry, time_of_frame
    from importers.settings import ImportSettings

    out, source = Path(args.out), Path(args.source)
    if out.suffix.lower() != ".obj":
        raise UsageError(f"--out {args.out!r}: only .obj can be written", hint="give a name that ends in .obj")
    if not source.exists():
        raise InputError("there is no such file", where=source)
    geometry = load_geometry(source, ImportSettings(allow_outside=args.allow_outside))
    clip, time = None, 0.0
    if args.clip is not None:
        clip = find_clip(geometry.clips, args.clip)
    elif args.time is not None or args.frame is not None:
        clip = geometry.clips[0] if geometry.clips else None
    if clip is not None:
        time = args.time or 0.0
        if args.frame is not None:
            time = time_of_frame(clip, args.frame)
    if not args.quiet:
        print_findings(geometry.findings)
    export_obj(out, geometry, clip, time, hidden=args.hidden)
    if not args.quiet:
        when = f", {clip.name} at {max(time, 0.0):.4g} s" if clip is not None else ""
        print(f"{out}{when}")
    return 0
