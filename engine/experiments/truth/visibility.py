"""Visibility by rays: which part of a disc in the sky is seen, and ambient occlusion. Deterministic points, turned."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.experiments.truth.rays import Rays
from engine.math.sphere import basis, cosine_hemisphere

F8 = NDArray[np.float64]

#: places times samples that are traced at once
BATCH = 1 << 18


def disc_points(count: int, turn: F8) -> F8:
    """Vogel's spiral [k,count,2] in the unit disc, turned by `turn` f8[k] radians (Vogel 1979)."""
    i = np.arange(count) + 0.5
    angle = i * np.pi * (3.0 - np.sqrt(5.0)) + turn[:, None]
    radius = np.sqrt(i / count)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


def sun_visibility(
    rays: Rays, places: F8, normals: F8, towards: F8, half_angle: float, samples: int, rng: np.random.Generator
) -> F8:
    """Part f8[n] of a sun that each of `places` [n,3] sees: direction `towards` [3], radius `half_angle` (radians).

    0 where the surface (unit `normals`) is turned away from its middle. With `half_angle` 0 one ray tells.
    """
    out = np.zeros(len(places))
    faces = np.flatnonzero(normals @ towards > 0.0)
    tangent, bitangent = (axis[0] for axis in basis(towards[None]))
    samples = samples if half_angle > 0.0 else 1
    for rows in np.array_split(faces, max(1, len(faces) * samples // BATCH)):
        if len(rows) == 0:
            continue
        xy = disc_points(samples, rng.uniform(0.0, 2.0 * np.pi, len(rows))) * np.tan(half_angle)
        d = towards + xy[..., :1] * tangent + xy[..., 1:] * bitangent
        d /= np.linalg.norm(d, axis=-1, keepdims=True)
        start = np.repeat(places[rows] + normals[rows] * rays.lift, samples, axis=0)
        open_ = ~rays.blocked(start, d.reshape(-1, 3))
        above = np.einsum("nsk,nk->ns", d, normals[rows]) > 0.0
        out[rows] = (open_.reshape(len(rows), samples) & above).mean(axis=1)
    return out


def ambient_occlusion(
    rays: Rays, places: F8, normals: F8, samples: int, rng: np.random.Generator, reach: float = np.inf,
    *, fades: bool = False,
) -> F8:  # fmt: skip
    """Cosine-weighted part f8[n] of the hemisphere that `places` [n,3] see free up to `reach` metres; 1 = open.

    `fades`: what stands at a distance d hides 1 - (d / reach)^2 of its direction, instead of all.

    The rays are cosine-distributed points of a lattice, shifted anew for each place (Cranley and Patterson 1976).
    """
    out = np.ones(len(places))
    golden = np.array([0.7548776662466927, 0.5698402909980532])  # Roberts 2018, the R2 sequence
    lattice = (np.arange(samples)[:, None] * golden) % 1.0
    for rows in np.array_split(np.arange(len(places)), max(1, len(places) * samples // BATCH)):
        u = (lattice + rng.uniform(size=(len(rows), 1, 2))) % 1.0
        local = cosine_hemisphere(u)
        tangent, bitangent = basis(normals[rows])
        frame = np.stack([tangent, bitangent, normals[rows]], axis=1)
        d = np.einsum("nsk,nkj->nsj", local, frame).reshape(-1, 3)
        start = np.repeat(places[rows] + normals[rows] * rays.lift, samples, axis=0)
        limit = None if not np.isfinite(reach) else np.full(len(d), reach)
        if fades:
            distance = rays.nearest(start, d).distance
            hidden = np.clip(1.0 - (distance / reach) ** 2, 0.0, 1.0)
            out[rows] = 1.0 - hidden.reshape(len(rows), samples).mean(axis=1)
            continue
        out[rows] = 1.0 - rays.blocked(start, d, limit).reshape(len(rows), samples).mean(axis=1)
    return out
