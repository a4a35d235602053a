"""Prefiltering environments: how many samples of the GGX lobe a texel needs, with and without filtered sources."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context, Floats
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.math import ggx
from engine.math.color import to_u1
from engine.math.sphere import basis, hammersley
from engine.report.records import Floor, Picture

F8 = NDArray[np.float64]

SOURCE, SIZE = 64, 8
ROUGHNESS = 0.4
SAMPLES = (12, 24, 48, 96, 192, 384, 768)


#: radiance of the one texel that is the sun
SUN = 100.0


def source(ctx: Context) -> Floats:
    """The studio with a sun of one texel (1.4 degrees): what photographed environments are like."""

    def make() -> Floats:
        faces = np.array(ctx.lent().source_faces("studio", SOURCE), np.float32)
        faces[2, SOURCE // 3, SOURCE // 2] = SUN
        return faces

    return ctx.once("source", make)


def solid_angles(directions: F8) -> F8:
    """Steradians of each texel of a cube [6,n,n,3], from its direction: (2 / n)^2 cos^3."""
    n = directions.shape[1]
    result: F8 = (2.0 / n) ** 2 * np.abs(directions).max(axis=-1) ** 3
    return result


def convolution(faces: Floats, directions: F8, n: F8, alpha: float) -> F8:
    """What prefiltering estimates: sum of L n.l D / 4 over every texel, divided by the same without L (n = v)."""
    light = directions.reshape(-1, 3)
    weight = solid_angles(directions).ravel()
    radiance = faces.reshape(-1, 3).astype(np.float64)
    out = np.empty((len(n), 3))
    for rows in np.array_split(np.arange(len(n)), max(1, len(n) // 64)):
        nl = np.clip(n[rows] @ light.T, 0.0, 1.0)
        kernel = ggx.D_GGX(np.sqrt((1.0 + nl) / 2.0), alpha) * nl * (nl > 0.0) * weight
        out[rows] = kernel @ radiance / kernel.sum(axis=1, keepdims=True)
    return out


def truth(ctx: Context) -> F8:
    tools = ctx.lent()
    faces = source(ctx)
    n = tools.cube_directions(SIZE).reshape(-1, 3)
    return ctx.references.get(
        "prefiltered", {"faces": faces, "size": SIZE, "roughness": ROUGHNESS},
        lambda: {"rgb": convolution(faces, tools.cube_directions(SOURCE), n, ROUGHNESS**2)},
    )["rgb"]  # fmt: skip


def unfiltered(ctx: Context, samples: int) -> Floats:
    """The same lobe samples, each one the nearest texel of the source at full size."""
    tools = ctx.lent()
    faces = source(ctx)
    n = tools.cube_directions(SIZE).reshape(-1, 3)
    h = ggx.sample_half(hammersley(samples), ROUGHNESS**2)
    local = 2.0 * h[:, 2:] * h - np.array([0.0, 0.0, 1.0])
    local = local[local[:, 2] > 0.0]
    tangent, bitangent = basis(n)
    total = np.zeros((len(n), 3))
    for x, y, z in local:
        total += _nearest(faces, tangent * x + bitangent * y + n * z) * z
    return np.asarray(total / local[:, 2].sum(), np.float32).reshape(6, SIZE, SIZE, 3)


def _nearest(faces: Floats, d: F8) -> Floats:
    """Texels of a cube in directions [n,3] (OpenGL 4.6, table 8.19)."""
    size = np.abs(d)
    axis = size.argmax(axis=1)
    row = np.arange(len(d))
    major = d[row, axis]
    sign = np.where(major < 0.0, -1.0, 1.0)
    x, y, z = d.T
    s = np.choose(axis, [-sign * z, x, sign * x]) / np.abs(major)
    t = np.choose(axis, [-y, sign * z, -y]) / np.abs(major)
    n = faces.shape[1]
    i, j = (np.clip(((v + 1.0) / 2.0 * n).astype(int), 0, n - 1) for v in (s, t))
    picked: Floats = faces[2 * axis + (sign < 0.0), j, i]
    return picked


def run(ctx: Context, knobs: Knobs) -> Trial:
    tools, samples = ctx.lent(), int(knobs["samples"])
    faces = source(ctx)
    filtered = knobs["method"] == "filtered"

    def work() -> Floats:
        return tools.prefilter(faces, SIZE, ROUGHNESS, samples) if filtered else unfiltered(ctx, samples)

    def judge(got: Floats) -> Outcome:
        want = truth(ctx)
        error = got.reshape(-1, 3) - want
        shown: list[Picture] = []
        if samples in (24, 96):
            shown = _pictures(ctx, got, want, f"{knobs['method']}, {samples} samples")
        return Outcome(
            {
                "rel_rmse": float(np.sqrt(np.mean(error**2) / np.mean(want**2))),
                "max_error": float(np.abs(error).max()),
            },
            pictures=shown,
        )

    return Trial(work, judge)


def _pictures(ctx: Context, got: Floats, want: F8, name: str) -> list[Picture]:
    def strip(values: NDArray[np.floating]) -> NDArray[np.floating]:
        cube = np.asarray(values, np.float64).reshape(6, SIZE, SIZE, 3)
        wide = np.concatenate(list(cube[:4]), axis=1)
        return wide.repeat(12, axis=0).repeat(12, axis=1)

    return beside_truth(ctx, name, to_u1(strip(got)), "brute force", to_u1(strip(want)))


def _step(knobs: Knobs) -> float:
    return 1.0 / float(knobs["samples"])


EXPERIMENT = Experiment(
    title="Prefiltering an environment",
    method="GGX-weighted mean of the studio and a sun of one texel (64² faces), for 8² faces at roughness 0.4: samples"
    " of the lobe, from mips chosen by their solid angle (the importer's way), or from the source itself",
    truth="the same weighted mean over every texel of the source, float64",
    metric="rel_rmse",
    unit="of the rms",
    knobs=[{"method": m, "samples": s} for m in ("filtered", "unfiltered") for s in SAMPLES],
    default={"method": "filtered", "samples": 96},
    curve="method",
    run=run,
    quick=lambda k: k["samples"] <= 192,
    orders=[
        Order(
            1.0,
            "the filter's width falls with the samples: about N^-1 of its area",
            "1 / samples",
            step=_step,
            curve="filtered",
            cost=1.0,
            between=(1.0 / 250.0, 1.0),
            tolerance=0.4,
        ),
    ],
    needs=frozenset({"tools"}),
    format_floor=Floor(4.9e-4, "half float"),
    step_label="1 / samples",
    note="Filtering trades noise for blur: with few samples it is far ahead, and what is left is smooth, which an eye"
    " forgives (see the FLIP maps). Without it a sample either hits the sun or misses it, so that its error"
    " jumps instead of falling: no order is fitted there."
    " Beyond 200 samples what is left is the mips' box filter. 96 samples are the importer's choice at this"
    " roughness.",
)
