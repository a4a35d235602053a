"""What the literature says of the paths, held against measured times. Times: ms by (path, number of lights).

Olsson and Assarsson 2011, "Tiled Shading", and Harada, McKee and Yang 2012, "Forward+: Bringing Deferred Lighting to
the Next Level", are where the expectations are from.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

Times = Mapping[tuple[str, int], float]

HOLDS, PARTLY, FAILS, UNKNOWN = "holds", "holds in part", "does not hold", "not measured"
#: up to so many lights classic deferred lighting is said to be best
FEW = 100
#: a light more costs the classic form at least so many times as much
TIMES_CHEAPER = 10.0
#: from so many lights on, the slope is the method's
MANY = 1024
CLASSIC, TILED, PLUS = "deferred", "tiled-deferred", "forward-plus"


def shared(times: Times, *paths: str) -> list[int]:
    """The numbers of lights that all `paths` were measured at, ascending."""
    counts = sorted({count for _, count in times})
    return [n for n in counts if all((path, n) in times for path in paths)]


def crossover(times: Times, slow: str, fast: str) -> float | None:
    """The number of lights from which on `fast` stays at most as slow as `slow`, between two measured ones by a line
    in log-log. 0: always; None: not at the largest number that both have, or nothing is measured."""
    counts = shared(times, slow, fast)
    gaps = [math.log(times[fast, n] / times[slow, n]) for n in counts]
    if not counts or gaps[-1] > 0.0:
        return None
    last = next((i for i in range(len(counts) - 1, -1, -1) if gaps[i] > 0.0), -1)
    if last < 0:
        return 0.0
    share = gaps[last] / (gaps[last] - gaps[last + 1])
    return math.exp(math.log(counts[last]) + share * math.log(counts[last + 1] / counts[last]))


def slope(times: Times, path: str, among: Sequence[str] = ()) -> float | None:
    """ms a light between MANY lights and the most that `path` and all `among` were measured at."""
    counts = [n for n in shared(times, path, *among) if n >= MANY]
    if len(counts) < 2:
        return None
    return (times[path, counts[-1]] - times[path, counts[0]]) / (counts[-1] - counts[0])


def claims(times: Times) -> list[list[str]]:
    """Rows of (what is claimed, whether it came out, the figures)."""
    return [_few(times), _thousands(times), _plus(times)]


def _few(times: Times) -> list[str]:
    said = f"Deferred is fastest below about {FEW} lights"
    counts = shared(times, CLASSIC, TILED, PLUS)
    few, more = [n for n in counts if n <= FEW], [n for n in counts if n > FEW]
    if not few or not more:
        return [said, UNKNOWN, f"measured at {len(few)} counts up to {FEW}, at {len(more)} above"]
    won = {n for n in counts if times[CLASSIC, n] <= min(times[TILED, n], times[PLUS, n])}
    below, above = len(won & set(few)), len(won & set(more))
    verdict = FAILS if not below else HOLDS if below == len(few) and above <= len(more) // 4 else PARTLY
    return [
        said, verdict,
        f"fastest of the three at {below} of {len(few)} counts up to {FEW} and at {above} of {len(more)} above; "
        f"{_crossed(times, TILED)}; {_crossed(times, PLUS)}",
    ]  # fmt: skip


def _crossed(times: Times, path: str) -> str:
    at = crossover(times, CLASSIC, path)
    if at is None:
        return f"{path} is not faster at the most lights"
    return f"{path} is faster from {at:,.0f} lights on (N*)" if at else f"{path} is faster at every count"


def _thousands(times: Times) -> list[str]:
    said = f"Tiled lighting scales to thousands: a light past {MANY:,} costs a {TIMES_CHEAPER:g}th of deferred's or less"
    classic, tiled = slope(times, CLASSIC, (TILED,)), slope(times, TILED, (CLASSIC,))
    if classic is None or tiled is None:
        return [said, UNKNOWN, f"deferred and tiled-deferred were not both measured above {MANY:,} lights"]
    ratio = math.inf if tiled <= 0.0 else classic / tiled
    verdict = HOLDS if ratio >= TIMES_CHEAPER else PARTLY if ratio > 1.0 else FAILS
    plus, most = slope(times, PLUS, (CLASSIC,)), shared(times, CLASSIC, TILED)[-1]
    also = f", forward-plus {plus * 1e3:.3g}" if plus is not None else ""
    cheaper = "does not grow" if ratio == math.inf else f"{ratio:.3g} times less"
    return [
        said, verdict,
        f"µs a light from {MANY:,} to {most:,}: deferred {classic * 1e3:.3g}, tiled-deferred {tiled * 1e3:.3g}{also}; "
        f"tiled-deferred: {cheaper}",
    ]  # fmt: skip


def _plus(times: Times) -> list[str]:
    said = "Forward+ beats tiled deferred"
    counts = shared(times, TILED, PLUS)
    if not counts:
        return [said, UNKNOWN, "the two were not both measured"]
    ratios = [times[PLUS, n] / times[TILED, n] for n in counts]
    wins = sum(ratio < 1.0 for ratio in ratios)
    verdict = HOLDS if wins == len(counts) else PARTLY if wins else FAILS
    least, most = min(ratios), max(ratios)
    return [
        said, verdict,
        f"faster at {wins} of {len(counts)} counts; its time over tiled-deferred's goes from {least:.2f} to {most:.2f}",
    ]  # fmt: skip
