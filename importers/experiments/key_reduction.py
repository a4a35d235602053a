"""Fewer keys in fewer bits in a clip (`--key-error-mm`): what the skin is really off by, against bytes and time."""

from __future__ import annotations

import numpy as np

from engine.animation.compress import clip_nbytes
from engine.assets.clip import Channel, ClipAsset
from engine.assets.scene import NodeAsset
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial, grid
from engine.report.records import Extreme
from importers.key_reduction import clip_error, key_count, reduced

JOINTS = 10
REACH = 0.15
#: millimetres that a vertex may be off by; 0: all keys
ERRORS = (0.0, 0.01, 0.1, 1.0, 10.0)
MOTIONS = ("smooth", "noisy")


def rig(motion: str, seconds: float, rng: np.random.Generator) -> tuple[list[NodeAsset], ClipAsset]:
    """A chain of joints 0.2 m apart, each turning about an axis of its own by a few sines, with keys at 30 Hz; `noisy`
    adds 0.05 degrees of shake, as captured motion has."""
    nodes = [NodeAsset(f"joint {k}", k - 1, (0.0, 0.2 if k else 0.0, 0.0)) for k in range(JOINTS)]
    times = np.arange(round(seconds * 30) + 1) / 30.0
    channels = []
    for k in range(JOINTS):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        waves = [rng.uniform(0.05, 0.2) * np.sin(times * rate + rng.uniform(0, 6)) for rate in (1.0, 2.7)]
        angle = np.sum(waves, axis=0)
        if motion == "noisy":
            angle = angle + np.radians(0.05) * rng.standard_normal(len(times))
        half = angle[:, None] / 2.0
        values = np.concatenate([np.sin(half) * axis, np.cos(half)], axis=1)
        channels.append(Channel(k, "rotation", "linear", times.astype("<f4"), values.astype("<f4"), f"joint {k}"))
        still = np.tile(np.array([nodes[k].translation]), (len(times), 1))
        channels.append(Channel(k, "translation", "linear", times.astype("<f4"), still.astype("<f4"), f"joint {k}"))
    return nodes, ClipAsset(motion, channels, 0.0, 30.0)


def run(ctx: Context, knobs: Knobs) -> Trial:
    motion, allowed = str(knobs["motion"]), float(knobs["allowed_mm"])
    made: tuple[list[NodeAsset], ClipAsset] = ctx.once(
        f"rig {motion}", lambda: rig(motion, 1.0 if ctx.quick else 4.0, ctx.rng("rig"))
    )
    nodes, clip = made
    reach = np.full(JOINTS, REACH)

    def judge(short: ClipAsset) -> Outcome:
        error = 1000.0 * clip_error(clip, short, nodes, reach)
        size = clip_nbytes(short)
        return Outcome(
            {"skin_mm": error},
            extra={"bytes": size, "of the bytes": round(size / clip_nbytes(clip), 4), "keys": key_count(short)},
        )

    if allowed == 0.0:
        return Trial(lambda: clip, judge)
    return Trial(lambda: reduced(clip, nodes, reach, allowed / 1000.0), judge)


def extremes(ctx: Context) -> list[Extreme]:
    """What stands still keeps one key of each channel (the last one's end, too); no error is over what was allowed."""
    nodes, clip = rig("smooth", 1.0, ctx.rng("still"))
    still = ClipAsset("still", [c for c in clip.channels if c.path == "translation"], 0.0, 30.0)
    short = reduced(still, nodes, np.full(JOINTS, REACH), 1e-4)
    left = key_count(short)
    worst = 0.0
    for allowed in (0.1, 10.0):
        error = clip_error(
            clip, reduced(clip, nodes, np.full(JOINTS, REACH), allowed / 1000.0), nodes, np.full(JOINTS, REACH)
        )
        worst = max(worst, 1000.0 * error / allowed)
    return [
        Extreme("nothing moves", f"{left} keys left of {key_count(still)}", left <= JOINTS + 1),
        Extreme("the bound", f"at most {worst:.2f} of what was allowed", worst <= 1.0),
    ]


EXPERIMENT = Experiment(
    title="Fewer keys in fewer bits in clips",
    method="the farthest key from which all keys between are met within a budget, shared out along the chain of joints;"
    " then 16 bits",
    truth="the clip with all its keys",
    metric="skin_mm",
    unit="mm",
    knobs=grid(motion=MOTIONS, allowed_mm=ERRORS),
    default={"motion": "smooth", "allowed_mm": 0.1},
    run=run,
    curve="motion",
    problem="motion",
    also=("bytes",),
    extremes=extremes,
    time_label="median time to reduce",
    note="No order is expected: keys go where they can. The budget is for all joints turning the wrong way at once.",
)
