"""Feeds mutants to children and counts what becomes of them."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import random
import shutil
import subprocess
import sys
import tempfile
import threading
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from tests.fuzz.mutate import mutant
from tests.fuzz.seeds import Seed, all_seeds

#: a worker has 15 s; beyond twice that something else hangs
SECONDS = 40.0
MODULE = ["-m", "tests.fuzz.child"]
ROOT = Path(__file__).resolve().parents[2]


@dataclass(slots=True)
class Failure:
    """What went wrong with which mutant; `kept`: a copy of its files."""

    number: int
    kind: str
    what: str
    outcome: str
    message: str
    kept: str = ""


@dataclass(slots=True)
class Tally:
    """Counts by (kind, outcome) and by (what was done, outcome)."""

    kinds: Counter[tuple[str, str]] = field(default_factory=Counter)
    changes: Counter[tuple[str, str]] = field(default_factory=Counter)
    failures: list[Failure] = field(default_factory=list)
    slowest: tuple[float, str] = (0.0, "")

    def table(self) -> str:
        """Both counts as text."""
        lines = []
        for title, counts in (("format", self.kinds), ("damage", self.changes)):
            outcomes = sorted({outcome for _, outcome in counts})
            lines.append(f"{title:<20}" + "".join(f"{o:>12}" for o in outcomes) + f"{'all':>8}")
            for name in sorted({name for name, _ in counts}):
                row = [counts[name, outcome] for outcome in outcomes]
                lines.append(f"{name:<20}" + "".join(f"{n or '':>12}" for n in row) + f"{sum(row):>8}")
            row = [sum(n for (_, o), n in counts.items() if o == outcome) for outcome in outcomes]
            lines += [f"{'all':<20}" + "".join(f"{n:>12}" for n in row) + f"{sum(row):>8}", ""]
        return "\n".join(lines)


class Child:
    """A process that does orders one at a time."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._answers: queue.Queue[str | None] = queue.Queue()
        self._listener = threading.Thread()

    def ask(self, order: dict[str, str], seconds: float) -> dict[str, object]:
        """Its answer; outcome `crash` or `hang` where it gives none, and then it is replaced."""
        process = self._process or self._start()
        assert process.stdin is not None
        try:
            process.stdin.write(json.dumps(order) + "\n")
            process.stdin.flush()
            answer = self._answers.get(timeout=seconds)
        except queue.Empty:
            self.close()
            return {"outcome": "hang", "message": f"no answer within {seconds:g} s", "seconds": seconds}
        except OSError:
            answer = None
        if answer is None:
            code = process.wait()
            self.close()
            return {"outcome": "crash", "message": f"the process ended with {code}", "seconds": 0.0}
        result: dict[str, object] = json.loads(answer)
        return result

    def _start(self) -> subprocess.Popen[str]:
        command = [sys.executable, "-W", "ignore", *MODULE]
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=ROOT
        )
        answers: queue.Queue[str | None] = queue.Queue()

        def listen() -> None:
            assert process.stdout is not None
            with process.stdout:
                for line in process.stdout:
                    answers.put(line)
            answers.put(None)

        self._listener = threading.Thread(target=listen, daemon=True)
        self._listener.start()
        self._process, self._answers = process, answers
        return process

    def close(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._listener.join(10.0)
            if self._process.stdin is not None:
                with contextlib.suppress(OSError):  # what was written and not read
                    self._process.stdin.close()
            self._process = None


def fuzz(
    count: int, seed: int, assets: Path | None, *, only: str = "", keep: Path | None = None,
    tell: Callable[[int, Tally], None] | None = None,
) -> Tally:  # fmt: skip
    """Damage and read `count` files; the same seed damages alike. `only`: of kinds whose name holds it. `keep`: a
    folder for the files of failures."""
    seeds = [s for s in all_seeds(assets) if only in s.kind]
    kinds = sorted({s.kind for s in seeds})
    by_kind = {kind: [s for s in seeds if s.kind == kind] for kind in kinds}
    tally, child = Tally(), Child()
    with tempfile.TemporaryDirectory(prefix="lucarna-fuzz-") as text:
        base = Path(text)
        (base / "secret.png").write_bytes(seeds[0].files[seeds[0].target])
        try:
            for number in range(count):
                dice = random.Random(f"{seed}/{number}")
                kind = kinds[number % len(kinds)]
                _one(number, dice.choice(by_kind[kind]), dice, base, child, tally, keep)
                if tell is not None:
                    tell(number + 1, tally)
        finally:
            child.close()
    return tally


def _one(
    number: int, seed: Seed, dice: random.Random, base: Path, child: Child, tally: Tally, keep: Path | None
) -> None:
    # textures are searched by their names up to two folders above: what nothing may open lies higher
    place = base / f"m{number}" / "project" / "source"
    place.mkdir(parents=True)
    out = place.parent / "out"
    what, entry = mutant(seed, dice, place)
    order = {
        "path": str(place / entry), "out": str(out), "work": seed.work, "what": what,
        "target": str(place / seed.target), "delay": str(dice.random() * 0.03),
    }  # fmt: skip
    answer = child.ask(order, SECONDS)
    outcome, message = str(answer["outcome"]), str(answer["message"])
    left = sorted(str(p.relative_to(place.parent)) for p in place.parent.rglob("*") if place not in (p, *p.parents))
    if outcome == "refused" and left:
        outcome, message = "partial output", f"{left[:5]} after {message}"
    elif outcome not in ("hang", "crash") and any(part.endswith(".tmp") for part in left):
        outcome, message = "partial output", f"{left[:5]}"
    elif outcome == "refused" and len(message) > 3000:
        outcome = "endless message"
    tally.kinds[seed.kind, outcome] += 1
    tally.changes[what, outcome] += 1
    seconds = float(str(answer["seconds"]))
    tally.slowest = max(tally.slowest, (seconds, f"{number} ({seed.kind}, {what})"))
    if outcome not in ("imported", "findings", "refused"):
        failure = Failure(number, seed.kind, what, outcome, message)
        tally.failures.append(failure)
        if keep is not None:
            kept = keep / f"{number}"
            shutil.rmtree(kept, ignore_errors=True)
            keep.mkdir(parents=True, exist_ok=True)
            os.rename(place, kept)  # noqa: PTH104  (also across odd files: pipes, links)
            failure.kept = str(kept / entry)
    shutil.rmtree(place.parent.parent, ignore_errors=True)
