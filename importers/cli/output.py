"""What the commands print alike: sizes, times, findings."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable
from typing import Any

from engine.core.findings import Finding, Findings, Severity


def size_text(size: int) -> str:
    """Bytes for people: 512 B, 12.3 KB, 4.1 MB (powers of 1000)."""
    value, unit = float(size), "B"
    for unit in ("B", "KB", "MB", "GB"):
        if value < 1000 or unit == "GB":
            break
        value /= 1000
    return f"{value:.0f} {unit}" if unit == "B" else f"{value:.1f} {unit}"


def print_findings(findings: Findings, *, errors_to_stderr: bool = True) -> None:
    """Each finding on a line; errors go to stderr."""
    for finding in findings:
        error = finding.severity is Severity.ERROR and errors_to_stderr
        print(f"  {finding}", file=sys.stderr if error else sys.stdout)
    if findings.left_out:
        print(f"  … and {findings.left_out:,} more findings")


def count_text(findings: Iterable[Finding]) -> str:
    """'2 errors, 1 warning, 3 notes', or 'no findings'."""
    totals = dict.fromkeys(Severity, 0)
    for finding in findings:
        totals[finding.severity] += 1
    words = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "note"}
    parts = [f"{totals[s]} {word}{'s' if totals[s] != 1 else ''}" for s, word in words.items() if totals[s]]
    return ", ".join(parts) or "no findings"


def terminal_progress() -> Callable[[str, float], None] | None:
    """A progress callback that rewrites one line of the terminal, or None where stderr is no terminal."""
    if not sys.stderr.isatty():
        return None

    def show(what: str, share: float) -> None:
        end = "\r" if share < 0.9 else "\r\033[K"
        print(f"\r\033[K{share * 100:3.0f} % {what[:60]}", end=end, file=sys.stderr, flush=True)

    return show


def print_json(data: Any) -> None:
    """Machine output: one JSON value on stdout."""
    print(json.dumps(data, indent=2, sort_keys=True, ensure_ascii=False))
