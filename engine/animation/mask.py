"""Bone masks: how much each node of a rig follows a layer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation.rig import Rig
from engine.animation.sampler import ClipSampler
from engine.core.errors import InputError

F8 = NDArray[np.float64]


def everything(rig: Rig) -> F8:
    """f8[n] of ones."""
    return np.ones(len(rig))


def subtree(rig: Rig, root: str, weight: float = 1.0, fall_off: int = 0) -> F8:
    """f8[n]: `weight` on `root` and all below it, 0 elsewhere.

    With `fall_off` the mask rises from the root on: a node d steps below it has (d + 1) / (fall_off + 1) of the
    weight, at most all of it. Raises InputError for an unknown node, a weight outside [0,1] or a negative fall-off.
    """
    if not 0.0 <= weight <= 1.0 or fall_off < 0:
        raise InputError(f"mask of {root!r}: weight {weight}, fall-off {fall_off}", hint="a weight is in [0, 1]")
    distance = rig.below(rig.index(root))
    return np.where(distance >= 0, weight * np.minimum((distance + 1.0) / (fall_off + 1.0), 1.0), 0.0)


def combine(rig: Rig, masks: Iterable[ArrayLike], overrides: Mapping[str, float] | None = None) -> F8:
    """f8[n]: the greatest of the masks at each node, then `overrides` by node name.

    Raises InputError for an unknown node or a weight outside [0,1].
    """
    result = np.zeros(len(rig))
    for mask in masks:
        result = np.maximum(result, np.asarray(mask, np.float64))
    for name, weight in (overrides or {}).items():
        if not 0.0 <= weight <= 1.0:
            raise InputError(f"mask of {name!r}: weight {weight}", hint="a weight is in [0, 1]")
        result[rig.index(name)] = weight
    return result


def uncovered(rig: Rig, mask: F8, samplers: Iterable[ClipSampler]) -> list[str]:
    """The names of nodes under the mask that none of the clips moves: there a layer holds the rest pose."""
    moved = np.zeros(len(rig), np.bool_)
    for sampler in samplers:
        moved |= sampler.covers.any(axis=0)
    return [rig.names[i] for i in np.flatnonzero((mask > 0.0) & ~moved)]
