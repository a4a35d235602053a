"""The split-sum table: how large it must be, in which format, and the fitted polynomial that needs none."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.dds import read_dds
from engine.core.paths import shaders_dir
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.gpu.types import Bindings, ComputePipelineDesc, SamplerDesc, ShaderSource, TextureDesc
from engine.math import ggx
from engine.report.records import Extreme, Floor

F8 = NDArray[np.float64]

#: curve -> (format, whether the first and last texels lie at 0 and 1 instead of half a texel inside)
TABLES = {
    "centres, half": ("rg16f", False),
    "centres, float": ("rg32f", False),
    "ends, half": ("rg16f", True),
    "ends, float": ("rg32f", True),
}
TYPES = {"rg32f": np.float32, "rg16f": np.float16}
#: where the table is judged; nearer to grazing and to a mirror a surface shows no more than a few pixels
LOW = 0.1
LOOK_UPS = 1 << 17
#: the table in shaders/data
DEFAULT: dict[str, Any] = {"table": "ends, half", "size": 64}

SHADER = """
layout(local_size_x = 64) in;
layout(binding = 0) uniform sampler2D t_dfg;
layout(std430, binding = 0) readonly buffer In { vec2 places[]; };
layout(std430, binding = 1) writeonly buffer Out { vec2 found[]; };
// Lazarov 2013 / Karis 2014, "Physically Based Shading on Mobile": a fit instead of a table
vec2 fit(float nv, float roughness) {
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float a = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    return vec2(-1.04, 1.04) * a + r.zw;
}
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(found.length())) return;
    found[i] = LOOK_UP;
}
"""


def places(ctx: Context) -> F8:
    return ctx.rng("places").uniform(LOW, 1.0, size=(1024, 2))


def truth(ctx: Context) -> F8:
    at = places(ctx)
    found = ctx.references.get(
        "dfg-places", {"places": at, "order": 72},
        lambda: {"dfg": np.concatenate([ggx.dfg(p[:, 1], p[:, 0], 72) for p in np.array_split(at, 32)])},
        seed=ctx.seed,
    )  # fmt: skip
    return found["dfg"]


def table(ctx: Context, size: int, *, ends: bool, shipped: bool = False) -> F8:
    """f8[size,size,2]: rows are roughness, columns n.v, at texel centres, or from 0 to 1. `shipped`: the renderer's."""
    if shipped:
        asset = read_dds(shaders_dir() / "data" / "dfg_lut.dds")
        return np.frombuffer(asset.levels[0][0], "<f2").reshape(asset.height, asset.width, 2).astype(np.float64)
    at = np.maximum(np.linspace(0.0, 1.0, size), 1e-3) if ends else (np.arange(size) + 0.5) / size
    return ctx.references.get(
        "dfg-table", {"at": at, "order": 32}, lambda: {"dfg": np.stack([ggx.dfg(r, at, 32) for r in at])}
    )["dfg"]


