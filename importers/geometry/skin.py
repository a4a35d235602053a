"""Skin influences: sorted by weight, cut to eight, and made to sum to exactly one in unorm16."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Influences:
    """`joints` u2[n,k], `weights` u2[n,k] (rows sum to 65535), k is 4 or 8, and what had to be mended, in vertices."""

    joints: NDArray[np.uint16]
    weights: NDArray[np.uint16]
    renormalised: int
    without_weight: int
    cut: int


def normalise_influences(joints: NDArray[np.int64], weights: NDArray[np.float64]) -> Influences:
    """From joints i8[n,m] and weights f8[n,m] of any sum. Negative and non-finite weights count as 0.

    A vertex without any weight is bound to its first joint. A sum off by more than 1e-3 counts as renormalised;
    glTF 2.0 (section 3.7.3.3) allows 2e-7 per influence for floats, and integer weights round more coarsely.
    """
    usable = np.isfinite(weights) & (weights > 0)
    mended = int((~np.isfinite(weights) | (weights < 0)).any(axis=1).sum())
    weights = np.where(usable, weights, 0.0)
    order = np.argsort(-weights, axis=1, kind="stable")
    weights = np.take_along_axis(weights, order, 1)
    joints = np.take_along_axis(joints, order, 1)
    cut = int((weights[:, 8:] > 0).any(axis=1).sum())
    width = 8 if (weights[:, 4:] > 0).any() else 4
    weights, joints = _fit(weights, width), _fit(joints, width)
    total = weights.sum(axis=1)
    without = total <= 0
    off = (np.abs(total - 1.0) > 1e-3) & ~without
    weights[without, 0] = 1.0
    weights /= np.where(without, 1.0, total)[:, None]
    joints = np.where(weights > 0, joints, 0)
    return Influences(
        joints.astype("<u2"), _round_to_whole(weights), max(int(off.sum()), mended), int(without.sum()), cut
    )


def _fit(values: NDArray[Any], width: int) -> NDArray[Any]:
    out = np.zeros((len(values), width), values.dtype)
    shared = min(width, values.shape[1])
    out[:, :shared] = values[:, :shared]
    return out


def _round_to_whole(weights: NDArray[np.float64]) -> NDArray[np.uint16]:
    """unorm16 whose rows sum to 65535: largest remainders are rounded up, the rest down."""
    exact = weights * 65535.0
    floor = np.floor(exact)
    missing = np.rint(65535.0 - floor.sum(axis=1)).astype(np.int64)
    rank = np.argsort(np.argsort(-(exact - floor), axis=1, kind="stable"), axis=1, kind="stable")
    return np.asarray(floor + (rank < missing[:, None])).astype(np.uint16)
