"""Blending k poses of each character by weight, and the curves of cross-fades."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation import poses
from engine.animation.poses import R
from engine.core.errors import InputError

F8 = NDArray[np.float64]
Method = Literal["nlerp", "slerp"]

#: Weights that sum to no more than this say nothing: the rest pose stands in.
NOTHING = 1e-6
#: steps of the spherical mean; each squares the error
_MEAN_STEPS = 3

CURVES = ("linear", "smooth", "smoother", "ease_in", "ease_out")


def fade(progress: ArrayLike, curve: str = "smooth") -> F8:
    """The weight in [0,1] of what is faded in, after the share `progress` of the time (clamped).

    smooth: 3x^2 - 2x^3; smoother: 6x^5 - 15x^4 + 10x^3 (Perlin 2002); ease_in: x^2; ease_out: 1 - (1-x)^2.
    Raises InputError for another curve.
    """
    x = np.clip(np.nan_to_num(np.asarray(progress, np.float64), nan=1.0), 0.0, 1.0)
    if curve == "linear":
        return x
    if curve == "smooth":
        result: F8 = x * x * (3.0 - 2.0 * x)
    elif curve == "smoother":
        result = x * x * x * (x * (x * 6.0 - 15.0) + 10.0)
    elif curve == "ease_in":
        result = x * x
    elif curve == "ease_out":
        result = 1.0 - (1.0 - x) ** 2
    else:
        raise InputError(f"unknown fade curve {curve!r}", hint=f"choose one of {', '.join(CURVES)}")
    return result


@dataclass(slots=True)
class BlendJob:
    """`inputs` k poses f8[10,m,n], `weights` f8[k,m] or f8[k,m,n], `rest` f8[10,n] -> `out` f8[10,m,n].

    Weights need not sum to 1. Those that are negative or not finite count as 0; where they sum to 1e-6 or less the
    result is `rest`. Rotations are turned to the side of the heaviest input and averaged: nlerp normalises the mean
    (Blow 2004); slerp goes on to the spherical weighted mean (Buss and Fillmore 2001, algorithm A1), for two inputs
    Shoemake's slerp. Opposite rotations that cancel give the heaviest.
    """

    inputs: list[F8]
    weights: F8
    rest: F8
    out: F8
    method: Method = "nlerp"

    def validate(self) -> None:
        """Raise InputError when there is nothing to blend or the shapes do not fit."""
        poses.check(self.out, "out")
        _, m, n = self.out.shape
        if not self.inputs:
            raise InputError("nothing to blend", hint="give at least one pose")
        for i, pose in enumerate(self.inputs):
            poses.check(pose, f"inputs[{i}]", self.out.shape)
        k = len(self.inputs)
        if self.weights.shape not in ((k, m), (k, m, n)):
            raise InputError(f"weights have shape {self.weights.shape}, expected {(k, m)} or {(k, m, n)}")
        if self.rest.shape != (10, n):
            raise InputError(f"rest has shape {self.rest.shape}, expected {(10, n)}")
        if self.method not in ("nlerp", "slerp"):
            raise InputError(f"unknown method {self.method!r}", hint="choose nlerp or slerp")

    def run(self) -> None:
        weights, empty = shares(self.weights)
        if weights.ndim == 2:
            weights, empty = weights[:, :, None], empty[:, None]
        if len(self.inputs) == 1:
            self.out[...] = self.inputs[0]
        elif len(self.inputs) == 2:
            self._pair(weights)
        else:
            self._many(weights)
        if empty.any():
            np.copyto(self.out, self.rest[:, None, :], where=np.broadcast_to(empty, self.out.shape))

    def _pair(self, weights: F8) -> None:
        a, b = self.inputs
        if self.method == "slerp":
            rotation = poses.slerp(a[R], b[R], weights[1])
        else:
            rotation = poses.nlerp(a[R], b[R], weights[1])
        np.multiply(a, weights[0], out=self.out)
        self.out += weights[1] * b
        self.out[R] = rotation

    def _many(self, weights: F8) -> None:
        heaviest = np.argmax(weights, axis=0)
        pivot = np.zeros_like(self.out[R])
        for i, pose in enumerate(self.inputs):
            np.copyto(pivot, pose[R], where=np.broadcast_to(heaviest == i, pivot.shape))
        total = np.zeros_like(self.out)
        turned = []
        for weight, pose in zip(weights, self.inputs, strict=True):
            q = np.where(poses.dot(pose[R], pivot) < 0.0, -pose[R], pose[R])
            turned.append(q)
            total += weight * pose
            total[R] += weight * (q - pose[R])
        mean = poses.unit(total[R], pivot)
        if self.method == "slerp":
            mean = _spherical_mean(mean, turned, weights)
        self.out[...] = total
        self.out[R] = mean


def shares(weights: F8) -> tuple[F8, NDArray[np.bool_]]:
    """Weights [k,...] as shares that sum to 1 along the first axis, and where there is nothing to share: all 0."""
    clean = np.where(np.isfinite(weights) & (weights > 0.0), weights, 0.0)
    largest = clean.max(axis=0)
    scaled = clean / np.where(largest > 0.0, largest, 1.0)  # sums of huge weights do not overflow
    total = scaled.sum(axis=0)
    empty = total * np.minimum(largest, 1.0) <= NOTHING
    return np.where(empty, 0.0, scaled / np.where(total > 0.0, total, 1.0)), empty


def _spherical_mean(mean: F8, quaternions: list[F8], weights: F8) -> F8:
    """Move `mean` to the point of the unit sphere from which the weighted logarithms of the quaternions sum to 0."""
    for _ in range(_MEAN_STEPS):
        step = np.zeros_like(mean)
        for q, weight in zip(quaternions, weights, strict=True):
            cosine = poses.dot(q, mean)
            away = q - cosine * mean
            sine = np.sqrt(poses.dot(away, away))
            scale = np.where(sine > 1e-9, np.arctan2(sine, cosine) / np.where(sine > 1e-9, sine, 1.0), 1.0)
            step += (weight * scale) * away
        length = np.sqrt(poses.dot(step, step))
        safe = np.where(length > 1e-12, length, 1.0)
        mean = poses.unit(mean * np.cos(length) + step * (np.where(length > 1e-12, np.sin(length), 1.0) / safe), mean)
    return mean
