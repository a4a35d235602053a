"""A picture beside its truth, and where an eye would see the difference."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context
from engine.report.perceptual import flip, magma
from engine.report.records import Picture

Bytes = NDArray[np.uint8]


def beside_truth(ctx: Context, name: str, image: Bytes, truth_name: str, truth: Bytes) -> list[Picture]:
    """`image` and `truth` u1[h,w,3], sRGB, and the FLIP map; without the map, and said so, where FLIP is missing."""
    row = [Picture(name, np.ascontiguousarray(image)), Picture(truth_name, np.ascontiguousarray(truth))]
    try:
        mean, error_map = flip(image, truth)
    except LucarnaError as error:
        ctx.omit("FLIP maps", str(error))
        return row
    return [*row, Picture(f"FLIP, mean {mean:.3g}", magma(error_map))]
