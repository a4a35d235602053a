"""What a crowd costs the CPU: 1 to 1,000 characters of 19 and 60 joints, each at its own time in a two-clip blend.

With panda3d beside it, on the same skeleton and clips of 19 joints and in the same run, where this interpreter has it
or the environment variable LUCARNA_PANDA3D_PYTHON names one that has. Both sides end with skinning matrices; the note
says how far apart their joints are at time 0. ozz-animation publishes no times: see OZZ.
"""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from engine.animation import poses
from engine.animation.animator import Animator
from engine.animation.blend import BlendJob
from engine.animation.blend_space import BlendSpace
from engine.animation.graph import AnimationGraph, ClipUse, Motion, Param, State
from engine.animation.rig import Rig
from engine.animation.sampler import ClipSampler
from engine.assets.clip import Channel, ClipAsset
from engine.report.summary import Summary, summarise
from engine.scene.scene import Scene
from tests.bench.harness import Context, Row

KEYS = 48
SECONDS = (1.1, 0.7)
PEER = Path(__file__).parent / "peers" / "panda3d_crowd.py"
#: looked for in its README, its page on the animation runtime and those of its samples playback, blend, multithread
OZZ = "ozz-animation publishes no times (guillaumeblanc.github.io/ozz-animation)"


def run(ctx: Context) -> list[Row]:
    counts = (1, 10, 100) if ctx.quick else (1, 10, 100, 1_000)
    rows, ours = [], {}
    for joints in (19, 60):
        for count in counts:
            measured, ours[joints, count] = crowd(ctx, count, joints)
            rows += measured
    return rows + panda3d({count: ours[19, count] for count in counts})


def panda3d(ours: dict[int, tuple[float, float]]) -> list[Row]:
    """Its rows, with ratios to `ours`: count -> median and least ms a frame. Where it is absent, why goes to stderr."""
    python = os.environ.get("LUCARNA_PANDA3D_PYTHON", "")
    if not python and importlib.util.find_spec("panda3d") is None:
        print("characters: panda3d is left out: not installed, and LUCARNA_PANDA3D_PYTHON is not set", file=sys.stderr)
        return []
    parent, _, clips = body(19)
    data = {
        "fps": [(KEYS - 1) / s for s in SECONDS], "parent": parent.tolist(),
        "clips": [np.concatenate([t, r], axis=2).tolist() for t, r in map(curves, clips)],
    }  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "crowd.json"
        file.write_text(json.dumps(data), "utf-8")
        command = [python or sys.executable, str(PEER), str(file), *map(str, ours)]
        ran = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    if ran.returncode:
        print(f"characters: panda3d is left out, its script failed: {ran.stderr.strip()[-300:]}", file=sys.stderr)
        return []
    rows = []
    for line in map(json.loads, filter(None, ran.stdout.splitlines())):
        time: Summary = summarise(line["ms"])
        count, off = int(line["count"]), float(np.abs(np.array(line["joints"]) - first_pose()).max())
        median, least = ours[count]
        note = f"{time.median / count:.4f} ms a character; Lucarna takes {median / time.median:.2f} times as long"
        note += f", {least / time.minimum:.2f} at best"
        note += f"; joints within {off * 1000.0:.2g} mm of ours" + (f"; {OZZ}" if count == max(ours) else "")
        rows.append(Row(f"{count} x 19 joints", f"panda3d {line['version']}: clock and force_update", time, note=note))
    return rows


def body(joints: int) -> tuple[np.ndarray, np.ndarray, list[ClipAsset]]:
    """(parents [n], rest pose [10,n], two clips); limbs of five joints each on one root, as in people."""
    rng = np.random.default_rng(joints)
    parent = np.array([-1] + [0 if i % 5 == 1 else i - 1 for i in range(1, joints)])
    rest = np.zeros((10, joints))
    rest[0:3], rest[6], rest[7:10] = rng.normal(size=(3, joints)) * 0.2, 1.0, 1.0
    around = rng.normal(size=(joints, 4))
    return parent, rest, [clip(rng, around, seconds) for seconds in SECONDS]


