"""`lucarna check PATH…`: what is wrong with sources and engine files; writes nothing."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from engine.core.errors import InputError
from engine.core.findings import Findings
from importers.cli.output import count_text, print_findings, print_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("paths", nargs="+", metavar="PATH", help="a source or engine file, or a folder to search")
    parser.add_argument("--allow-outside", action="store_true", help="follow URIs that leave the source's folder")
    parser.add_argument("--json", action="store_true", help="print one JSON value instead of text")


def run(args: argparse.Namespace) -> int:
    from importers.checking import check_file, checkable_files
    from importers.settings import ImportSettings

    settings = ImportSettings(allow_outside=args.allow_outside)
    bad, reports = False, []
    for text in args.paths:
        for path in checkable_files(Path(text)):
            findings, failure = Findings(str(path)), ""
            try:
                findings = check_file(path, settings)
            except InputError as error:
                failure = str(error)
            bad |= bool(failure) or findings.has_errors
            reports.append(
                {"path": str(path), "error": failure, "findings": [finding.to_json() for finding in findings]}
            )
            if not args.json:
                if failure:
                    print(f"lucarna: error: {failure}", file=sys.stderr)
                else:
                    print(f"{path}: {count_text(findings)}")
                    print_findings(findings)
    if args.json:
        print_json(reports)
    return 1 if bad else 0
