"""Points of a disc: how well the mean of a few lookups tells what part of the disc a shadow's edge cuts off."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial, grid
from engine.report.records import Extreme

F8 = NDArray[np.float64]

#: GLSL of point `k` of `taps`, and of the direction of the first one
PATTERNS = {
    "vogel turned": ("direction * vogel_radius(k, taps)", "turned"),
    "vogel": ("direction * vogel_radius(k, taps)", "fixed"),
    "random": ("random_point(seed, k)", "fixed"),
    "grid": ("grid_point(k, taps)", "fixed"),
}
FUNCTIONS = """
uint hash(uint v)
{
    uint state = v * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
vec2 random_point(uvec2 seed, int k)
{
    uint a = hash(seed.x ^ hash(seed.y ^ hash(uint(k))));
    float turn = float(hash(a)) * (2.0 * PI / 4294967296.0);
    return vec2(cos(turn), sin(turn)) * sqrt((float(a) + 0.5) / 4294967296.0);
}
// Shirley and Chiu 1997, "A low distortion map between disk and square": the middles of a square's cells
vec2 grid_point(int k, int taps)
{
    int side = int(round(sqrt(float(taps))));
    vec2 p = (vec2(k % side, k / side) + 0.5) / float(side) * 2.0 - 1.0;
    if (p == vec2(0.0)) return p;
    bool wide = abs(p.x) > abs(p.y);
    float turn = wide ? 0.25 * PI * p.y / p.x : 0.5 * PI - 0.25 * PI * p.x / p.y;
    return (wide ? p.x : p.y) * vec2(cos(turn), sin(turn));
}
float lit_part(vec3 edge, uvec2 seed)
{
    vec2 turned = vec2(cos(pixel_turn(seed)), sin(pixel_turn(seed)));
    vec2 fixed_one = vec2(1.0, 0.0);
    vec2 direction = START;
    int taps = TAPS;
    float lit = 0.0;
    for (int k = 0; k < taps; ++k) {
        lit += dot(POINT, edge.xy) < edge.z ? 1.0 : 0.0;
        direction = GOLDEN_TURN * direction;
    }
    return lit / float(taps);
}
"""


def cut_area(distance: NDArray[np.floating]) -> F8:
    """The part of a unit disc on the near side of a line `distance` from its middle (in [-1, 1]; beyond: 0 or 1)."""
    d = np.clip(np.asarray(distance, np.float64), -1.0, 1.0)
    result: F8 = 0.5 + (np.arcsin(d) + d * np.sqrt(1.0 - d * d)) / np.pi
    return result


def edges(ctx: Context) -> tuple[NDArray[np.float32], NDArray[np.uint32], F8]:
    """Lines f4[n,3] (unit normal, distance), pixels u4[n,2], and the exact part of the disc."""
    rng = ctx.rng("edges")
    n = 1 << (14 if ctx.quick else 16)
    turn = rng.uniform(0.0, 2.0 * np.pi, n)
    lines = np.stack([np.cos(turn), np.sin(turn), rng.uniform(-1.0, 1.0, n)], axis=1).astype(np.float32)
    pixels = np.stack([np.arange(n) % 256, np.arange(n) // 256], axis=1).astype(np.uint32)
    return lines, pixels, cut_area(lines[:, 2])


def kernel(ctx: Context, pattern: str, taps: int) -> Any:
    point, start = PATTERNS[pattern]
    functions = FUNCTIONS.replace("START", "turned" if start == "turned" else "fixed_one")
    functions = functions.replace("POINT", point).replace("TAPS", str(taps))
    inputs = {"edge": "vec3", "seed": "uvec2"}
    return ctx.shaders().kernel("lit_part(edge, seed)", inputs, "float", include=["lib/disc.glsl"], functions=functions)


def run(ctx: Context, knobs: Knobs) -> Trial:
    lines, pixels, truth = ctx.once("edges", lambda: edges(ctx))
    dispatch = kernel(ctx, str(knobs["pattern"]), int(knobs["taps"])).bind(edge=lines, seed=pixels)

    def judge(_: object) -> Outcome:
        off = dispatch.read() - truth
        return Outcome({"rmse": float(np.sqrt(np.mean(off**2))), "max_error": float(np.abs(off).max())})

    return Trial(dispatch.run, judge, gpu=True, close=dispatch.release)


def extremes(ctx: Context) -> Iterator[Extreme]:
    away = np.array([[1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [0.6, 0.8, 1.0], [-1.0, 0.0, 1.0]], np.float32)
    pixels = np.array([[0, 0], [65535, 65535], [7, 3], [4095, 1]], np.uint32)
    for taps in (1, 8, 64):
        got = kernel(ctx, "vogel turned", taps)(edge=away, seed=pixels)
        right = bool((got == [0.0, 0.0, 1.0, 1.0]).all())
        yield Extreme(f"{taps} taps beside the edge", "all dark or all lit" if right else str(got.tolist()), right)
    n = 1 << 12
    along = np.arange(n)
    rows = np.tile(np.array([[1.0, 0.0, 0.0]], np.float32), (n, 1))
    seeds = np.stack([along % 64, along // 64], axis=1).astype(np.uint32)
    mean = float(kernel(ctx, "vogel turned", 8)(edge=rows, seed=seeds).mean())
    yield Extreme("mean over 4096 pixels on the edge", f"{mean:.4f}", abs(mean - 0.5) < 0.01)


EXPERIMENT = Experiment(
    title="Shadow filter: points of a disc",
    method="the mean of lookups at the points of shaders/lib/disc.glsl (Vogel's spiral, turned for each pixel), of the"
    " same unturned, of random points and of a square's cells mapped to the disc",
    truth="the exact part of the disc that a straight edge cuts off",
    metric="rmse",
    unit="visibility",
    knobs=grid(pattern=PATTERNS, taps=(1, 4, 16, 64)) + [{"pattern": "vogel turned", "taps": n} for n in (8, 32)],
    default={"pattern": "vogel turned", "taps": 8},
    curve="pattern",
    run=run,
    orders=[
        Order(0.5, "random points: one over the root of their number", "1 / taps",
              step=lambda k: 1.0 / float(k["taps"]), curve="random", tolerance=0.1, cost=1.0),
        Order(0.8, "Vogel's spiral", "1 / taps", step=lambda k: 1.0 / float(k["taps"]), curve="vogel turned",
              tolerance=0.15, cost=1.0),
    ],
    needs=frozenset({"gpu"}),
    timed="gpu",
    extremes=extremes,
    step_label="1 / taps",
    note="The hardware's own 2x2 filter, which softens each lookup further, is not part of it: edges here are hard.",
)  # fmt: skip
