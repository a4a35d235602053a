"""Key reduction and quantisation: millimetres at the skin against bytes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.animation.compress import clip_nbytes, compress
from engine.animation.key_reduction import reduce_clip, skin_budget
from engine.assets.clip import Channel, ClipAsset
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.math import quat
from engine.math.transform import compose
from engine.report.records import Extreme

F8 = NDArray[np.float64]

#: a limb of eight joints 0.2 m apart, its skin 0.1 m around it, 30 keys a second for two seconds
CHAIN, LENGTH, AROUND, KEYS = 8, 0.2, 0.1, 61
ERRORS = (0.1, 0.3, 1.0, 3.0, 10.0)


def clip() -> ClipAsset:
    times = np.linspace(0.0, 2.0, KEYS)
    channels = []
    for joint in range(CHAIN):
        axis = np.array([np.sin(joint), np.cos(joint), 0.3])
        angle = 0.5 * np.sin(2.0 * np.pi * times * (0.5 + 0.1 * joint)) + 0.1 * np.sin(9.0 * times + joint)
        q = quat.from_axis_angle(axis, angle)
        channels.append(Channel(joint, "rotation", "linear", times.astype("f4"), q.astype("f4")))
        place = np.tile([0.0, LENGTH if joint else 1.0, 0.0], (KEYS, 1))
        place[:, 0] += 0.02 * np.sin(2.0 * np.pi * times) if joint == 0 else 0.0
        channels.append(Channel(joint, "translation", "linear", times.astype("f4"), place.astype("f4")))
        channels.append(Channel(joint, "scale", "linear", times.astype("f4"), np.ones((KEYS, 3), "f4")))
    return ClipAsset("limb", channels, frame_rate=30.0)


def skin(of: ClipAsset, times: F8) -> F8:
    """f8[times, points, 3]: points of the skin round every joint, carried rigidly by it."""
    from engine.animation.sample import sample_track
    from engine.animation.tracks import pack

    tracks = pack(of, np.arange(CHAIN))
    around = AROUND * np.array([[1, 0, 0], [-1, 0, 0], [0, 0, 1], [0, 0, -1], [0, 1, 0]], np.float64)
    out = np.zeros((len(times), CHAIN * len(around), 3))
    for i, time in enumerate(times):
        local: dict[str, F8] = {
            "translation": np.tile([0.0, LENGTH, 0.0], (CHAIN, 1)), "rotation": np.tile([0.0, 0, 0, 1], (CHAIN, 1)),
            "scale": np.ones((CHAIN, 3)),
        }  # fmt: skip
        for track in tracks:
            local[track.path][track.rows] = sample_track(track, float(time))
        world = compose(local["translation"], local["rotation"], local["scale"])
        for joint in range(1, CHAIN):
            world[joint] = world[joint - 1] @ world[joint]
        out[i] = (np.einsum("jab,pb->jpa", world[:, :3, :3], around) + world[:, None, :3, 3]).reshape(-1, 3)
    return out


def _budget(source: ClipAsset, millimetres: float) -> Any:
    parent = [joint - 1 for joint in range(CHAIN)]
    rest = np.tile([0.0, LENGTH, 0.0], (CHAIN, 1))
    return skin_budget(source, parent, rest, np.ones((CHAIN, 3)), np.full(CHAIN, AROUND), millimetres * 1e-3)


def run(ctx: Context, knobs: Knobs) -> Trial:
    source = clip()
    times = np.linspace(0.0, 2.0, 121)
    truth = ctx.once("truth", lambda: skin(clip(), np.linspace(0.0, 2.0, 121)))
    method, allowed = knobs["method"], knobs["allowed"]

    def work() -> Any:
        if method == "as it is":
            return source, clip_nbytes(source)
        budget = _budget(source, allowed)
        if method == "fewer keys":
            short = reduce_clip(source, budget)
            return short, clip_nbytes(short)
        packed = compress(source, budget)
        return packed, clip_nbytes(packed)

    def judge(got: Any) -> Outcome:
        error = np.linalg.norm(skin(got[0], times) - truth, axis=2) * 1e3
        return Outcome(
            {"max_mm": float(error.max()), "rms_mm": float(np.sqrt(np.mean(error**2)))},
            extra={
                "bytes": got[1],
                "allowed, mm": allowed,
                "within": bool(error.max() <= allowed or method == "as it is"),
            },
        )

    return Trial(work, judge)


def extremes(ctx: Context) -> Iterator[Extreme]:
    still = ClipAsset(
        "still", [Channel(0, "rotation", "linear", np.array([0, 1], "f4"), np.tile([0, 0, 0, 1], (2, 1)).astype("f4"))]
    )
    packed = compress(still, {(0, "rotation"): 1e-3})
    size = clip_nbytes(packed)
    yield Extreme("a channel that does not move", f"{size} bytes", len(packed.channels[0].times) <= 2)
    tight = compress(clip(), _budget(clip(), 1e-4))
    exact = sum(c.codes is None for c in tight.channels)
    yield Extreme("a ten-thousandth of a millimetre", f"{exact} of {len(tight.channels)} stay float32", exact > 0)


EXPERIMENT = Experiment(
    title="Storing clips: fewer keys, fewer bits",
    method="key_reduction (greedy, within a budget at the skin), compress (that and 16 bits)",
    truth="the clip as it was, its skin in float64 at 121 moments",
    metric="max_mm",
    unit="mm at the skin",
    knobs=[
        {"method": "as it is", "allowed": 0.0},
        *({"method": m, "allowed": e} for m in ("fewer keys", "fewer keys, 16 bits") for e in ERRORS),
    ],
    default={"method": "fewer keys, 16 bits", "allowed": 1.0},
    curve="method",
    run=run,
    also=("bytes",),
    extremes=extremes,
    note="`bytes` counts every array of the file. The time is that of packing, once, at import. No order is expected:"
    " the error is what is allowed, or less. Converted files use the default; they allow 1/10,000 of the model's size"
    " unless told otherwise, and overdraw the budget as far as the error measured over the whole clip stays below.",
)