def curves(asset: ClipAsset) -> tuple[np.ndarray, np.ndarray]:
    """Translations f[n,keys,3] and rotations f[n,keys,4] of a clip made by `clip`."""
    paths = {path: [c.values for c in asset.channels if c.path == path] for path in ("translation", "rotation")}
    return np.array(paths["translation"], np.float64), np.array(paths["rotation"], np.float64)


def first_pose() -> np.ndarray:
    """f8[19,3]: where the joints are with both clips at their first key, half and half."""
    parent, rest, clips = body(19)
    rig = Rig(tuple(f"joint {i}" for i in range(19)), parent, rest, np.arange(19))
    inputs = [poses.resting(rest, 1) for _ in clips]
    for asset, pose in zip(clips, inputs, strict=True):
        ClipSampler(asset, rig).sample(np.zeros(1), pose)
    out = np.zeros_like(inputs[0])
    BlendJob(inputs, np.full((2, 1), 0.5), rest, out).run()
    scene = Scene()
    for joint in range(19):
        t, r, s = (tuple(out[part, 0, joint]) for part in (poses.T, poses.R, poses.S))
        scene.nodes.add("", int(parent[joint]), t, r, s)
    scene.update()
    return np.asarray(scene.nodes.world[:, :, 3])


def crowd(ctx: Context, count: int, joints: int) -> tuple[list[Row], tuple[float, float]]:
    """The rows of one crowd, and the sums of their medians and least times, ms a frame."""
    rng = np.random.default_rng(joints + count)
    parent, rest, clips = body(joints)
    rig = Rig(tuple(f"joint {i}" for i in range(joints)), parent, rest, np.arange(joints))
    samplers = [ClipSampler(asset, rig) for asset in clips]
    graph = AnimationGraph(
        rig, [ClipUse(s) for s in samplers], [State("move", Motion((0, 1), BlendSpace([0.0, 1.0]), (0,)))],
        [Param("speed")],
    )  # fmt: skip
    animator = Animator(graph, count)
    animator.set("speed", rng.uniform(0.1, 0.9, count))
    animator.seek(rng.uniform(0.0, 1.0, count))
    scene = Scene()
    nodes = scene.nodes
    rows = nodes.add_many(
        [""] * (count * joints),
        batch_parents=np.where(parent >= 0, parent + joints * np.arange(count)[:, None], -1).reshape(-1),
    ).reshape(count, joints)
    for row in rows:
        scene.skins.add(int(row[0]), row, np.tile(np.eye(4), (joints, 1, 1)), np.ones(joints))
    nodes.update()
    origin = np.zeros(3)

    def update() -> None:
        animator.update(1.0 / 60.0)

    def write() -> None:
        animator.write(nodes, rows)

    case = f"{count} x {joints} joints"
    measured = [
        ctx.measure(case, "sample and blend 2 clips", update),
        ctx.measure(case, "write to nodes", write, before=update),
        ctx.measure(case, "hierarchy", nodes.update, before=write),
        ctx.measure(case, "palettes", lambda: scene.skins.palette(origin)),
    ]
    total, least = (sum(getattr(row.time, name) for row in measured) for name in ("median", "minimum"))
    note = f"all {total / count:.4f} ms a character, {least / count:.4f} at best"
    return [*measured[:-1], replace(measured[-1], note=note)], (total, least)


def clip(rng: np.random.Generator, around: np.ndarray, seconds: float) -> ClipAsset:
    """Keys for every joint, with rotations near `around` [n,4]: as walk and run, clips that are blended are alike."""
    times = np.linspace(0.0, seconds, KEYS).astype(np.float32)
    channels = []
    for joint, near in enumerate(around):
        turns = np.cumsum(rng.normal(size=(KEYS, 4)) * 0.05, axis=0) + near
        turns /= np.linalg.norm(turns, axis=1, keepdims=True)
        channels.append(Channel(joint, "rotation", "linear", times, turns.astype(np.float32)))
        for path, values in (("translation", rng.normal(size=(KEYS, 3)) * 0.2), ("scale", np.ones((KEYS, 3)))):
            channels.append(Channel(joint, path, "linear", times, values.astype(np.float32)))
    return ClipAsset(f"{seconds} s", channels)
