"""What `lucarna convert` says: a line per source, a live line on a terminal, the sum at the end; or JSON alone."""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from importers.cli.output import print_json, size_text
from importers.farm.job import Job, Outcome
from importers.farm.progress import ProgressLine

if TYPE_CHECKING:
    from importers.farm.plan import Plan
    from importers.farm.run import Farm

#: up to so many sources the outputs and notes are listed one by one
FEW = 3
SLOWEST = 3


class Report:
    """Tells of outcomes as they come."""

    def __init__(self, args: argparse.Namespace, total: int, started: float) -> None:
        self._json, self._quiet, self._explain = args.json, args.quiet, args.explain
        self._started, self._total = started, total
        self._few = FEW if not args.verbose else sys.maxsize
        self._line = ProgressLine(total)
        self._count = 0

    def start(self, job: Job) -> None:
        self._line.start(job)

    def done(self, outcome: Outcome) -> None:
        """Print what is to be said of one source."""
        self._line.done(outcome)
        self._count += 1
        if self._json:
            return
        self._line.clear()
        if outcome.error:
            again = "" if outcome.reasons or not outcome.job.name else " (as before: nothing changed)"
            print(f"lucarna: error: {outcome.error}{again}", file=sys.stderr, flush=True)
        elif not self._quiet and (outcome.state != "up to date" or self._total <= self._few or self._explain):
            print(self._row(outcome), flush=True)
        if self._quiet:
            return
        if self._explain and outcome.job.name:
            for reason in outcome.reasons or ["nothing changed"]:
                print(f"    because {reason}" if outcome.reasons else f"    {reason}")
            for output in outcome.outputs if outcome.state != "up to date" else ():
                print(f"    {output.name}: {'written' if output.changed else 'the same bytes, left alone'}")
        elif self._total <= self._few and outcome.state != "up to date":
            for output in outcome.outputs:
                print(f"  {outcome.job.folder / output.name}  {size_text(output.size)}")
        for name in outcome.removed:
            print(f"  {outcome.job.folder / name}  removed: it is made no more")
        if outcome.state != "up to date" or self._total <= self._few:
            _print_findings(outcome.findings, notes=self._total <= self._few)

    def begin(self, total: int) -> None:
        """Another round begins, over `total` sources."""
        self._line.close()
        self._started, self._total, self._count = time.monotonic(), total, 0
        self._line = ProgressLine(total)

    def close(self) -> None:
        self._line.close()

    def finish(self, outcomes: Sequence[Outcome], removed: Sequence[str], unasked: Sequence[Path] = ()) -> int:
        """The sum of a run, or the JSON; returns the exit code. `unasked`: images that no source asked for."""
        if self._json:
            print_json([outcome.to_json() for outcome in outcomes])
        else:
            for path in removed:
                print(f"{path}: removed, its source is gone")
            if unasked and not self._quiet:
                print(_unasked_text(unasked, everything=self._few > FEW))
            print("\n".join(self._sum(outcomes)), flush=True)
        return exit_code(outcomes)

    def again(self, outcomes: Sequence[Outcome], gone: Sequence[Path]) -> None:
        """The sum of one round of --watch."""
        for path in gone:
            print(f"{path}: gone; its outputs stay (`convert --clean` removes them)")
        if outcomes:
            print("\n".join(self._sum(outcomes)), flush=True)

    def dry_run(self, farm: Farm, plan: Plan) -> int:
        """Say what would be done; the exit code as far as it is known."""
        outcomes = list(plan.refused)
        for job, record, verdict in farm.look(plan.jobs):
            known = record is not None and verdict.fresh
            state = "up to date" if known else "would convert"
            outcome = Outcome(job, state, [] if known else verdict.reasons)
            if known and record is not None and record.error:
                outcome = Outcome(job, "failed", error=record.error, exit_code=record.exit_code)
            outcomes.append(outcome)
        self._line.close()
        if self._json:
            print_json([outcome.to_json() for outcome in outcomes])
            return exit_code(outcomes)
        for outcome in outcomes:
            if outcome.state == "would convert":
                print(f"would convert  {outcome.job.source}: {'; '.join(outcome.reasons)}")
            elif outcome.state == "failed" and outcome.job.name and not outcome.reasons:
                print(f"failed before  {outcome.job.source}")
        counts = Counter(outcome.state for outcome in outcomes)
        print(f"{counts['would convert']} to convert, {counts['up to date']} up to date, {counts['failed']} failed; "
              "nothing was written")  # fmt: skip
        return exit_code(outcomes)

    def _row(self, outcome: Outcome) -> str:
        width = len(str(self._total))
        place = f"[{min(self._count, self._total):>{width}}/{self._total}]"
        size = sum(output.size for output in outcome.outputs)
        if outcome.state == "up to date":
            return f"{place} up to date  {outcome.job.source}"
        files = f"{len(outcome.outputs)} file{'s' if len(outcome.outputs) != 1 else ''}"
        return (
            f"{place} {outcome.state:<10}  {outcome.job.source}  {files}, {size_text(size)}, {outcome.seconds:.2f} s"
            f"{_counted(outcome.findings)}"
        )

    def _sum(self, outcomes: Sequence[Outcome]) -> list[str]:
        spent = max(time.monotonic() - self._started, 1e-3)
        counts = Counter(outcome.state for outcome in outcomes)
        known = sum(1 for o in outcomes if o.state == "failed" and not o.reasons and o.job.name)
        if not counts["converted"] and not counts["cached"] and counts["failed"] == known:
            failed = f", {known} failed as before" if known else ""
            return [f"nothing to do: {counts['up to date']} up to date{failed} ({spent:.2f} s)"]
        done = counts["converted"] + counts["cached"] + counts["failed"]
        words = ("converted", "cached", "up to date", "failed")
        text = ", ".join(f"{counts[word]} {'from the cache' if word == 'cached' else word}"
                         for word in words if counts[word])  # fmt: skip
        size = sum(output.size for o in outcomes if o.state != "up to date" for output in o.outputs)
        lines = [f"{text}: {size_text(size)} in {spent:.2f} s ({done / spent:.1f} sources/s)"]
        slow = sorted((o for o in outcomes if o.seconds), key=lambda o: -o.seconds)[:SLOWEST]
        if len(outcomes) > FEW and slow:
            lines.append("slowest: " + ", ".join(f"{o.job.source.name} {o.seconds:.2f} s" for o in slow))
        return lines


