"""Points of a disc: how well the mean of a few lookups tells what part of the disc a shadow's edge cuts off.

Judged as an eye sees it. A few lookups give a few levels of grey; along a straight edge the same points in every pixel
make bands of them, and bands are what is seen. Turning the points by another angle in every pixel leaves each pixel as
wrong as before (`rmse`), but neighbours are then wrong independently of each other, and an eye, which does not resolve
single pixels, sees their mean. So the metric is the error that is left after the eye's own blur for luminance,
exp(-pi^2 x^2 / 0.0047 deg^2) (Zhang and Wandell 1996, S-CIELAB; the filter that FLIP starts with, Andersson et al.
2020, table 1), on a display of 67 pixels per degree: a Gaussian of sigma 1.03 px. It is measured over penumbrae from 4
to 108 pixels wide; FLIP of the same picture stands beside it and says the same.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial, grid
from engine.experiments.harness.pictures import beside_truth
from engine.gpu.types import Sampler, SamplerDesc, Texture, TextureDesc
from engine.math.color import to_u1
from engine.report.perceptual import flip
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
        vec2 p = POINT;
        vec2 at = vec2(dot(p, edge.xy) - edge.z, dot(p, vec2(-edge.y, edge.x)));
        lit += textureLod(t_edge, at / 8.0 + 0.5, 0.0).r < 0.0 ? 1.0 : 0.0;
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


@dataclass(frozen=True, slots=True)
class Penumbrae:
    """A picture [h,w] of straight edges: lines f4[h,w,3] (unit normal, distance in half widths), pixels u4[h,w,2],
    and the exact part of the disc."""

    lines: NDArray[np.float32]
    pixels: NDArray[np.uint32]
    truth: F8


#: pixels from all dark to all lit
WIDTHS = (4, 12, 36, 108)
#: pixels a degree that FLIP takes a display to have, and sigma of the eye's blur there
PER_DEGREE = 67.0
SIGMA = math.sqrt(0.0047 / 2.0) / math.pi * PER_DEGREE


def penumbrae(ctx: Context) -> Penumbrae:
    """One row of tiles for each width, one edge in each, at angles of its own."""
    size, columns = (96, 2) if ctx.quick else (128, 4)
    turns = ctx.rng("edges").uniform(0.0, 2.0 * np.pi, (len(WIDTHS), columns))
    y, x = np.mgrid[0 : size * len(WIDTHS), 0 : size * columns]
    turn = turns.repeat(size, axis=0).repeat(size, axis=1)
    half = np.array(WIDTHS, np.float64).repeat(size)[:, None] / 2.0
    normal = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    off = np.stack([x % size, y % size], axis=-1) + 0.5 - size / 2.0
    distance = (normal * off).sum(axis=-1) / half
    lines = np.concatenate([normal, distance[..., None]], axis=-1).astype(np.float32)
    return Penumbrae(lines, np.stack([x, y], axis=-1).astype(np.uint32), cut_area(lines[..., 2]))


def seen(off: F8) -> F8:
    """What is left of a difference [h,w] after the eye's blur."""
    reach = math.ceil(4.0 * SIGMA)
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / SIGMA) ** 2)
    weight /= weight.sum()
    for axis in (0, 1):
        padded = np.pad(off, [(reach, reach) if a == axis else (0, 0) for a in (0, 1)], mode="edge")
        off = np.apply_along_axis(lambda row: np.convolve(row, weight, "valid"), axis, padded)
    return off


def shown(visibility: F8) -> NDArray[np.uint8]:
    """A grey wall in that light, u1[h,w,3]."""
    return to_u1(np.repeat((0.05 + 0.75 * visibility)[..., None], 3, axis=-1))


def edge_map(ctx: Context) -> tuple[Texture, Sampler]:
    """The map that every point is looked up in, 8 radii wide: the distance to the edge, linear between its texels, so
    that their size does not count but a lookup costs what one costs."""
    assert ctx.device is not None, "the experiment needs a device"
    size = 256
    ramp = np.tile(((np.arange(size, dtype=np.float32) + 0.5) / size - 0.5) * 8.0, (size, 1))
    texture = ctx.device.texture(TextureDesc("r32f", size, size, label="edge"))
    texture.write(ramp.tobytes())
    ctx.closing.append(texture.release)
    return texture, ctx.device.sampler(SamplerDesc("clamp", "clamp", "clamp", "linear", "linear"))


def kernel(ctx: Context, pattern: str, taps: int) -> Any:
    point, start = PATTERNS[pattern]
    functions = FUNCTIONS.replace("START", "turned" if start == "turned" else "fixed_one")
    functions = functions.replace("POINT", point).replace("TAPS", str(taps))
    inputs = {"edge": "vec3", "seed": "uvec2"}
    return ctx.shaders().kernel(
        "lit_part(edge, seed)", inputs, "float", include=["lib/disc.glsl"], functions=functions,
        textures={"t_edge": ctx.once("edge map", lambda: edge_map(ctx))},
    )  # fmt: skip


def run(ctx: Context, knobs: Knobs) -> Trial:
    made = ctx.once("penumbrae", lambda: penumbrae(ctx))
    shape = made.truth.shape
    dispatch = kernel(ctx, str(knobs["pattern"]), int(knobs["taps"])).bind(
        edge=made.lines.reshape(-1, 3), seed=made.pixels.reshape(-1, 2)
    )

    def judge(_: object) -> Outcome:
        got = dispatch.read().reshape(shape)
        off = got - made.truth
        error = {
            "seen_rmse": float(np.sqrt(np.mean(seen(off) ** 2))),
            "rmse": float(np.sqrt(np.mean(off**2))),
            "max_error": float(np.abs(off).max()),
        }
        if not ctx.quick or knobs["taps"] in (8, 16):
            try:
                error["flip"] = flip(shown(got), shown(made.truth))[0]
            except LucarnaError as missing:
                ctx.omit("FLIP", str(missing))
        pictures = []
        if (knobs["pattern"], knobs["taps"]) in (("vogel turned", 8), ("vogel", 16)):
            name = f"{knobs['pattern']}, {knobs['taps']} taps"
            pictures = beside_truth(ctx, name, shown(got), "exact", shown(made.truth))
        return Outcome(error, pictures=pictures)

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
    truth="the exact part of the disc that a straight edge cuts off, over penumbrae of 4 to 108 pixels",
    metric="seen_rmse",
    unit="visibility, after the eye's blur",
    knobs=grid(pattern=PATTERNS, taps=(1, 4, 16, 64)) + grid(pattern=("vogel turned", "vogel"), taps=(8, 32)),
    default={"pattern": "vogel turned", "taps": 8},
    curve="pattern",
    run=run,
    quick=lambda k: k["taps"] <= 32,
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
    note="Each pixel by itself is as wrong with turned points as without (rmse). What is seen, by the eye's blur or by"
    " FLIP, is less, since neighbours no longer err alike. Every point is a real texture lookup; the hardware's own"
    " 2x2 filter, which softens each of them further, is not part of it: edges here are hard.",
)  # fmt: skip
