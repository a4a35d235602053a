"""Halving images for mips: which kernel keeps what the smaller image can show, and nothing else."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context, Floats
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.report.records import Floor, Picture

F8 = NDArray[np.float64]

SIZE = 128
#: cycles across the image; the half-size image can show up to SIZE / 4
FREQUENCIES = (1, 2, 3, 4, 6, 8, 12, 16, 20, 24, 28, 30, 34, 36, 40, 46, 52, 58, 62)


def weights(kind: str, radius: int) -> F8:
    """A symmetric kernel for halving: weights of source texels -2 radius + 1/2 … 2 radius - 1/2 from the centre."""
    x = (np.arange(4 * radius) + 0.5) / 2.0 - radius  # in texels of the result
    if kind == "tent":
        w = np.maximum(1.0 - np.abs(x), 0.0)
    elif kind == "lanczos":
        w = np.sinc(x) * np.sinc(x / radius)
    else:
        w = np.sinc(x) * np.i0(4.0 * np.sqrt(np.maximum(1.0 - (x / radius) ** 2, 0.0)))
    result: F8 = w / w.sum()
    return result


def halve(image: Floats, kernel: F8) -> Floats:
    """`image` f4[n,n,c] at half size by a separable kernel; it repeats at the borders."""
    for axis in (0, 1):
        n = image.shape[axis]
        first = np.arange(n // 2) * 2 + 1 - len(kernel) // 2
        out = np.float32(0.0)
        for k, w in enumerate(kernel):
            out = out + np.take(image, (first + k) % n, axis=axis) * np.float32(w)
        image = np.asarray(out, np.float32)
    return image


def texture(ctx: Context) -> tuple[Floats, F8]:
    """An image with a 1/f spectrum as natural ones have, and its ideal half: the waves below the limit alone."""
    rng = ctx.rng("waves")
    u = (np.arange(SIZE) + 0.5) / SIZE
    v = (np.arange(SIZE // 2) + 0.5) / (SIZE // 2)
    full, half = np.full((SIZE, SIZE), 0.5), np.full((SIZE // 2, SIZE // 2), 0.5)
    for _ in range(400):
        fx, fy = rng.integers(-SIZE // 2 + 1, SIZE // 2, 2)
        f = math.hypot(fx, fy)
        if f == 0.0:
            continue
        amplitude, phase = 0.25 / f, rng.uniform(0.0, 2.0 * math.pi)
        full += amplitude * np.cos(2.0 * math.pi * (fx * u[None, :] + fy * u[:, None]) + phase)
        if max(abs(fx), abs(fy)) < SIZE // 4:
            half += amplitude * np.cos(2.0 * math.pi * (fx * v[None, :] + fy * v[:, None]) + phase)
    return full[..., None].astype(np.float32), half


def waves() -> tuple[Floats, F8]:
    """Single waves, cosine and sine, one a channel, and their ideal halves (nothing above the limit)."""
    u, v = ((np.arange(n) + 0.5) / n for n in (SIZE, SIZE // 2))
    angles = np.array([(f, p) for f in FREQUENCIES for p in (0.0, math.pi / 2.0)])
    full = np.cos(2.0 * math.pi * u[:, None] * angles[:, 0] + angles[:, 1])
    half = np.cos(2.0 * math.pi * v[:, None] * angles[:, 0] + angles[:, 1]) * (angles[:, 0] < SIZE / 4)
    return np.broadcast_to(full[None], (SIZE, *full.shape)).astype(np.float32), half


def zone_plate() -> Floats:
    """Rings that get finer outwards up to the limit of the full image."""
    x = (np.arange(SIZE) + 0.5 - SIZE / 2) / SIZE
    r2 = x[None, :] ** 2 + x[:, None] ** 2
    return (0.5 + 0.5 * np.cos(math.pi * SIZE * r2))[..., None].astype(np.float32)


def run(ctx: Context, knobs: Knobs) -> Trial:
    image, ideal = ctx.once("texture", lambda: texture(ctx))
    kind, radius = str(knobs["kernel"]), int(knobs["radius"])
    tools = ctx.lent()
    rgba = np.repeat(image, 4, axis=2)

    def shrink(given: Floats) -> Floats:
        if kind == "every second":
            return np.ascontiguousarray(given[::2, ::2])
        if kind.startswith("importer"):
            return tools.resample(given, SIZE // 2, SIZE // 2, kind.split()[1])
        return halve(given, weights(kind, radius))

    def judge(got: Floats) -> Outcome:
        contrast = float(ideal.std())
        full, half = waves()
        off = shrink(full)[0].astype(np.float64) - half
        rows = np.sqrt((off**2).mean(axis=0).reshape(-1, 2).sum(axis=1))
        pictures, shown = [], radius == 3 or kind not in ("lanczos", "kaiser")
        if kind in ("every second", "importer box", "importer kaiser"):
            pictures = _pictures(ctx, kind, shrink(zone_plate()))
        return Outcome(
            {"rel_rmse": float(np.sqrt(np.mean((got[..., 0] - ideal) ** 2))) / contrast,
             "max_error": float(np.abs(got[..., 0] - ideal).max())},
            # of the kernels by radius one each: more lines would hide each other
            profile=[(f / SIZE, r) for f, r in zip(FREQUENCIES, rows, strict=True)] if shown else [],
            pictures=pictures,
        )  # fmt: skip

    return Trial(lambda: shrink(rgba), judge)


def _pictures(ctx: Context, kind: str, got: Floats) -> list[Picture]:
    spectrum = np.fft.fft2(zone_plate()[..., 0].astype(np.float64))
    f: F8 = np.asarray(np.fft.fftfreq(SIZE, 1.0 / SIZE), np.float64)
    keep = (np.abs(f)[:, None] < SIZE / 4) & (np.abs(f)[None, :] < SIZE / 4)
    # half a texel over, to the centres of the smaller image
    shift = np.exp(1j * (math.pi / SIZE) * (f[:, None] + f[None, :]))
    ideal = np.real(np.fft.ifft2(spectrum * keep * shift))[::2, ::2]
    pair = (np.asarray(got[..., 0], np.float64), ideal)
    shown = [np.rint(np.clip(v, 0.0, 1.0) * 255.0).astype(np.uint8) for v in pair]
    a, b = (np.repeat(v[..., None], 3, axis=2).repeat(3, axis=0).repeat(3, axis=1) for v in shown)
    return beside_truth(ctx, kind, a, "ideal", b)


EXPERIMENT = Experiment(
    title="Filtering mips",
    method="halving an image of 128² texels by the importer's kernels (box, Kaiser), and by tent, Lanczos and Kaiser of"
    " other radii",
    truth="analytic: of a sum of waves with a 1/f spectrum, those below the half-size limit, unchanged, and no other",
    metric="rel_rmse",
    unit="of the contrast",
    knobs=[
        {"kernel": "every second", "radius": 0},
        {"kernel": "importer box", "radius": 1},
        {"kernel": "importer kaiser", "radius": 3},
        {"kernel": "tent", "radius": 1},
    ]
    + [{"kernel": k, "radius": r} for k in ("lanczos", "kaiser") for r in (1, 2, 3, 4, 6)],
    default={"kernel": "importer box", "radius": 1},
    curve="kernel",
    run=run,
    orders=[
        Order(2.0, "the box dims a wave by 1 - cos(pi f)", "frequency", between=(0.0, 0.13), tolerance=0.15),
    ],
    needs=frozenset({"tools"}),
    format_floor=Floor(1.0 / 255.0 / 12.0**0.5 / 0.1, "8-bit, at a contrast of 0.1"),
    profile_label="frequency (cycles per texel; the limit is 0.25)",
    note="Left of the limit the error is blur, right of it aliasing. The box is the importer's preset “normal”, Kaiser"
    " of radius 3 that of “high” and “final”.",
)
