"""Random operations of the editor, undo, redo and `kill -9`: `python -m tests.fuzz.operations --count 10000 --seed 1`.

    operation_stage    scenes with some of everything; the content of a document as a hash
    operation_model    what is known of each open document: its content after every entry of its history
    operation_walk     random operations on several documents, and what must hold after each
    operation_child    a process that walks until it is killed, and first restores what the last one left

Every operation of the registry takes part, with arguments made up from their declarations: what is added there is
walked over from then on. Exit code 1 where anything failed.
"""

from __future__ import annotations

import argparse
import json
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
KILLS = ("event", "step", "torn")


@dataclass(slots=True)
class Outcome:
    """`operations` done on up to `open` documents at once, `kills`, after which `restored` documents came back; what
    failed, with its seed."""

    operations: int = 0
    kills: int = 0
    restored: int = 0
    open: int = 0
    failures: list[str] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)


def fuzz(count: int, seed: int, *, every: int = 300, folder: Path | None = None, tell: bool = False) -> Outcome:
    """Do `count` operations; a process is killed about every `every`. The same seed does the same."""
    outcome = Outcome()
    with tempfile.TemporaryDirectory(prefix="lucarna-operations-") as made:
        bases = [(folder or Path(made)) / name for name in ("still", "animated")]
        for base in bases:
            base.mkdir(parents=True, exist_ok=True)
            (base / "trace.jsonl").touch()
        number = 0
        while outcome.operations < count and not outcome.failures:
            base = bases[number % 2]
            dice = random.Random(f"{seed}/{number}")
            how = KILLS[number // 2 % 3]
            order = {
                "folder": str(base), "animated": base.name == "animated", "seed": f"{seed}/{number}",
                "count": min(2 * every, count - outcome.operations), "kill_how": how,
                "kill_at": dice.randint(every // 2, every + every // 2) // (2 if how == "event" else 1),
            }  # fmt: skip
            _child(order, base, outcome)
            number += 1
            if tell:
                print(
                    f"{outcome.operations} operations, {outcome.kills} kills, {outcome.restored} restored", flush=True
                )
    return outcome


def _child(order: dict[str, object], base: Path, outcome: Outcome) -> None:
    answers = base / "answers.jsonl"
    answers.unlink(missing_ok=True)
    command = [sys.executable, "-W", "ignore", "-m", "tests.fuzz.operation_child", json.dumps(order)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    answer = json.loads(answers.read_text(encoding="utf-8").splitlines()[-1]) if answers.is_file() else {}
    outcome.operations += int(answer.get("done", 0))
    outcome.counts.update(answer.get("counts", {}))
    outcome.open = max(outcome.open, int(answer.get("open", 0)))
    outcome.restored += int(answer.get("restored", 0))
    if done.returncode == -9:
        outcome.kills += 1
    if not answer or answer["problem"]:
        problem = answer.get("problem") or done.stderr[-3000:]
        outcome.failures.append(f"{json.dumps(order)} after {answer.get('what', '?')}:\n{problem}")


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m tests.fuzz.operations", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("--count", type=int, default=10000, help="how many operations")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--every", type=int, default=300, help="a kill about every so many")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="work here, and leave everything")
    args = parser.parse_args()
    started = time.perf_counter()
    outcome = fuzz(args.count, args.seed, every=args.every, folder=args.keep, tell=True)
    for what, times in sorted(outcome.counts.items()):
        print(f"{times:6d}  {what}")
    for failure in outcome.failures:
        print(f"\n{failure}")
    print(
        f"\n{outcome.operations} operations, {outcome.kills} kills, {outcome.restored} documents restored, "
        f"{len(outcome.failures)} failures, {time.perf_counter() - started:.0f} s"
    )
    return 1 if outcome.failures else 0


if __name__ == "__main__":
    sys.exit(main())
