"""Damaged files of every format, seeded and counted: `python -m tests.fuzz --count 2000 --seed 1`.

    seeds     small sound files of each format, built by hand (and a few real ones, where the assets are there)
    mutate    one of them + a random generator -> a damaged copy: bytes, text, JSON, images, and the file system
    child     converts or checks one mutant after another in a process of its own, and says what became of each
    run       feeds children, watches the clock, counts; a child that dies or hangs is a failure, and is replaced

A mutant may be imported (whole or in part; what was written must then be readable) or refused in words. Anything else
is a failure: a traceback, a crash of the process, a hang, a file left half-written, a file read from outside.
Exit code 1 where anything failed.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

from tests.fuzz.run import ROOT, Tally, fuzz


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=2000, help="how many files to damage")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", metavar="KIND", help="only formats whose name holds this")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep the files that failed here")
    args = parser.parse_args()
    assets = Path(os.environ.get("LUCARNA_ASSETS", ROOT.parent / "shared" / "assets"))
    started = time.perf_counter()

    def tell(done: int, tally: Tally) -> None:
        if done % 100 == 0:
            print(f"{done} in {time.perf_counter() - started:.0f} s, {len(tally.failures)} failed", flush=True)

    with tempfile.TemporaryDirectory(prefix="lucarna-fuzz-cache-") as cache:
        os.environ.setdefault("LUCARNA_CACHE", cache)
        tally = fuzz(
            args.count, args.seed, assets if assets.is_dir() else None, only=args.only, keep=args.keep, tell=tell
        )
    print(tally.table())
    print(f"slowest: {tally.slowest[0]:.1f} s, number {tally.slowest[1]}")
    for failure in tally.failures:
        print(
            f"\n{failure.number} ({failure.kind}, {failure.what}): {failure.outcome} {failure.kept}\n{failure.message}"
        )
    print(f"\n{args.count} mutants, {len(tally.failures)} failures, {time.perf_counter() - started:.0f} s")
    return 1 if tally.failures else 0


if __name__ == "__main__":
    sys.exit(main())
