"""`lucarna mv OLD NEW`: rename or move a file or folder of a project; every reference to it follows."""

from __future__ import annotations

import argparse
import json
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("old", metavar="OLD", type=Path, help="a file or folder of a project")
    parser.add_argument("new", metavar="NEW", type=Path, help="its new name, or a folder that is there to move it into")
    parser.add_argument("--dry-run", action="store_true", help="say what would be done and who uses it, write nothing")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def run(args: argparse.Namespace) -> int:
    """Returns 0. Raises InputError, UsageError, OutputError; then nothing has changed."""
    from importers.project.moving import plan

    move = plan(args.old, args.new)
    if not args.dry_run:
        move.apply()
    if args.json:
        print(json.dumps(move.to_json(), indent=2, ensure_ascii=False))
        return 0
    said = move.to_json()
    print(f"{'would move' if args.dry_run else 'moved'} {said['from']} to {said['to']}")
    count = len(said["files"])
    if count > 1:
        print(f"  {count} files")
    for name in said["rewritten"]:
        print(f"  {'would rewrite' if args.dry_run else 'rewrote'} {name}")
    if not said["rewritten"]:
        print("  nothing refers to it")
    return 0
