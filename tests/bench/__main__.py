"""Benchmarks: `python -m tests.bench [--only NAME ...] [--quick] [--json FILE]` prints a markdown table.

A bench is one file in this folder with `def run(ctx: Context) -> list[Row]`; being there registers it. Times are
medians of repeated runs after a warm-up, with the interquartile range and the count; they assert nothing.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import platform
import sys
from pathlib import Path

import numpy as np

from tests.bench.harness import Context, Row, table

SKIP = {"__main__", "harness", "stages"}


def names() -> list[str]:
    return sorted(p.stem for p in Path(__file__).parent.glob("*.py") if p.stem not in SKIP)


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.bench", description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=names(), metavar="NAME", help=f"of: {', '.join(names())}")
    parser.add_argument("--quick", action="store_true", help="smaller sizes, fewer repeats")
    parser.add_argument("--json", type=Path, help="also write the rows to this file")
    args = parser.parse_args(argv)
    context = Context(quick=args.quick)
    rows: list[Row] = []
    for name in args.only or names():
        module = importlib.import_module(f"tests.bench.{name}")
        print(f"{name} ...", file=sys.stderr)
        rows.extend(row.of(name) for row in module.run(context))
    print(table(rows))
    if args.json:
        from engine.core.atomic import write_text

        machine = {
            "python": platform.python_version(), "numpy": np.__version__,
            "machine": platform.machine(), "cores": os.cpu_count(),
        }  # fmt: skip
        data = {"machine": machine, "rows": [row.to_json() for row in rows]}
        write_text(args.json, json.dumps(data, indent=1, sort_keys=True) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
