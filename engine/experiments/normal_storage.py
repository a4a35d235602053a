"""Unit normals in few bits: octahedral by bits, and the three signed components that meshes store."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.report.metrics import max_angle, mean_angle
from engine.report.records import Extreme

F8 = NDArray[np.float64]
Words = NDArray[np.uint32]

#: octahedral decoding, Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors"
FUNCTIONS = """
const float SCALE = float((1u << (BITS - 1)) - 1u);
float component(uint bits) { return max(float(int(bits << (32 - BITS)) >> (32 - BITS)) / SCALE, -1.0); }
vec3 octahedral(uvec2 w) {
    vec2 e = vec2(component(w.x), component(w.y));
    vec3 v = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float t = max(-v.z, 0.0);
    v.xy += vec2(v.x >= 0.0 ? -t : t, v.y >= 0.0 ? -t : t);
    return normalize(v);
}
vec3 three(uvec2 w) {
#if BITS == 16
    return normalize(vec3(unpackSnorm2x16(w.x), unpackSnorm2x16(w.y).x));
#else
    return normalize(vec3(component(w.x), component(w.x >> BITS), component(w.y)));
#endif
}
vec3 rebuilt_z(uvec2 w) {
    vec2 e = vec2(component(w.x), component(w.y));
    return vec3(e, sqrt(max(1.0 - dot(e, e), 0.0)));
}
"""


def _snorm(v: F8, bits: int) -> NDArray[np.int64]:
    return np.rint(np.clip(v, -1.0, 1.0) * ((1 << (bits - 1)) - 1)).astype(np.int64)


def _field(v: NDArray[np.int64], bits: int) -> Words:
    return (v & ((1 << bits) - 1)).astype(np.uint32)


def encode_octahedral(n: F8, bits: int) -> Words:
    """u4[n,2]: the octahedron's unfolded square, each coordinate as snorm of `bits`, rounded to nearest."""
    p = n / np.abs(n).sum(axis=1, keepdims=True)
    sign = np.where(p[:, :2] >= 0.0, 1.0, -1.0)
    folded = np.where(p[:, 2:] < 0.0, (1.0 - np.abs(p[:, 1::-1])) * sign, p[:, :2])
    return _field(_snorm(folded, bits), bits)


def encode_three(n: F8, bits: int) -> Words:
    """u4[n,2] with x and y in the first word: as a mesh's snorm16x4 normal."""
    f = _field(_snorm(n, bits), bits)
    return np.stack([f[:, 0] | (f[:, 1] << np.uint32(bits)), f[:, 2]], axis=1)


def encode_two(n: F8, bits: int) -> Words:
    """u4[n,2]: x and y; z is rebuilt as a positive root (tangent-space maps)."""
    return _field(_snorm(n[:, :2], bits), bits)


KINDS: dict[str, tuple[str, Callable[[F8, int], Words], int]] = {
    "xyz": ("three(w)", encode_three, 3),
    "octahedral": ("octahedral(w)", encode_octahedral, 2),
    "xy + root": ("rebuilt_z(w)", encode_two, 2),
}


def directions(ctx: Context, kind: str) -> F8:
    n = ctx.rng("normals").normal(size=(1 << (17 if ctx.quick else 19), 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    if kind == "xy + root":
        n[:, 2] = np.abs(n[:, 2])
    return n


def run(ctx: Context, knobs: Knobs) -> Trial:
    expression, encode, components = KINDS[knobs["kind"]]
    bits = int(knobs["bits"])
    n = directions(ctx, knobs["kind"])
    kernel = ctx.shaders().kernel(expression, {"w": "uvec2"}, "vec3", functions=FUNCTIONS, defines={"BITS": bits})
    dispatch = kernel.bind(w=encode(n, bits))

    def judge(_: Any) -> Outcome:
        got = dispatch.read()
        return Outcome(
            {"max_angle": math.degrees(max_angle(got, n)), "mean_angle": math.degrees(mean_angle(got, n))},
            extra={"bytes": {"xyz": 8 if bits == 16 else 4}.get(knobs["kind"], math.ceil(components * bits / 8))},
        )

    return Trial(dispatch.run, judge, gpu=True, close=dispatch.release)


def extremes(ctx: Context) -> Iterator[Extreme]:
    axes = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], np.float64)
    for kind in ("xyz", "octahedral"):
        expression, encode, _ = KINDS[kind]
        kernel = ctx.shaders().kernel(expression, {"w": "uvec2"}, "vec3", functions=FUNCTIONS, defines={"BITS": 16})
        error = max_angle(kernel(w=encode(axes, 16)), axes)
        yield Extreme(f"{kind}, 16 bits: the six axes", f"{math.degrees(error):.2g}° off", error < 1e-6)


EXPERIMENT = Experiment(
    title="Storing unit normals",
    method="octahedral, three components, or two with a rebuilt root, as snorm of so many bits; decoded on the device",
    truth="the float64 direction before encoding",
    metric="max_angle",
    unit="degrees",
    knobs=[{"kind": k, "bits": b} for k in KINDS for b in ((8, 10, 12, 16) if k != "xyz" else (8, 16))],
    default={"kind": "xyz", "bits": 16},
    curve="kind",
    run=run,
    orders=[
        Order(1.0, "rounding of a coordinate", "2^-bits", step=lambda k: 2.0 ** -k["bits"]),
        Order(1.0, "rounding of a coordinate", "2^-bits", step=lambda k: 2.0 ** -k["bits"], curve="octahedral"),
        Order(
            0.5,
            "the root's slope is infinite at the rim",
            "2^-bits",
            step=lambda k: 2.0 ** -k["bits"],
            curve="xy + root",
        ),
    ],
    also=("bytes",),
    needs=frozenset({"gpu"}),
    timed="gpu",
    extremes=extremes,
    step_label="2^-bits of a component",
    note="Meshes store xyz as snorm16 (8 bytes with padding); octahedral 16 takes 4 bytes for 2.5 times the error. Time"
    " is decoding alone; the bytes saved are the other half of that choice and stand in the table.",
)
