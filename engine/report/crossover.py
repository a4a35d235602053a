"""Where one method becomes cheaper than another as a problem grows, between the sizes that were measured."""

from __future__ import annotations

import math
from collections.abc import Sequence


def crossover(sizes: Sequence[float], first: Sequence[float], second: Sequence[float]) -> float | None:
    """The size from which on `second` costs no more than `first`, at all larger sizes that were measured.

    `sizes` ascend; costs are positive. Between two sizes costs follow powers of the size (lines where both axes are
    logarithmic). The smallest size if `second` costs no more anywhere; None if it costs more at the largest.
    """
    ahead = [math.log(b / a) for a, b in zip(first, second, strict=True)]
    if not ahead or ahead[-1] > 0.0:
        return None
    last = max((i for i, value in enumerate(ahead) if value > 0.0), default=-1)
    if last < 0:
        return float(sizes[0])
    part = ahead[last] / (ahead[last] - ahead[last + 1])
    low, high = math.log(sizes[last]), math.log(sizes[last + 1])
    return math.exp(low + part * (high - low))
