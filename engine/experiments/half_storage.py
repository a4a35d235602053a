"""Storing colours in few bits: what comes back of float32 values from each texture format, as this device rounds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.gpu.types import Bindings, ComputePipelineDesc, SamplerDesc, ShaderSource, TextureDesc
from engine.report.records import Extreme, Floor

F8 = NDArray[np.float64]

#: format -> (GLSL image format, bits of the fraction that all channels keep, bytes of a texel)
FORMATS = {
    "rgba32f": ("rgba32f", 23, 16),
    "rgba16f": ("rgba16f", 10, 8),
    "rg11b10f": ("r11f_g11f_b10f", 5, 4),
}
SIZE = 256
MAGNITUDES = 10.0 ** np.arange(-8.0, 5.0)

SHADER = """
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 0) readonly buffer In { vec4 given[]; };
layout(GLSL_FORMAT, binding = 0) writeonly uniform image2D stored;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    imageStore(stored, p, given[p.y * SIZE + p.x]);
}
"""
BACK = """
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 0) writeonly buffer Out { vec4 found[]; };
layout(binding = 0) uniform sampler2D stored;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    found[p.y * SIZE + p.x] = texelFetch(stored, p, 0);
}
"""


class Store:
    """Writes an array to a texture by imageStore, and reads it back by texelFetch."""

    def __init__(self, ctx: Context, name: str, values: NDArray[np.float32]) -> None:
        assert ctx.device is not None, "needs gpu"
        self.device = ctx.device
        self.texture = self.device.texture(TextureDesc(name, SIZE, SIZE, label=name))
        text = SHADER.replace("GLSL_FORMAT", FORMATS[name][0]).replace("SIZE", str(SIZE))
        self.write = self.device.compute_pipeline(ComputePipelineDesc("store", ShaderSource("compute", text)))
        back = BACK.replace("SIZE", str(SIZE))
        self.fetch = self.device.compute_pipeline(ComputePipelineDesc("fetch", ShaderSource("compute", back)))
        self.given = self.device.buffer(values, label="given")
        self.found = self.device.buffer(SIZE * SIZE * 16, label="found")

    def run(self) -> None:
        sampler = self.device.sampler(SamplerDesc("clamp", "clamp", "clamp", "nearest", "nearest"))
        with self.device.compute_pass("store and fetch") as encoder:
            encoder.set_pipeline(self.write)
            encoder.set_bindings(Bindings(storage={0: self.given}, images={0: (self.texture, 0, "write")}))
            encoder.dispatch(SIZE // 8, SIZE // 8)
            encoder.set_pipeline(self.fetch)
            encoder.set_bindings(Bindings(storage={0: self.found}, textures={0: (self.texture, sampler)}))
            encoder.dispatch(SIZE // 8, SIZE // 8)

    def read(self) -> F8:
        return np.frombuffer(self.found.read(), np.float32).reshape(-1, 4).astype(np.float64)

    def release(self) -> None:
        for resource in (self.texture, self.write, self.fetch, self.given, self.found):
            resource.release()


def values(ctx: Context) -> NDArray[np.float32]:
    """f4[SIZE*SIZE,4]: each magnitude in turn, mantissas at random."""
    rng = ctx.rng("values")
    magnitude = np.resize(MAGNITUDES, SIZE * SIZE)
    return (magnitude[:, None] * rng.uniform(1.0, 6.5, (SIZE * SIZE, 4))).astype(np.float32)


def run(ctx: Context, knobs: Knobs) -> Trial:
    given = ctx.once("values", lambda: values(ctx))
    name = str(knobs["format"])
    store = Store(ctx, name, given)

    def judge(_: Any) -> Outcome:
        got = store.read()[:, :3]
        want = given[:, :3].astype(np.float64)
        relative = np.abs(got - want) / want
        rows = [float(relative[i :: len(MAGNITUDES)].max()) for i in range(len(MAGNITUDES))]
        # the range that all float formats share without subnormals
        normal = (want > 1e-4) & (want < 6e4)
        ulp = 2.0 ** -FORMATS[name][1]
        return Outcome(
            {"max_relative": float(relative[normal].max()), "mean_relative": float(relative[normal].mean())},
            profile=list(zip(MAGNITUDES, rows, strict=True)),
            extra={"bytes": FORMATS[name][2], "signed mean, ulp": float(((got - want) / want)[normal].mean() / ulp)},
        )

    return Trial(store.run, judge, gpu=True, close=store.release)


def extremes(ctx: Context) -> Iterator[Extreme]:
    given = np.zeros((SIZE * SIZE, 4), np.float32)
    given[0] = (7e4, 65504.0, 1e-8, -1.0)
    store = Store(ctx, "rgba16f", given)
    try:
        store.run()
        got = store.read()[0]
    finally:
        store.release()
    ok = bool(got[0] in (65504.0, np.inf) and got[1] == 65504.0 and abs(got[2]) < 1e-7 and got[3] == -1.0)
    yield Extreme("rgba16f: 70000, 65504, 1e-8, -1", ", ".join(f"{v:g}" for v in got), ok)


def _step(knobs: Knobs) -> float:
    return float(2.0 ** -FORMATS[knobs["format"]][1])


EXPERIMENT = Experiment(
    title="Storing colours as half floats",
    method="imageStore and texelFetch of rgba32f, rgba16f, rg11b10f, as the device rounds",
    truth="the float32 values before storing",
    metric="max_relative",
    unit="relative",
    knobs=[{"format": name, "family": "float"} for name in FORMATS],
    default={"format": "rgba16f", "family": "float"},
    curve="family",
    run=run,
    orders=[
        Order(1.0, "an ulp or half of one: 2^-bits of the fraction", "2^-bits", step=_step, tolerance=0.3),
    ],
    also=("bytes",),
    needs=frozenset({"gpu"}),
    timed="gpu",
    extremes=extremes,
    step_label="2^-bits of the fraction",
    profile_label="magnitude",
    format_floor=Floor(2.0**-11, "half float, rounded to nearest"),
    note="Up to 2^-11 is rounding to nearest, up to 2^-10 is truncation, which the standard allows: the signed mean"
    " tells which. Below 6e-5 half floats lose digits as they become subnormal.",
)
