"""Pareto fronts: which points no other point beats in both cost and error."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import ArrayLike, NDArray


def pareto_front(cost: ArrayLike, error: ArrayLike) -> NDArray[np.bool_]:
    """True for each of n points that no other point beats: no less cost with no more error, and one of them better.

    Points with a non-finite cost or error are never on the front; equal points are on it together.
    """
    c, e = np.asarray(cost, np.float64), np.asarray(error, np.float64)
    finite = np.isfinite(c) & np.isfinite(e)
    front = np.zeros(len(c), bool)
    for i in np.flatnonzero(finite):
        no_worse = finite & (c <= c[i]) & (e <= e[i])
        better = (c < c[i]) | (e < e[i])
        front[i] = not bool((no_worse & better).any())
    return front


def gain(cost: ArrayLike, error: ArrayLike) -> NDArray[np.float64]:
    """Error removed per unit of cost at each point of the front against the front's cheaper neighbour.

    NaN off the front and at its cheapest point. The largest says where another millisecond is spent best.
    """
    c, e = np.asarray(cost, np.float64), np.asarray(error, np.float64)
    rows = np.flatnonzero(pareto_front(c, e))
    rows = rows[np.argsort(c[rows], kind="stable")]
    result = np.full(len(c), np.nan)
    for before, after in itertools.pairwise(rows):
        step = c[after] - c[before]
        result[after] = (e[before] - e[after]) / step if step > 0.0 else np.nan
    return result


#: an error that is this much smaller is smaller: less is rounding or noise
CLEARLY_LESS = 0.98


def clearly_less(a: float, b: float) -> bool:
    """Whether error `a` is smaller than `b` by more than rounding or noise would make it."""
    return a < CLEARLY_LESS * b
