"""`lucarna new DIR`: a project with a sample scene, made from the template."""

from __future__ import annotations

import argparse
import json
import shlex
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("directory", metavar="DIR", type=Path, help="folder to make; it must be new or empty")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def run(args: argparse.Namespace) -> int:
    """Make the project and say what to do next. Raises UsageError, OutputError."""
    from engine.app.project import new_project

    project = new_project(args.directory)
    if args.json:
        print(json.dumps({"name": project.name, "root": str(project.root), "start": str(project.start)}))
        return 0
    name = shlex.quote(str(args.directory))
    print(f"made the project {project.name!r} in {project.root}")
    print(f"  open it:   lucarna edit {name}")
    print(f"  render it: lucarna render {name} --out {project.start.stem}.png")
    return 0
