"""Projections: clip_from_view with y up and reversed z in [0, 1] (near = 1, far = 0)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError

F8 = NDArray[np.float64]


def perspective_reversed(yfov: float, aspect: float, znear: float) -> F8:
    """Return clip_from_view f8[4,4] with vertical view angle `yfov` (radians), aspect = width / height, no far plane.

    Depth is znear / distance: 1 at the near plane, towards 0 at infinity. Raises InputError for an impossible lens.
    """
    if not (0.0 < yfov < math.pi and _positive(aspect) and _positive(znear)):
        raise InputError(
            f"impossible camera: yfov {yfov:g}, aspect {aspect:g}, znear {znear:g}",
            hint="yfov must lie between 0 and pi radians, aspect and znear must be positive",
        )
    focal = 1.0 / math.tan(yfov / 2.0)
    m = np.zeros((4, 4))
    m[0, 0] = focal / aspect
    m[1, 1] = focal
    m[2, 3] = znear
    m[3, 2] = -1.0
    return m


def orthographic_reversed(ymag: float, aspect: float, znear: float, zfar: float) -> F8:
    """Return clip_from_view f8[4,4] of a box with half height `ymag`, half width ymag * aspect, znear < -z < zfar.

    Depth falls linearly from 1 at `znear` (which may be negative) to 0 at `zfar`. Raises InputError for an empty box.
    """
    if not (_positive(ymag) and _positive(aspect) and math.isfinite(znear) and _positive(zfar - znear)):
        raise InputError(
            f"impossible camera: ymag {ymag:g}, aspect {aspect:g}, znear {znear:g}, zfar {zfar:g}",
            hint="ymag and aspect must be positive and zfar beyond znear",
        )
    m = np.zeros((4, 4))
    m[0, 0] = 1.0 / (ymag * aspect)
    m[1, 1] = 1.0 / ymag
    m[2, 2] = 1.0 / (zfar - znear)
    m[2, 3] = zfar / (zfar - znear)
    m[3, 3] = 1.0
    return m


def _positive(value: float) -> bool:
    return 0.0 < value < math.inf
