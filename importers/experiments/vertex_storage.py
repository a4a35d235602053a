"""Storing vertex positions in fewer bytes: float32, halves, and steps of the mesh's own box (`--quantize`)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from engine.assets import quantized
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.report.records import Extreme

F8 = NDArray[np.float64]

#: where the mesh lies: its box is 1 m in x, 2 m in y, 0.5 m in z
PLACES = {"at the origin": 0.0, "100 m away": 100.0}
#: (form, bits of a component) -> bytes of a position
FORMS = {
    ("float", 32): 12, ("float", 16): 6, ("box", 21): 8, ("box", 16): 6, ("box", 12): 5, ("box", 10): 4,
}  # fmt: skip
COUNT = 1 << 16


def points(ctx: Context, place: str) -> F8:
    rng = ctx.rng("positions")
    count = COUNT >> (3 if ctx.quick else 0)
    return np.asarray(rng.uniform(size=(count, 3)) * [1.0, 2.0, 0.5] + PLACES[place])


def steps(values: F8, bits: int) -> Callable[[], F8]:
    """Decoding from whole steps of the box, as a shader or the reader of a file does it."""
    if bits == 16:
        stored, box = quantized.encode(values)
        return lambda: quantized.decode(stored, box).astype(np.float64)
    low, high = values.min(axis=0), values.max(axis=0)
    step = (high - low) / (2**bits - 1)
    whole = np.rint((values - low) / step).astype(np.uint32)
    return lambda: np.asarray((low + whole * step).astype(np.float32), np.float64)


def run(ctx: Context, knobs: Knobs) -> Trial:
    values: F8 = ctx.once(f"points {knobs['place']}", lambda: points(ctx, str(knobs["place"])))
    form, bits = str(knobs["form"]), int(knobs["bits"])
    size = FORMS[form, bits]
    if form == "box":
        work = steps(values, bits)
    else:
        kind = np.float16 if bits == 16 else np.float32
        with np.errstate(over="ignore"):
            stored = values.astype(kind)
        work = lambda: stored.astype(np.float64)  # noqa: E731  (beside the other one)

    def judge(got: F8) -> Outcome:
        off = 1000.0 * np.linalg.norm(got - values, axis=1)
        return Outcome(
            {"max_mm": float(off.max()), "rms_mm": float(np.sqrt(np.mean(off**2)))}, extra={"bytes per position": size}
        )

    return Trial(work, judge)


def extremes(ctx: Context) -> list[Extreme]:
    """A flat mesh has no step in one axis, one point none at all: both come back exactly."""
    flat = np.array([[0.0, 1.0, 7.25], [3.0, 2.0, 7.25]], np.float32)
    error = quantized.error(flat)
    single = quantized.error(np.array([[1.5, -2.5, 1e6]], np.float32))
    return [
        Extreme("a flat box", f"off by {error:.3g} m", error <= 3.0 / 65535),
        Extreme("one point", f"off by {single:.3g} m", single == 0.0),
    ]


EXPERIMENT = Experiment(
    title="Vertex positions in fewer bytes",
    method="positions stored as float32, float16, or whole steps of the mesh's box, and read back",
    truth="the float64 positions",
    metric="max_mm",
    unit="mm",
    knobs=[{"place": place, "form": form, "bits": bits} for place in PLACES for form, bits in FORMS],
    default={"place": "at the origin", "form": "float", "bits": 32},
    run=run,
    curve="form",
    problem="place",
    also=("bytes per position",),
    orders=[
        # beyond 16 bits float32, which it is read into, rounds more coarsely
        Order(
            1.0, "half a step of the box", "1 / steps", step=lambda knobs: 2.0 ** -int(knobs["bits"]), curve="box",
            between=(2.0**-16.5, 1.0),
        )
    ],
    extremes=extremes,
    time_label="median time to read back",
    note="The box's steps do not care where the mesh lies; halves do: 100 m away they are 62 mm apart.",
)  # fmt: skip
