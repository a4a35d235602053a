"""Linearly transformed cosines for GGX in float64: the fit, the form factor of polygons, and the look-up's coordinates.

Heitz, Dupuy, Hill and Neubelt 2016, "Real-Time Polygonal-Light Shading with Linearly Transformed Cosines", eq. 3 to 11:
a clamped cosine over directions w, taken through a matrix M, has the density cos(M^-1 w) |M^-1| / |M^-1 w|^3 and its
integral over a polygon is that of the plain cosine over the polygon taken through M^-1. M is fitted to GGX with
height-correlated Smith masking, without Fresnel, which the split-sum table holds already.

Frame: normal +Z, the viewer in the XZ plane at x >= 0; then M^-1 has five entries that are not 0, and its size does not
count: the table holds M^-1 [0,0], [0,2], [2,0], [2,2] over [1,1], texels on the rim.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.math import ggx

F8 = NDArray[np.float64]

#: perceptual roughness that the table's first row stands for; nothing smoother is looked up
SMOOTHEST = 0.02
#: directions a fit looks at, squared: so many of the lobe and so many of the cosine
_SAMPLES = 24
_STEPS = 400
#: a fit is done when its corners' errors are this near each other, relative
_DONE = 1e-5


def rows(size: int) -> F8:
    """Return the perceptual roughness f8[size] of each row."""
    return np.maximum(np.linspace(0.0, 1.0, size), SMOOTHEST)


def columns(size: int) -> F8:
    """Return n.v f8[size] of each column: 1 - t^2 for t from 0 to 1, dense where the lobe is flattened."""
    return np.maximum(1.0 - np.linspace(0.0, 1.0, size) ** 2, 1e-3)


def fit_table(size: int) -> F8:
    """Return f8[size,size,4]: row = roughness, column = sqrt(1 - n.v). Each column's fit starts from the one before.

    Minutes for 64; the same every time.
    """
    return fit_rows(rows(size), columns(size))


def fit_rows(roughness: F8, cosines: F8) -> F8:
    """Return f8[n,m,4] for `roughness` f8[n], each a problem of its own, along n.v `cosines` f8[m] from 1 down."""
    alpha = roughness * roughness
    zero = np.zeros(len(alpha))
    start = np.stack([alpha, alpha, zero, zero], axis=1)
    out = np.zeros((len(alpha), len(cosines), 4))
    for column, cosine in enumerate(cosines.tolist()):
        lobe = _Lobe(alpha, cosine)
        start = _nelder_mead(lobe.error, start)
        inverse = np.linalg.inv(lobe.matrix(start))
        inverse /= inverse[:, 1:2, 1:2]
        out[:, column] = np.stack([inverse[:, i, j] for i, j in ((0, 0), (0, 2), (2, 0), (2, 2))], axis=1)
    return out


def look_up(table: ArrayLike, roughness: ArrayLike, n_dot_v: ArrayLike) -> F8:
    """Return M^-1 f8[...,3,3] by bilinear look-up, as the shader's: `table` [s,s,4]."""
    table = np.asarray(table, np.float64)
    rough, mu = np.broadcast_arrays(np.asarray(roughness, np.float64), np.asarray(n_dot_v, np.float64))
    last = len(table) - 1
    y, x = np.clip(rough, 0.0, 1.0) * last, np.sqrt(np.clip(1.0 - mu, 0.0, 1.0)) * last
    j, i = (np.minimum(v.astype(np.int64), max(last - 1, 0)) for v in (y, x))
    fy, fx = (y - j)[..., None], (x - i)[..., None]
    j1, i1 = np.minimum(j + 1, last), np.minimum(i + 1, last)
    low = table[j, i] * (1.0 - fx) + table[j, i1] * fx
    high = table[j1, i] * (1.0 - fx) + table[j1, i1] * fx
    return matrix_of(low * (1.0 - fy) + high * fy)


def matrix_of(entries: ArrayLike) -> F8:
    """Return M^-1 f8[...,3,3] of the table's four entries [...,4]."""
    e = np.asarray(entries, np.float64)
    out = np.zeros((*e.shape[:-1], 3, 3))
    out[..., 0, 0], out[..., 0, 2], out[..., 2, 0], out[..., 2, 2] = np.moveaxis(e, -1, 0)
    out[..., 1, 1] = 1.0
    return out


def density(inverse: ArrayLike, w: ArrayLike) -> F8:
    """Return the transformed cosine's density [...] over unit directions `w` [...,3] for M^-1 [...,3,3] (eq. 3)."""
    inverse = np.asarray(inverse, np.float64)
    back = np.einsum("...ij,...j->...i", inverse, np.asarray(w, np.float64))
    length = np.linalg.norm(back, axis=-1)
    result: F8 = np.maximum(back[..., 2], 0.0) / np.pi * np.abs(np.linalg.det(inverse)) / length**4
    return result


