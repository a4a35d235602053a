"""`lucarna play`: a scene in a plain runtime window."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from engine.app.runtime import Runtime

SUMMARY = "show a scene in a plain window with a free camera"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", type=Path, help="*.scene.json, a project folder, or a source file")
    parser.add_argument("--size", default="1280x720", help="WIDTHxHEIGHT of the window")
    parser.add_argument("--frames", type=int, default=0, help="close after this many frames (0 = when you close it)")


def run(args: argparse.Namespace) -> int:
    from engine.app.play import play
    from importers.cli.render import parse_size
    from importers.opening import open_path

    failed = False

    def open_scene(runtime: Runtime) -> None:
        nonlocal failed
        findings = open_path(runtime, args.scene)
        for finding in findings:
            print(finding, file=sys.stderr)
        failed = findings.has_errors

    shown = play(open_scene, size=parse_size(args.size), title=f"Lucarna: {args.scene.name}", frames=args.frames)
    print(f"{shown} frames shown")
    return 1 if failed else 0
