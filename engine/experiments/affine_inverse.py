"""Inverting transforms: LU, adjugate, and what the parts of a TRS give, as the scales get uneven."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.math import quat
from engine.math.transform import compose, inverse_affine
from engine.report.records import Extreme

F8 = NDArray[np.float64]
Array = NDArray[Any]

#: largest stretch over smallest, of the linear part
CONDITIONS = 10.0 ** np.arange(0.0, 9.0)
#: of each condition's matrices, how many have a scale of zero
FLAT = 8


def lu(m: Array) -> Array:
    """LAPACK's general inverse; it gives up on the whole batch if one matrix is singular, so those are put aside."""
    singular = np.linalg.det(m[..., :3, :3]) == 0.0
    result: Array = np.linalg.inv(np.where(singular[:, None, None], np.eye(4, dtype=m.dtype), m))
    result[singular] = np.nan
    return result


def adjugate(m: Array) -> Array:
    """Cofactors over determinant, in the type that is given."""
    a, b, c = m[..., 0, :3], m[..., 1, :3], m[..., 2, :3]
    bc, ca, ab = np.cross(b, c), np.cross(c, a), np.cross(a, b)
    determinant = np.einsum("ni,ni->n", a, bc)
    out = np.zeros_like(m)
    out[..., :3, :3] = np.stack([bc, ca, ab], axis=-1) / determinant[:, None, None]
    out[..., :3, 3] = -np.einsum("nij,nj->ni", out[..., :3, :3], m[..., :3, 3])
    out[..., 3, 3] = 1.0
    return out


def rigid(m: Array) -> Array:
    """Transpose of the rotation with each column over its squared length: right without shear."""
    linear = m[..., :3, :3]
    square = np.einsum("nij,nij->nj", linear, linear)
    out = np.zeros_like(m)
    out[..., :3, :3] = np.swapaxes(linear / square[:, None, :], -1, -2)
    out[..., :3, 3] = -np.einsum("nij,nj->ni", out[..., :3, :3], m[..., :3, 3])
    out[..., 3, 3] = 1.0
    return out


FORMS: dict[str, Callable[[Array], Array]] = {
    "engine": inverse_affine,
    "LU": lu,
    "adjugate": adjugate,
    "columns": rigid,
}


def inputs(ctx: Context) -> tuple[F8, F8, NDArray[np.bool_]]:
    """Matrices [n,4,4] by condition, their inverses from the parts in float64, and which ones are flat.

    The linear part is rotation, scale, rotation: what a node turned inside an unevenly scaled parent has, with shear.
    """
    rng = ctx.rng("matrices")
    count = 1 << (9 if ctx.quick else 12)
    n = count * len(CONDITIONS)
    condition = np.repeat(CONDITIONS, count)
    scale = np.stack([np.ones(n), condition**-0.5, 1.0 / condition], axis=1)
    flat = np.arange(n) % count < FLAT
    scale[flat, 1] = 0.0
    outer, inner = (quat.to_matrix3(quat.normalize(rng.normal(size=(n, 4)))) for _ in range(2))
    inner[flat] = np.eye(3)  # or rounding would make it merely nearly flat
    t = rng.uniform(-1.0, 1.0, (n, 3))
    given, exact = np.zeros((2, n, 4, 4))
    given[:, :3, :3] = outer @ (scale[:, :, None] * inner)
    given[:, :3, 3] = t
    with np.errstate(divide="ignore"):
        back = np.where(scale > 0.0, 1.0 / scale, 0.0)
    exact[:, :3, :3] = np.swapaxes(inner, -1, -2) @ (back[:, :, None] * np.swapaxes(outer, -1, -2))
    exact[:, :3, 3] = -np.einsum("nij,nj->ni", exact[:, :3, :3], t)
    given[:, 3, 3] = exact[:, 3, 3] = 1.0
    return given, exact, flat


def run(ctx: Context, knobs: Knobs) -> Trial:
    given, exact, flat = ctx.once("inputs", lambda: inputs(ctx))
    m = given.astype(np.float32 if knobs["digits"] == 32 else np.float64)
    form = FORMS[knobs["form"]]

    def work() -> Array:
        with np.errstate(all="ignore"):
            return form(m)

    def judge(got: Array) -> Outcome:
        # relative to the size of the inverse, so that conditions can be compared
        size = np.linalg.norm(exact[:, :3, :3], axis=(1, 2))
        finite = np.asarray(np.isfinite(got).all(axis=(1, 2)))
        off = np.where(finite[:, None, None], got.astype(np.float64) - exact, np.inf)
        error = np.linalg.norm(off[:, :3, :3], axis=(1, 2)) / size
        within = np.repeat(CONDITIONS, len(error) // len(CONDITIONS)) <= 1e4
        worst = np.where(flat, 0.0, error).reshape(len(CONDITIONS), -1).max(axis=1)
        return Outcome(
            {"max_relative": float(error[within].max()), "without_flat": float(error[within & ~flat].max())},
            profile=list(zip(CONDITIONS, worst, strict=True)),
            extra={"not finite": int((~np.isfinite(error)).sum())},
        )

    return Trial(work, judge)


def extremes(ctx: Context) -> Iterator[Extreme]:
    small = compose([[1.0, 2.0, 3.0]], [[0.0, 0.0, 0.0, 1.0]], [[1e-4, 1e-4, 1e-4]])
    off = float(np.abs(inverse_affine(small)[0] @ small[0] - np.eye(4)).max())
    yield Extreme("scale 1e-4 (determinant 1e-12)", f"{off:.1g} off the identity", off < 1e-12)
    flat = compose([[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0, 1.0]], [[1.0, 1.0, 0.0]])
    got = inverse_affine(flat)
    yield Extreme("scale (1, 1, 0)", "finite" if np.isfinite(got).all() else "not finite", bool(np.isfinite(got).all()))


EXPERIMENT = Experiment(
    title="Inverting transforms",
    method="engine.math.transform.inverse_affine (scaled adjugate), LU of LAPACK, plain adjugate, scaled columns",
    truth="the inverse put together from the factors in float64; across a zero scale the pseudo-inverse",
    metric="max_relative",
    unit="relative, condition up to 10⁴",
    knobs=[{"form": f, "digits": d} for f in FORMS for d in (32, 64)],
    default={"form": "engine", "digits": 64},
    curve="form",
    run=run,
    orders=[
        Order(
            1.5,
            "cofactors cancel: more than the condition number asks for",
            "condition",
            between=(10.0, 1e6),
            tolerance=0.3,
        ),
        Order(
            1.0,
            "rounding times the condition number",
            "condition",
            point={"form": "LU", "digits": 64},
            between=(10.0, 1e6),
            tolerance=0.3,
        ),
    ],
    extremes=extremes,
    profile_label="condition number (largest scale / smallest)",
    note="One matrix in a few hundred has a scale of zero, as animations that hide things make: a plain adjugate or LU"
    " gives no number there, the engine's form the pseudo-inverse; “without flat” compares them where all can. Scaled"
    " columns are right only without shear, which uneven parents make.",
)
