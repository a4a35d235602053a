"""Keys in 16 bits: how the values of a clip's channel are written as whole numbers, and read again.

    box        every component between the channel's least and greatest:  value = low + code * step
    without i  a rotation whose component i never gets small: the other three as a box, the i-th is what is missing to
               length 1 (it is positive: q and -q are the same rotation)
    largest    a rotation's three smaller components, 15 bits each between +-1/sqrt 2, and two bits for which is missing
    float      float32 as they are

6 bytes a key (a box of a rotation: 8). All is done with sums, products, quotients and square roots, which IEEE 754
rounds alike on every machine: the same keys give the same bytes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

F8 = NDArray[np.float64]
U2 = NDArray[np.uint16]

FLOAT, BOX, LARGEST, WITHOUT = 0, 1, 2, 3  # WITHOUT + i for component i
CODINGS = ("float", "box", "largest", "without x", "without y", "without z", "without w")
STEPS = 65535
#: a missing component smaller than this would magnify the others' errors too much
_LEAST = 0.5
_OTHERS = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])


@dataclass(frozen=True, slots=True)
class KeyCodes:
    """`codes` u2[k,c]; `low`, `step` f4[c] where the coding has a box, else empty. `coding` as in CODINGS."""

    coding: int
    codes: U2
    low: NDArray[np.float32]
    step: NDArray[np.float32]

    @property
    def nbytes(self) -> int:
        return self.codes.nbytes + self.low.nbytes + self.step.nbytes

    def decode(self) -> NDArray[np.float32]:
        """f4[k,3|4]; rotations are unit, as far as float32 goes."""
        if self.coding == LARGEST:
            return decode_largest(self.codes).astype(np.float32)
        values = self.low.astype(np.float64) + self.codes * self.step.astype(np.float64)
        if self.coding == BOX:
            return (unit(values) if values.shape[1] == 4 else values).astype(np.float32)
        return _completed(values, np.full(len(values), self.coding - WITHOUT)).astype(np.float32)


def box_width(coding: int, width: int) -> int:
    """How many components have a range; `width`: 4 for rotations, else 3."""
    return 0 if coding in (FLOAT, LARGEST) else width if coding == BOX else 3


def code_width(coding: int, width: int) -> int:
    """How many codes a key has; 0 for float."""
    return 0 if coding == FLOAT else width if coding == BOX else 3


def candidates(values: ArrayLike) -> Iterator[KeyCodes]:
    """The codings of keys f[k,3] or of unit rotations f[k,4], the shortest and most exact first."""
    wide = np.asarray(values, np.float64)
    if wide.shape[1] != 4:
        yield _boxed(BOX, wide)
        return
    least = np.abs(wide).min(axis=0)
    missing = int(np.argmax(least))
    if least[missing] >= _LEAST:
        turned = wide * np.where(wide[:, missing : missing + 1] < 0.0, -1.0, 1.0)
        yield _boxed(WITHOUT + missing, turned[:, _OTHERS[missing]])
    empty = np.zeros(0, np.float32)
    yield KeyCodes(LARGEST, encode_largest(wide), empty, empty)
    # along the keys, so that q and -q do not fill the box with both sides
    flips = np.where(np.sum(wide[1:] * wide[:-1], axis=1) < 0.0, -1.0, 1.0)
    sides = np.concatenate([np.ones(min(len(wide), 1)), np.cumprod(flips)])
    yield _boxed(BOX, wide * sides[:, None])


def encode_largest(q: F8) -> U2:
    """u2[k,3] of unit quaternions f8[k,4]: 15 bits each of the three smaller, the largest's number in the top bits."""
    largest = np.argmax(np.abs(q), axis=1)
    sign = np.where(np.take_along_axis(q, largest[:, None], axis=1) < 0.0, -1.0, 1.0)
    small = np.take_along_axis(q * sign, _OTHERS[largest], axis=1)  # in [-1/sqrt 2, 1/sqrt 2]
    code: U2 = np.rint((small * np.sqrt(2.0) + 1.0) * 0.5 * 32767.0).clip(0, 32767).astype(np.uint16)
    code[:, 0] |= ((largest >> 1) << 15).astype(np.uint16)
    code[:, 1] |= ((largest & 1) << 15).astype(np.uint16)
    return code


def decode_largest(code: U2) -> F8:
    """Unit quaternions f8[k,4]."""
    wide = code.astype(np.int64)
    largest = (wide[:, 0] >> 15) * 2 + (wide[:, 1] >> 15)
    return _completed(((wide & 32767) / 32767.0 * 2.0 - 1.0) / np.sqrt(2.0), largest)


def unit(q: F8) -> F8:
    """`q` f8[k,4] made unit; (0,0,0,1) where it has no length."""
    square = q[:, 0] * q[:, 0] + q[:, 1] * q[:, 1] + q[:, 2] * q[:, 2] + q[:, 3] * q[:, 3]
    good = square > 0.0
    result: F8 = q / np.sqrt(np.where(good, square, 1.0))[:, None]
    result[~good] = (0.0, 0.0, 0.0, 1.0)
    return result


def _completed(three: F8, missing: NDArray[np.int64]) -> F8:
    """Unit quaternions f8[k,4] from three components and the numbers i8[k] of the missing ones."""
    q = np.zeros((len(three), 4))
    np.put_along_axis(q, _OTHERS[missing], three, axis=1)
    rest = 1.0 - (three[:, 0] * three[:, 0] + three[:, 1] * three[:, 1] + three[:, 2] * three[:, 2])
    np.put_along_axis(q, missing[:, None], np.sqrt(np.maximum(rest, 0.0))[:, None], axis=1)
    return unit(q)


def _boxed(coding: int, values: F8) -> KeyCodes:
    low = values.min(axis=0, initial=np.inf) if len(values) else np.zeros(values.shape[1])
    high = values.max(axis=0, initial=-np.inf) if len(values) else low
    # rounded outward: every value then lies in the box
    low4 = low.astype(np.float32)
    low4 = np.where(low4 > low, np.nextafter(low4, np.float32(-np.inf)), low4)
    span = (high - low4.astype(np.float64)) / STEPS
    step4 = span.astype(np.float32)
    step4 = np.where((step4 < span) & (span > 0.0), np.nextafter(step4, np.float32(np.inf)), step4)
    step = step4.astype(np.float64)
    codes = np.rint((values - low4.astype(np.float64)) / np.where(step > 0.0, step, 1.0)).clip(0, STEPS)
    return KeyCodes(coding, codes.astype(np.uint16), low4.astype(np.float32), step4.astype(np.float32))
