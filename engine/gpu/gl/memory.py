"""Where the bytes of an argument are, without a copy."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.core.errors import UsageError


def address_of(data: Any) -> tuple[int, int, Any]:
    """Address, size in bytes, and the object that keeps them alive, of bytes, a buffer or a C-contiguous array."""
    if not isinstance(data, np.ndarray):
        data = np.frombuffer(data, np.uint8)
    elif not data.flags.c_contiguous:
        raise UsageError(
            f"an array of shape {data.shape} and strides {data.strides} is not C-contiguous",
            hint="pass numpy.ascontiguousarray(...)",
        )
    return data.__array_interface__["data"][0], data.nbytes, data
