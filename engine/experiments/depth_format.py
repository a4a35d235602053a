"""Depth buffers: what is lost of the distance, by format and mapping, from a millimetre to a thousand kilometres."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.report.records import Extreme

F8 = NDArray[np.float64]

NEAR, FAR = 1e-3, 1e6
DISTANCES = 10.0 ** np.arange(-2.5, 6.0, 0.5)
MAPPINGS = {
    "reversed, infinite": "near / z",
    "reversed": "near * (far - z) / (z * (far - near))",
    "forward": "far * (z - near) / (z * (far - near))",
    "logarithmic": "log2(z / near) / log2(far / near)",
}
#: bits of a fixed-point format; 0 is float32
FORMATS = {"float32": 0, "unorm24": 24, "unorm16": 16}
DEFAULT = {"mapping": "reversed, infinite", "format": "float32"}


def quantise(depth: F8, name: str) -> F8:
    """`depth` (as the shader computed it, float32) as the format keeps it."""
    bits = FORMATS[name]
    if bits == 0:
        return depth.astype(np.float32).astype(np.float64)
    steps = float((1 << bits) - 1)
    return np.rint(np.clip(depth, 0.0, 1.0) * steps) / steps


def distance(depth: F8, mapping: str) -> F8:
    """Distances of depths, the mapping turned round in float64."""
    with np.errstate(divide="ignore"):
        if mapping == "reversed, infinite":
            return NEAR / depth
        if mapping == "logarithmic":
            result: F8 = NEAR * (FAR / NEAR) ** depth
            return result
        if mapping == "reversed":
            return NEAR * FAR / (depth * (FAR - NEAR) + NEAR)
        return NEAR * FAR / (FAR - depth * (FAR - NEAR))


def run(ctx: Context, knobs: Knobs) -> Trial:
    mapping, name = str(knobs["mapping"]), str(knobs["format"])
    count = 1 << (14 if ctx.quick else 16)
    z = ctx.once(
        "z",
        lambda: (np.repeat(DISTANCES, count) * ctx.rng("z").uniform(1.0, 2.0, count * len(DISTANCES))).astype(
            np.float32
        ),
    )
    kernel = ctx.shaders().kernel(
        MAPPINGS[mapping], {"z": "float"}, "float", defines={"near": f"{NEAR:.9f}", "far": f"{FAR:.1f}"}
    )
    dispatch = kernel.bind(z=z)

    def judge(_: object) -> Outcome:
        kept = quantise(dispatch.read(), name)
        true = z.astype(np.float64)
        error = np.abs(distance(kept, mapping) - true) / true
        # what lies at infinity cannot be told from anything: as bad as the whole distance
        rows = np.where(np.isfinite(error), error, 1e3).reshape(len(DISTANCES), -1).max(axis=1)
        return Outcome(
            {"max_relative": float(rows.max()), "at_100_m": float(rows[int(np.argmin(np.abs(DISTANCES - 100.0)))])},
            profile=list(zip(DISTANCES, np.maximum(rows, 1e-12), strict=True)),
            extra={"bytes": {0: 4, 24: 4, 16: 2}[FORMATS[name]]},
        )

    return Trial(dispatch.run, judge, gpu=True, close=dispatch.release)


def extremes(ctx: Context) -> Iterator[Extreme]:
    for far in (1.0, 1e2, 1e4, 1e5):
        z = np.array([far, far * (1.0 + 1e-6)], np.float32)
        depth = (np.float32(NEAR) / z).astype(np.float32)
        apart = bool(depth[0] > depth[1]) if z[1] > z[0] else True
        yield Extreme(f"two planes a millionth apart at {far:g} m", f"{depth[0]:.9g} and {depth[1]:.9g}", apart)


EXPERIMENT = Experiment(
    title="Depth formats over near and far",
    method="depth of a distance, computed in float32 on the device, kept as float32, unorm24 or unorm16; near 1 mm, far"
    " 1000 km",
    truth="the distance itself",
    metric="max_relative",
    unit="of the distance",
    knobs=[{"mapping": m, "format": f} for m in MAPPINGS for f in FORMATS],
    default=DEFAULT,
    curve="mapping",
    run=run,
    orders=[
        Order(0.0, "reversed float: a constant part of the distance", "distance", tolerance=0.1),
        Order(
            1.0,
            "forward: a fixed step in depth, which stands for ever more distance",
            "distance",
            point={"mapping": "forward", "format": "unorm24"},
            between=(0.01, 1e3),
            tolerance=0.2,
        ),
    ],
    needs=frozenset({"gpu"}),
    timed="gpu",
    extremes=extremes,
    profile_label="distance (m)",
    note="A relative error of 1 means that the distance is lost altogether. Time is that of computing the depth; the"
    " logarithmic mapping besides costs early depth tests, since the fragment shader writes it.",
)
