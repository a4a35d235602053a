"""How two pictures of one size differ: numbers for a machine, a map for an eye."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import InputError
from engine.report.perceptual import magma

#: a difference of 1/GAIN of the range, 8 levels of 256, is the brightest of the map
GAIN = 32


@dataclass(frozen=True, slots=True)
class PictureDifference:
    """`largest` and `rmse` in levels of 0..255 over all three channels; `differing`: share of the pixels that are not
    the same; `worst`: (x, y) of the largest difference. `flip`: mean FLIP, None where it was not asked for."""

    width: int
    height: int
    largest: int
    rmse: float
    differing: float
    worst: tuple[int, int]
    flip: float | None = None

    @property
    def equal(self) -> bool:
        return self.largest == 0

    def to_json(self) -> dict[str, Any]:
        return asdict(self)

    def line(self) -> str:
        """For people."""
        if self.equal:
            return "equal in every pixel"
        eye = f"FLIP {self.flip:.4f}   " if self.flip is not None else ""
        share = f"{100 * self.differing:.3g} % of pixels"
        return f"{eye}max {self.largest}   RMSE {self.rmse:.3g}   {share}"


def picture_difference(a: ArrayLike, b: ArrayLike, *, perceptual: bool = False) -> PictureDifference:
    """Compare u1[h,w,3|4] pictures; alpha does not count. FLIP (engine.report.perceptual) with `perceptual`.

    Raises InputError for other shapes, and LucarnaError where FLIP is asked for and not installed."""
    x, r = _rgb(a, b)
    distance = _distance(x, r)
    per_pixel = distance.max(axis=2)
    worst = int(per_pixel.argmax())
    height, width = per_pixel.shape
    flip = None
    if perceptual:
        from engine.report import perceptual as eye

        flip = 0.0 if not per_pixel.any() else eye.flip(x, r)[0]
    return PictureDifference(
        width, height, int(per_pixel.flat[worst]), math.sqrt(float(np.mean(distance.astype(np.float64) ** 2))),
        float(np.count_nonzero(per_pixel)) / per_pixel.size, (worst % width, worst // width), flip,
    )  # fmt: skip


def difference_map(a: ArrayLike, b: ArrayLike, gain: float = GAIN) -> NDArray[np.uint8]:
    """u1[h,w,3]: the largest difference of each pixel's channels, times `gain`, from black over violet to yellow."""
    distance = _distance(*_rgb(a, b)).max(axis=2)
    ramp = magma(np.minimum(np.arange(256) / 255.0 * gain, 1.0)[None])[0]
    return np.asarray(ramp[distance])


def _distance(x: NDArray[np.uint8], r: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.asarray(np.maximum(x, r) - np.minimum(x, r))


def _rgb(a: ArrayLike, b: ArrayLike) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    x, r = np.asarray(a), np.asarray(b)
    for picture in (x, r):
        if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] not in (3, 4) or picture.size == 0:
            raise InputError(f"a picture is u1[h,w,3] or u1[h,w,4], not {picture.dtype}{list(picture.shape)}")
    if x.shape[:2] != r.shape[:2]:
        sizes = " and ".join(f"{p.shape[1]}x{p.shape[0]}" for p in (x, r))
        raise InputError(f"the pictures have {sizes} pixels", hint="render both at one size")
    return x[:, :, :3], r[:, :, :3]
