"""Layers: a pose laid over another, replacing it or added to it, node by node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from engine.animation import poses
from engine.animation.poses import R, S, T
from engine.core.errors import InputError

F8 = NDArray[np.float64]
Mode = Literal["override", "additive"]


@dataclass(slots=True)
class LayerJob:
    """Lay `layer` f8[10,m,n] over `base`, in place, with `weights` f8[m] times `mask` f8[n].

    override: from base to layer, weight in [0,1] (clamped). additive: the way from `reference` f8[10,n] to the layer
    is gone again from the base, weight times: translations add up, rotations q_base (q_ref^-1 q_layer)^w, scales
    multiply, each by (s_layer / s_ref)^w where both are positive and 1 + w (s_layer / s_ref - 1) elsewhere; a reference
    scale of 0 leaves the base's. Additive weights may be negative (the way back) or above 1. Weights that are not
    finite count as 0.
    """

    base: F8
    layer: F8
    weights: F8
    mask: F8
    mode: Mode = "override"
    reference: F8 | None = None

    def validate(self) -> None:
        """Raise InputError for shapes that do not fit, an unknown mode, or an additive layer without a reference."""
        poses.check(self.base, "base")
        poses.check(self.layer, "layer", self.base.shape)
        _, m, n = self.base.shape
        if self.weights.shape != (m,) or self.mask.shape != (n,):
            raise InputError(f"weights {self.weights.shape} and mask {self.mask.shape}, expected {(m,)} and {(n,)}")
        if not (np.isfinite(self.mask).all() and (self.mask >= 0.0).all() and (self.mask <= 1.0).all()):
            raise InputError("a mask's weights must be in [0, 1]")
        if self.mode not in ("override", "additive"):
            raise InputError(f"unknown layer mode {self.mode!r}", hint="choose override or additive")
        if self.mode == "additive" and (self.reference is None or self.reference.shape != (10, n)):
            raise InputError("an additive layer needs a reference pose", hint="name the pose its clip starts from")

    def run(self) -> None:
        weights = np.where(np.isfinite(self.weights), self.weights, 0.0)
        who = np.flatnonzero(weights)
        nodes = np.flatnonzero(self.mask)
        if len(who) == 0 or len(nodes) == 0:
            return
        part = np.ix_(np.arange(10), who, nodes)
        weight = weights[who, None] * self.mask[None, nodes]
        base, layer = self.base[part], self.layer[part]
        if self.mode == "override":
            self.base[part] = _override(base, layer, np.clip(weight, 0.0, 1.0))
        else:
            assert self.reference is not None
            self.base[part] = _add(base, layer, self.reference[:, None, nodes], weight)


def _override(base: F8, layer: F8, weight: F8) -> F8:
    result: F8 = base + weight * (layer - base)
    result[R] = poses.nlerp(base[R], layer[R], weight)
    return result


def _add(base: F8, layer: F8, reference: F8, weight: F8) -> F8:
    result = base.copy()
    result[T] += weight * (layer[T] - reference[T])
    way = poses.multiply(poses.conjugate(np.broadcast_to(reference[R], base[R].shape)), layer[R])
    result[R] = poses.unit(poses.multiply(base[R], poses.power(way, weight)), base[R])
    known = reference[S] != 0.0
    ratio = np.where(known, layer[S] / np.where(known, reference[S], 1.0), 1.0)
    positive = ratio > 0.0
    result[S] *= np.where(positive, np.where(positive, ratio, 1.0) ** weight, 1.0 + weight * (ratio - 1.0))
    return result