def form_factor(polygon: ArrayLike, inverse: ArrayLike | None = None) -> F8:
    """Return the cosine-weighted solid angle over pi [...] of a convex `polygon` [...,k,3] about the origin, its part
    above z = 0, clockwise as seen from the origin; after `inverse` [...,3,3] if given.

    Lambert's formula (eq. 11 with Baum et al. 1989, "Improving Radiosity Solutions Through the Use of Analytically
    Determined Form-Factors"); the horizon closes what is cut by it.
    """
    points = np.asarray(polygon, np.float64)
    if inverse is not None:
        points = np.einsum("...ij,...kj->...ki", np.asarray(inverse, np.float64), points)
    after = np.roll(points, -1, axis=-2)
    z, z_after = points[..., 2], after[..., 2]
    crosses = (z > 0.0) != (z_after > 0.0)
    share = np.where(crosses, z / np.where(crosses, z - z_after, 1.0), 0.0)[..., None]
    cut = points + share * (after - points)
    first = np.where((z > 0.0)[..., None], points, cut)
    second = np.where((z_after > 0.0)[..., None], after, cut)
    seen = (z > 0.0) | (z_after > 0.0)
    total = np.where(seen, _edge(first, second), 0.0).sum(axis=-1)
    leaves = (z > 0.0) & (z_after <= 0.0)
    enters = (z <= 0.0) & (z_after > 0.0)
    exit_point = np.where(leaves[..., None], cut, 0.0).sum(axis=-2)
    entry = np.where(enters[..., None], cut, 0.0).sum(axis=-2)
    closing = np.where(leaves.any(axis=-1), _edge(exit_point, entry), 0.0)
    result: F8 = (total + closing) / (2.0 * np.pi)
    return result


def _edge(a: F8, b: F8) -> F8:
    """The z of the angle between `a` and `b` times the normal of their plane."""
    a = a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-300)
    b = b / np.maximum(np.linalg.norm(b, axis=-1, keepdims=True), 1e-300)
    across = np.cross(a, b)
    sine = np.linalg.norm(across, axis=-1)
    angle = np.arctan2(sine, (a * b).sum(axis=-1))
    result: F8 = np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 1.0) * across[..., 2]
    return result


class _Lobe:
    """GGX for n roughnesses at one view angle, and how far a transformed cosine is from it."""

    def __init__(self, alpha: F8, cosine: float) -> None:
        self.alpha = alpha[:, None]
        self.v = np.array([np.sqrt(max(1.0 - cosine * cosine, 0.0)), 0.0, cosine])
        u = (np.stack(np.meshgrid(*[(np.arange(_SAMPLES) + 0.5) / _SAMPLES] * 2, indexing="ij"), -1)).reshape(-1, 2)
        half = ggx.sample_visible_half(u[None], np.broadcast_to(self.v, (1, len(u), 3)), self.alpha)
        self.l = 2.0 * (half @ self.v)[..., None] * half - self.v
        self.f, self.pdf = self._evaluate(self.l, self.alpha)
        weight = np.where(self.pdf > 0.0, self.f / np.where(self.pdf > 0.0, self.pdf, 1.0), 0.0)
        self.albedo = weight.mean(axis=1)
        mean = (self.l * weight[..., None]).mean(axis=1)
        mean[:, 1] = 0.0
        z = mean / np.linalg.norm(mean, axis=1, keepdims=True)
        zero = np.zeros(len(alpha))
        # as columns: x and z in the plane of incidence, y across it
        self.frame = np.stack(
            [np.stack([z[:, 2], zero, -z[:, 0]], 1), np.stack([zero, zero + 1.0, zero], 1), z], axis=2
        )
        radius, angle = np.sqrt(u[:, 0]), 2.0 * np.pi * u[:, 1]
        self.cosine = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1.0 - u[:, 0])], axis=1)
        self.upright = cosine > 0.9999  # seen from above the lobe is round

    def _evaluate(self, l: F8, alpha: F8) -> tuple[F8, F8]:
        """BRDF times cosine without Fresnel, and the density of visible-normal sampling."""
        half = l + self.v
        half = half / np.maximum(np.linalg.norm(half, axis=-1, keepdims=True), 1e-30)
        nl, nv = l[..., 2], self.v[2]
        d = ggx.D_GGX(half[..., 2], alpha)
        f = np.where(nl > 0.0, d * ggx.V_SmithGGXCorrelated(nv, nl, alpha) * nl, 0.0)
        pdf = d * ggx.G1_Smith(nv, alpha) / (4.0 * nv)
        return f, pdf

    def matrix(self, x: F8, rows: NDArray[np.int64] | slice = slice(None)) -> F8:
        """M [k,3,3] of the fitted numbers [k,4] of those rows: sizes along and across, skew, turn from the mean light.

        The paper keeps the axis on the mean direction; free, it takes a fifth of their error at half the roughness, and
        1 % of the lobe instead of 5 to 12 % sinks below the horizon.
        """
        local = np.zeros((len(x), 3, 3))
        along = np.maximum(np.abs(x[:, 0]), 1e-7)
        local[:, 0, 0] = along
        local[:, 1, 1] = along if self.upright else np.maximum(np.abs(x[:, 1]), 1e-7)
        local[:, 0, 2] = 0.0 if self.upright else x[:, 2]
        local[:, 2, 2] = 1.0
        turn = 0.0 if self.upright else x[:, 3]
        c, s = np.cos(turn), np.sin(turn)
        turned = np.zeros_like(local)
        turned[:, 0, 0] = turned[:, 2, 2] = c
        turned[:, 0, 2], turned[:, 2, 0] = s, -s
        turned[:, 1, 1] = 1.0
        result: F8 = self.frame[rows] @ turned @ local
        return result

    def error(self, x: F8, rows: NDArray[np.int64]) -> F8:
        """[k]: the integral of the squared difference, sampled by both densities.

        Heitz et al. 2016, section 4, take the third power; the square leaves less error over lights of all sizes.
        """
        matrix = self.matrix(x, rows)
        inverse = np.linalg.inv(matrix)
        determinant = np.abs(np.linalg.det(inverse))[:, None]
        albedo = self.albedo[rows, None]
        there = self.cosine @ matrix.transpose(0, 2, 1)
        there /= np.linalg.norm(there, axis=-1, keepdims=True)
        f_there, pdf_there = self._evaluate(there, self.alpha[rows])
        total = np.zeros(len(x))
        for l, f, pdf in ((self.l[rows], self.f[rows], self.pdf[rows]), (there, f_there, pdf_there)):
            back = l @ inverse.transpose(0, 2, 1)
            ltc = np.maximum(back[..., 2], 0.0) / np.pi * determinant / (back * back).sum(-1) ** 2
            total += (np.abs(f - albedo * ltc) ** 2 / np.maximum(pdf + ltc, 1e-30)).mean(axis=1)
        return total