def exit_code(outcomes: Sequence[Outcome]) -> int:
    """3 where something could not be written or run, else 1 where a source is bad, else 0."""
    return max((max(o.exit_code, 1 if o.has_errors else 0) for o in outcomes), default=0)


def _unasked_text(unasked: Sequence[Path], *, everything: bool) -> str:
    shown = ", ".join(map(str, unasked if everything else unasked[:FEW]))
    more = f" and {len(unasked) - FEW} more (--verbose lists them)" if len(unasked) > FEW and not everything else ""
    one = len(unasked) == 1
    return (f"{len(unasked)} image{' is' if one else 's are'} used by no model here and left out: {shown}{more}; "
            "to convert images, name them or a folder that holds nothing else")  # fmt: skip


def _counted(findings: Sequence[dict[str, Any]]) -> str:
    counts = Counter(finding["severity"] for finding in findings)
    words = {"error": "error", "warning": "warning", "info": "note"}
    parts = [f"{counts[s]} {word}{'s' if counts[s] != 1 else ''}" for s, word in words.items() if counts[s]]
    return "; " + (", ".join(parts) or "no findings")


def _print_findings(findings: Sequence[dict[str, Any]], *, notes: bool) -> None:
    from importers.cache import findings_of
    from importers.cli.output import print_findings

    for finding in findings:
        if finding["severity"] == "info" and not notes:
            continue
        print_findings(findings_of([finding], Path(finding["where"]["file"])))
