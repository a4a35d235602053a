"""What an eye would see: FLIP and SSIM, by flip-evaluator and scikit-image (the extra `report`)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import InputError, LucarnaError

Floats = NDArray[np.float32]

INSTALL = "pip install 'lucarna[report]'"


def flip(image: ArrayLike, reference: ArrayLike, *, hdr: bool = False) -> tuple[float, Floats]:
    """Return (mean FLIP, map f4[h,w]), 0 = no visible difference, 1 = the greatest (Andersson et al. 2020, 2021).

    Images [h,w,3]: u1 or floats in [0, 1], sRGB-encoded; with `hdr` scene-linear, non-negative. Seen at 67 pixels per
    degree. A non-finite pixel of `image` counts as black against white. Raises InputError, and LucarnaError where
    flip-evaluator is not installed.
    """
    x, r = _pair(image, reference)
    try:
        import flip_evaluator
    except ModuleNotFoundError as error:
        raise LucarnaError("FLIP needs the package flip-evaluator", hint=INSTALL) from error
    bad = np.asarray(~np.isfinite(x).all(axis=-1))
    x = np.where(bad[..., None], 0.0, x)
    if not hdr:
        x, r = np.clip(x, 0.0, 1.0), np.clip(r, 0.0, 1.0)
    result: Any = flip_evaluator.evaluate(
        np.ascontiguousarray(np.maximum(r, 0.0), np.float32), np.ascontiguousarray(np.maximum(x, 0.0), np.float32),
        "HDR" if hdr else "LDR", inputsRGB=not hdr, applyMagma=False, computeMeanError=False,
    )  # fmt: skip
    error_map = np.asarray(result[0], np.float32).reshape(x.shape[0], x.shape[1], -1)[..., 0]
    error_map = np.where(bad, np.float32(1.0), error_map)
    return float(error_map.mean(dtype=np.float64)), error_map


def ssim(image: ArrayLike, reference: ArrayLike) -> float:
    """Return the mean structural similarity (Wang et al. 2004) of images [h,w] or [h,w,3], u1 or floats in [0, 1].

    1 for equal images. At least 7 pixels each way. Raises InputError, and LucarnaError without scikit-image.
    """
    x, r = _pair(image, reference)
    if min(x.shape[:2]) < 7:
        raise InputError(f"SSIM looks at windows of 7 x 7 pixels; the images have {x.shape[1]} x {x.shape[0]}")
    if not np.isfinite(x).all():
        return -1.0
    try:
        from skimage.metrics import structural_similarity
    except ModuleNotFoundError as error:
        raise LucarnaError("SSIM needs the package scikit-image", hint=INSTALL) from error
    axis = 2 if x.ndim == 3 else None
    return float(structural_similarity(x, r, data_range=1.0, channel_axis=axis))


def _pair(image: ArrayLike, reference: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    x, r = (np.asarray(v) for v in (image, reference))
    if x.shape != r.shape or x.ndim not in (2, 3) or x.size == 0:
        raise InputError(f"cannot compare images of shapes {x.shape} and {r.shape}", hint="render both at one size")
    return tuple(v.astype(np.float64) / (255.0 if v.dtype == np.uint8 else 1.0) for v in (x, r))  # type: ignore[return-value]  # two of two


#: nine colours of the map "magma" (Smith and van der Walt 2015, CC0), evenly spaced
_MAGMA = np.array(
    [(0, 0, 4), (28, 16, 68), (79, 18, 123), (129, 37, 129), (181, 54, 122), (229, 80, 100), (251, 135, 97),
     (254, 194, 135), (252, 253, 191)],
    np.float64,
)  # fmt: skip


def magma(values: ArrayLike) -> NDArray[np.uint8]:
    """Colours u1[h,w,3] of `values` [h,w] in [0, 1], dark to bright: the way FLIP maps are shown."""
    place = np.clip(np.nan_to_num(np.asarray(values, np.float64), nan=1.0), 0.0, 1.0) * (len(_MAGMA) - 1)
    low = np.minimum(place.astype(int), len(_MAGMA) - 2)
    part = (place - low)[..., None]
    return np.asarray(np.rint(_MAGMA[low] * (1.0 - part) + _MAGMA[low + 1] * part)).astype(np.uint8)
