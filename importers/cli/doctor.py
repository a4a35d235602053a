"""`lucarna doctor`: what this machine has and lacks, and what to do about it."""

from __future__ import annotations

import argparse
import json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print the report as JSON")


def run(args: argparse.Namespace) -> int:
    """Print the report. Exit code 0, or 3 when there is no graphics device."""
    from engine.app.doctor import examine

    report = examine()
    print(json.dumps(report.to_json(), indent=2, sort_keys=True) if args.json else report.to_text())
    return report.exit_code
