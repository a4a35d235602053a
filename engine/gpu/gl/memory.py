"""Where the bytes of an argument are, without a copy."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.gpu import validate


def address_of(data: Any) -> tuple[int, int, Any]:
    """Address, size in bytes, and the object that keeps them alive, of bytes, a buffer or a C-contiguous array."""
    if not isinstance(data, np.ndarray) or not data.flags.c_contiguous:
        data = validate.as_bytes(data)
    return data.__array_interface__["data"][0], data.nbytes, data
