"""`lucarna new DIR [--sample NAME]`: a project with a sample scene, from the template or made by code."""

from __future__ import annotations

import argparse
import json
import shlex
from pathlib import Path

from engine.core.errors import UsageError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("directory", metavar="DIR", type=Path, help="folder to make; it must be new or empty")
    parser.add_argument(
        "--sample", metavar="NAME", default="orrery",
        help="what to begin with: orrery (default), walker (a figure that walks), atrium (1,024 moving lights), "
        "poles (thin poles, 1,024 lights)",
    )  # fmt: skip
    parser.add_argument("--lights", metavar="N", type=int, help="lights in the atrium or the poles (default 1024)")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def run(args: argparse.Namespace) -> int:
    """Make the project and say what to do next. Raises UsageError, OutputError."""
    from engine.app.project import new_project

    if args.sample == "orrery":
        if args.lights is not None:
            raise UsageError("--lights is for --sample atrium and --sample poles")
        project = new_project(args.directory)
    else:
        from engine.app.sample_project import new_sample_project

        project = new_sample_project(args.directory, args.sample, lights=args.lights)
    if args.json:
        print(json.dumps({"name": project.name, "root": str(project.root), "start": str(project.start)}))
        return 0
    name = shlex.quote(str(args.directory))
    print(f"made the project {project.name!r} in {project.root}")
    print(f"  open it:   lucarna edit {name}")
    print(f"  render it: lucarna render {name} --out {project.start.name.split('.')[0]}.png")
    return 0