def run(ctx: Context, knobs: Knobs) -> Trial:
    device = ctx.device
    assert device is not None, "needs gpu"
    name = str(knobs["table"])
    kind, ends = TABLES.get(name, ("rg32f", False))
    at = places(ctx)
    size = max(int(knobs["size"]), 1)
    if name == "fit":
        values, look_up = np.zeros((1, 1, 2)), "fit(places[i].x, places[i].y)"
    else:
        values = table(ctx, size, ends=ends, shipped=knobs == DEFAULT)
        place = f"places[i] * {(size - 1) / size:.9g} + {0.5 / size:.9g}" if ends else "places[i]"
        look_up = f"textureLod(t_dfg, {place}, 0.0).rg"
    texture = device.texture(TextureDesc(kind, size, size, label="dfg"))
    texture.write(np.ascontiguousarray(values.astype(TYPES[kind])))
    sampler = device.sampler(SamplerDesc("clamp", "clamp", "clamp", "linear", "linear"))
    pipeline = device.compute_pipeline(
        ComputePipelineDesc("dfg", ShaderSource("compute", SHADER.replace("LOOK_UP", look_up)))
    )
    given = device.buffer(np.resize(at, (LOOK_UPS, 2)).astype(np.float32), label="places")
    made = device.buffer(LOOK_UPS * 8, label="found")
    bindings = Bindings(storage={0: given, 1: made}, textures={0: (texture, sampler)})

    def work() -> None:
        with device.compute_pass("dfg") as encoder:
            encoder.set_pipeline(pipeline)
            encoder.set_bindings(bindings)
            encoder.dispatch(LOOK_UPS // 64)

    def judge(_: object) -> Outcome:
        got = np.frombuffer(made.read(0, len(at) * 8), np.float32).reshape(-1, 2).astype(np.float64)
        error = got - truth(ctx)
        return Outcome(
            {
                "rmse": float(np.sqrt(np.mean(error**2))),
                "max_error": float(np.abs(error).max()),
                "energy_deviation": float(np.abs(error.sum(axis=1)).max()),
            },
            extra={"bytes": 0 if name == "fit" else size * size * 2 * np.dtype(TYPES[kind]).itemsize},
        )

    def close() -> None:
        for resource in (texture, given, made, pipeline):
            resource.release()

    return Trial(work, judge, gpu=True, close=close)


def _step(knobs: Knobs) -> float:
    return 1.0 / max(float(knobs["size"]), 1.0)


def extremes(ctx: Context) -> Iterator[Extreme]:
    corners = table(ctx, DEFAULT["size"], ends=False, shipped=True)
    white = corners.sum(axis=-1)
    yield Extreme(
        "scale + bias, the white albedo, over the whole table",
        f"{white.min():.3f} to {white.max():.5f}",
        bool(np.isfinite(corners).all() and white.max() <= 1.0 + 1e-3 and white.min() > 0.0),
    )


def noise_floor(ctx: Context) -> Floor:
    at = places(ctx)[::64]
    fine, finest = ggx.dfg(at[:, 1], at[:, 0], 72), ggx.dfg(at[:, 1], at[:, 0], 108)
    return Floor(float(np.sqrt(np.mean((fine - finest) ** 2))), "truth: 72 against 108 nodes")


EXPERIMENT = Experiment(
    title="Size of the split-sum table",
    method="scale and bias of f0 from a table of n·v and roughness, bilinear, on the device; and a fit without a table",
    truth="Gauss-Legendre quadrature with 72 nodes each way at random places (n·v and roughness from 0.1), float64",
    metric="rmse",
    unit="of albedo",
    knobs=[{"table": t, "size": s} for t in TABLES for s in (8, 16, 32, 64, 128) if s < 128 or t.endswith("half")]
    + [{"table": "fit", "size": 0}],
    default=DEFAULT,
    curve="table",
    run=run,
    quick=lambda k: k["size"] <= 64 or k == DEFAULT,
    orders=[
        Order(
            1.5,
            "bilinear inside (h²), constant in the half texel at the rim (h on h of the area)",
            "1 / size",
            step=_step,
            curve="centres, half",
            tolerance=0.25,
            above=1.2e-4,
        ),
        Order(2.0, "bilinear everywhere: h²", "1 / size", step=_step, curve="ends, float", tolerance=0.3),
        Order(
            2.0,
            "bilinear everywhere, until half floats end it",
            "1 / size",
            step=_step,
            curve="ends, half",
            tolerance=0.4,
            above=2.4e-4,
        ),
    ],
    also=("bytes",),
    needs=frozenset({"gpu"}),
    timed="gpu",
    noise_floor=noise_floor,
    format_floor=Floor(1.2e-4, "half float rounding, rms near 0.5"),
    extremes=extremes,
    step_label="1 / size of the table",
    time_label=f"median time of {LOOK_UPS:,} look-ups",
    note="A look-up costs the same whatever the size, as long as the table stays in the cache: what a larger table"
    " costs are bytes and baking. The 64² one of half floats with its outer texels on the rim of the domain"
    " (“ends”) is the renderer's: half a texel inside, four times the bytes are not as good. The fit was made for a"
    " masking that is not height-correlated.",
)