def _nelder_mead(error: Callable[[F8, NDArray[np.int64]], F8], start: F8) -> F8:
    """Return the points [n,k] where `error(points, problems)` is least, for n problems side by side.

    Nelder and Mead 1965, "A Simplex Method for Function Minimization".
    """
    count, size = start.shape
    everyone = np.arange(count)
    simplex = np.repeat(start[:, None], size + 1, axis=1)
    step = 0.1 * np.maximum(np.abs(start), 0.1)
    for corner in range(size):
        simplex[:, corner + 1, corner] += step[:, corner]
    values = np.stack([error(simplex[:, k], everyone) for k in range(size + 1)], axis=1)
    for _ in range(_STEPS):
        order = np.argsort(values, axis=1)
        values = np.take_along_axis(values, order, axis=1)
        simplex = np.take_along_axis(simplex, order[..., None], axis=1)
        rows = np.flatnonzero(values[:, -1] - values[:, 0] > _DONE * values[:, 0])
        if len(rows) == 0:
            break
        simplex[rows], values[rows] = _nelder_mead_step(error, rows, simplex[rows], values[rows])
    result: F8 = simplex[everyone, np.argmin(values, axis=1)]
    return result


def _nelder_mead_step(
    error: Callable[[F8, NDArray[np.int64]], F8], rows: NDArray[np.int64], simplex: F8, values: F8
) -> tuple[F8, F8]:
    """One step of those problems; corners sorted, the best first."""
    center, worst = simplex[:, :-1].mean(axis=1), simplex[:, -1]
    mirrored = 2.0 * center - worst
    at_mirrored = error(mirrored, rows)
    best, contract = at_mirrored < values[:, 0], at_mirrored >= values[:, -2]
    outside = (at_mirrored < values[:, -1])[:, None]
    second = np.where(best[:, None], 3.0 * center - 2.0 * worst, mirrored)
    inward = np.where(outside, 0.5 * (center + mirrored), 0.5 * (center + worst))
    second = np.where(contract[:, None], inward, second)
    at_second = at_mirrored.copy()
    asked = np.flatnonzero(best | contract)
    at_second[asked] = error(second[asked], rows[asked])
    use_second = at_second < np.where(contract, np.minimum(at_mirrored, values[:, -1]), at_mirrored)
    simplex[:, -1] = np.where(use_second[:, None], second, np.where(contract[:, None], worst, mirrored))
    values[:, -1] = np.where(use_second, at_second, np.where(contract, values[:, -1], at_mirrored))
    shrink = np.flatnonzero(contract & ~use_second)
    if len(shrink):
        simplex[shrink, 1:] = 0.5 * (simplex[shrink, 1:] + simplex[shrink, :1])
        for corner in range(1, simplex.shape[1]):
            values[shrink, corner] = error(simplex[shrink, corner], rows[shrink])
    return simplex, values
