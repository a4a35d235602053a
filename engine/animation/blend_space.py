"""Blend spaces: from one or two parameters to the weights of the clips placed among them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import InputError

F8 = NDArray[np.float64]

#: squares of distances must stay finite
_FARTHEST = 1e100


class BlendSpace:
    """k samples at `points` f8[k] or f8[k,1|2]; `weights` gives their shares at any point, continuous, summing to 1.

    One dimension: linear between neighbours, the end samples beyond. Two: gradient band interpolation (Johansen,
    "Automated Semi-Procedural Animation for Character Locomotion", 2009, section 6.3.1), which needs no triangulation
    and is defined outside the samples' hull: sample i weighs min over j of 1 - (p - p_i).(p_j - p_i) / |p_j - p_i|^2,
    cut at [0, 1], then all are normalised. Samples at one place share its weight.
    Raises InputError for no samples, more than two dimensions or a point that is not finite.
    """

    def __init__(self, points: ArrayLike) -> None:
        places = np.asarray(points, np.float64)
        if places.ndim == 1:
            places = places[:, None]
        if places.ndim != 2 or not len(places) or places.shape[1] not in (1, 2):
            raise InputError(f"a blend space has samples at [k,1] or [k,2], got {places.shape}")
        if not (np.abs(places) <= _FARTHEST).all():
            raise InputError("a blend space's samples must be at finite places", hint=f"within {_FARTHEST:g} of 0")
        self.points = places
        step = places[None, :, :] - places[:, None, :]  # [i,j,d]: from i to j
        square = np.einsum("ijd,ijd->ij", step, step)
        apart = square > 1e-24 * max(float(square.max()), 1e-280)
        self._apart = apart
        self._toward = np.where(apart[..., None], step / np.where(apart, square, 1.0)[..., None], 0.0)

        self._low, self._high = places.min(axis=0), places.max(axis=0)
        line, copies = np.unique(places[:, 0], return_inverse=True)
        self._places = line, copies, np.bincount(copies)[copies][:, None]

    @property
    def dimensions(self) -> int:
        return int(self.points.shape[1])

    def weights(self, at: ArrayLike) -> F8:
        """f8[k,m] for points f8[m] (one dimension) or f8[m,d]; what is not finite counts as 0."""
        place = np.asarray(at, np.float64)
        if not np.isfinite(place).all():
            place = np.nan_to_num(place, nan=0.0, posinf=1e150, neginf=-1e150)
        if place.ndim == 1 and self.dimensions == 1:
            place = place[:, None]
        if place.ndim != 2 or place.shape[1] != self.dimensions:
            raise InputError(f"points {place.shape} in a blend space of {self.dimensions} dimensions")
        # beyond the samples' box nothing new is to be found, and huge numbers would cancel
        place = np.minimum(np.maximum(place, self._low), self._high)
        if self.dimensions == 1:
            return self._line(place[:, 0])
        from_i = place[None, :, :] - self.points[:, None, :]  # [i,m,d]
        influence = 1.0 - np.einsum("imd,ijd->imj", from_i, self._toward)
        influence = np.where(self._apart[:, None, :], influence, 1.0).min(axis=2)
        raw = np.clip(influence, 0.0, 1.0)
        total = raw.sum(axis=0)
        nearest = np.argmin(np.einsum("imd,imd->im", from_i, from_i), axis=0)
        lost = total <= 1e-12
        raw[nearest[lost], np.flatnonzero(lost)] = 1.0
        result: F8 = raw / raw.sum(axis=0)
        return result

    def _line(self, x: F8) -> F8:
        places, copies, alike = self._places
        share = np.zeros((len(places), len(x)))
        who = np.arange(len(x))
        if len(places) == 1:
            share[0] = 1.0
        else:
            left = np.minimum(np.maximum(places.searchsorted(x, side="right") - 1, 0), len(places) - 2)
            u = (x - places[left]) / (places[left + 1] - places[left])
            share[left, who] = 1.0 - u
            share[left + 1, who] = u
        result: F8 = share[copies] / alike
        return result
