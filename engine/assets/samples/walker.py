"""The walker: a simple figure of 16 bones that idles, walks, runs and waves, with an animation file to blend them.

The clips are sums of a few sines by hand; walk and run begin with the same foot, so that they blend by phase.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip import Channel, ClipAsset
from engine.assets.mesh import MeshAsset, Skeleton
from engine.assets.samples.sample import SampleScene
from engine.assets.samples.shapes import Patches, box
from engine.assets.scene import CameraAsset, EnvironmentAsset, LookAsset, NodeAsset, SceneAsset
from engine.math import quat

F8 = NDArray[np.float64]

#: name, parent, place from the parent, where its flesh ends (m; +Y up, +Z ahead), radii at both ends
BONES: tuple[tuple[str, int, tuple[float, float, float], tuple[float, float, float], float, float], ...] = (
    ("hips", -1, (0.0, 0.96, 0.0), (0.0, 0.12, 0.0), 0.135, 0.12),
    ("spine", 0, (0.0, 0.12, 0.0), (0.0, 0.18, 0.0), 0.115, 0.135),
    ("chest", 1, (0.0, 0.18, 0.0), (0.0, 0.2, 0.0), 0.14, 0.125),
    ("neck", 2, (0.0, 0.24, 0.0), (0.0, 0.08, 0.0), 0.055, 0.05),
    ("head", 3, (0.0, 0.1, 0.0), (0.0, 0.12, 0.02), 0.1, 0.095),
    *(
        bone
        for side, sign, first in (("left", 1.0, 5), ("right", -1.0, 8))
        for bone in (
            (f"{side} upper arm", 2, (sign * 0.19, 0.17, 0.0), (0.0, -0.28, 0.0), 0.058, 0.045),
            (f"{side} lower arm", first, (0.0, -0.28, 0.0), (0.0, -0.25, 0.0), 0.043, 0.034),
            (f"{side} hand", first + 1, (0.0, -0.25, 0.0), (0.0, -0.11, 0.01), 0.038, 0.026),
        )
    ),
    *(
        bone
        for side, sign, first in (("left", 1.0, 11), ("right", -1.0, 14))
        for bone in (
            (f"{side} upper leg", 0, (sign * 0.095, -0.03, 0.0), (0.0, -0.44, 0.0), 0.085, 0.06),
            (f"{side} lower leg", first, (0.0, -0.44, 0.0), (0.0, -0.41, 0.0), 0.058, 0.042),
            (f"{side} foot", first + 1, (0.0, -0.41, 0.0), (0.0, -0.03, 0.15), 0.05, 0.035),
        )
    ),
)
#: seconds of a clip, keys a second, m/s that the figure seems to go at
CLIPS = {"idle": 3.0, "walk": 1.1, "run": 0.7, "wave": 1.2}
RATE = 30.0
SPEEDS = {"walk": 1.4, "run": 3.6}
_X, _Y, _Z = np.eye(3)

ANIMATION = """\
schema = "lucarna.animation/1"
name = "walker"
start = "move"

[params]
speed = { default = 1.4 }   # m/s
waving = { default = 0.0 }  # 0 to 1

[clips.idle]
[clips.walk]
markers = [{ name = "left foot down", time = 0.275 }, { name = "right foot down", time = 0.825 }]
[clips.run]
markers = [{ name = "left foot down", time = 0.175 }, { name = "right foot down", time = 0.525 }]
[clips.wave]

[masks."right arm"]
subtrees = [{ node = "right upper arm" }]
[masks."upper body"]
subtrees = [{ node = "spine", fall_off = 2 }]

[blends.locomotion]
params = ["speed"]
samples = [{ clip = "idle", at = [0.0] }, { clip = "walk", at = [1.4] }, { clip = "run", at = [3.6] }]

[states.move]
blend = "locomotion"

[[layers]]
name = "wave"
clip = "wave"
mask = "right arm"
weight = "waving"

[[tracks]]
name = "body"
blocks = [
  { clip = "walk", start = 0.0, length = 3.3, fade_out = 1.1 },
  { clip = "run", start = 2.2, length = 2.8, fade_in = 1.1, sync = true },
]
[[tracks]]
name = "arm"
mask = "right arm"
blocks = [{ clip = "wave", start = 3.4, length = 1.6, fade_in = 0.3, fade_out = 0.3 }]
"""


def build(lights: int = 0, seed: int = 1) -> SampleScene:
    """Return the figure on its floor; it has no lights and no chance."""
    surroundings = EnvironmentAsset("studio", background="color", background_color=(0.07, 0.08, 0.1))
    sample = SampleScene(SceneAsset("walker", environment=surroundings, look=LookAsset()))
    scene = sample.scene
    scene.nodes.append(NodeAsset("walker"))
    for name, parent, place, *_ in BONES:
        scene.nodes.append(NodeAsset(name, parent + 1, place))
    suit = sample.material("suit", base_color=(0.8, 0.36, 0.1, 1.0), roughness=0.55)
    floor = sample.material("floor", base_color=(0.32, 0.33, 0.35, 1.0), roughness=0.8)
    node = sample.place("body", sample.mesh(body()), suit)
    scene.nodes[node].parent = 0
    scene.nodes[node].joints = list(range(1, len(BONES) + 1))
    sample.place("floor", sample.mesh(box("floor", (-0.8, -0.08, -0.8), (0.8, 0.0, 0.8))), floor)
    turn = quat.multiply(quat.from_axis_angle(_Y, 0.6), quat.from_axis_angle(_X, -0.1))
    x, y, z, w = turn.tolist()
    camera = NodeAsset("camera", -1, (2.0, 1.25, 2.9), (x, y, z, w), camera=CameraAsset(yfov=0.6, znear=0.05))
    scene.active_camera = len(scene.nodes)
    scene.nodes.append(camera)
    for name, seconds in CLIPS.items():
        sample.clips.append(clip(name, seconds))
        scene.clips.append(f"walker.{name}.lanim")
    scene.animation, scene.drive = "walker.animation.toml", "timeline"
    sample.texts["walker.animation.toml"] = ANIMATION
    return sample


def places() -> F8:
    """f8[bones,3]: where the bones are at rest."""
    result = np.zeros((len(BONES), 3))
    for i, (_, parent, place, *_) in enumerate(BONES):
        result[i] = np.asarray(place) + (result[parent] if parent >= 0 else 0.0)
    return result


def body() -> MeshAsset:
    """A round limb about every bone; where it begins half of its skin follows the bone above."""
    patches, joints, weights = Patches(), [], []
    rest = places()
    for bone, (_, parent, _, flesh, first, last) in enumerate(BONES):
        points = limb(rest[bone], np.asarray(flesh), first, last)
        patches.grid(points)
        length = float(np.linalg.norm(flesh))
        along = ((points - rest[bone]) @ np.asarray(flesh) / length**2).reshape(-1)
        own = np.clip(0.5 + along / 0.4, 0.0, 1.0) if parent >= 0 else np.ones(len(along))
        own = own * own * (3.0 - 2.0 * own)
        share = np.rint(own * 65535.0).astype(np.uint16)
        joints.append(np.stack([np.full(len(own), bone), np.full(len(own), max(parent, 0))], axis=1))
        weights.append(np.stack([share, 65535 - share], axis=1))
    mesh = patches.mesh("body")
    mesh.streams["joints"] = np.pad(np.concatenate(joints), ((0, 0), (0, 2))).astype("<u2")
    mesh.streams["weights"] = np.pad(np.concatenate(weights), ((0, 0), (0, 2))).astype("<u2")
    bind = np.tile(np.eye(4, dtype=np.float32), (len(BONES), 1, 1))
    bind[:, :3, 3] = -rest
    mesh.skeleton = Skeleton([b[0] for b in BONES], np.array([b[1] for b in BONES], np.int32), bind)
    return mesh


def limb(start: F8, along: F8, first: float, last: float) -> F8:
    """f8[rings,points,3]: a capsule from `start` to `start + along`, a grid whose outside is that of shapes.Patches."""
    length = float(np.linalg.norm(along))
    down = -along / length
    angle = np.linspace(0.0, 0.5 * np.pi, 5)
    top = [(last * np.sin(a), length + last * np.cos(a)) for a in angle.tolist()]
    sides = [(first + (last - first) * t, length * t) for t in (0.75, 0.5, 0.25)]
    foot = [(first * np.cos(a), -first * np.sin(a)) for a in angle.tolist()]
    radius, height = np.maximum(np.array([*top, *sides, *foot]).T, [[1e-6], [-np.inf]])
    side = np.cross(down, _Z if abs(down[2]) < 0.9 else _X)
    side /= np.linalg.norm(side)
    ahead = np.cross(side, -down)
    turn = np.linspace(0.0, 2.0 * np.pi, 17)
    ring = np.sin(turn)[:, None] * side + np.cos(turn)[:, None] * ahead
    result: F8 = start + radius[:, None, None] * ring - height[:, None, None] * down
    return result


def clip(name: str, seconds: float) -> ClipAsset:
    """The clip of that name: rotations of the bones that it moves, and the way of the hips."""
    times = np.linspace(0.0, seconds, round(seconds * RATE) + 1)
    turns, rise = _POSES[name](2.0 * np.pi * times / seconds)
    channels = []
    for bone, (target, *_) in enumerate(BONES):
        if target in turns:
            values = turns[target].astype(np.float32)
            channels.append(Channel(bone + 1, "rotation", "linear", times.astype(np.float32), values, target))
    if rise is not None:
        way = np.asarray(BONES[0][2]) + np.stack([0.0 * rise, rise, 0.0 * rise], axis=1)
        channels.insert(
            0, Channel(1, "translation", "linear", times.astype(np.float32), way.astype(np.float32), "hips")
        )
    return ClipAsset(name, channels, frame_rate=RATE)


def _bent(about: F8, angle: F8) -> F8:
    return quat.from_axis_angle(about, angle)


def _stride(a: F8, leg: float, knee: float, arm: float, elbow: float, lean: float, bob: float, turn: float) -> _Pose:
    """Legs and arms that swing against each other; knees bend while their leg comes forward."""
    turns = {
        "hips": quat.multiply(_bent(_Y, turn * np.sin(a)), _bent(_X, 0.3 * lean + 0.0 * a)),
        "spine": _bent(_X, 0.4 * lean + 0.0 * a),
        "chest": quat.multiply(_bent(_X, 0.3 * lean + 0.0 * a), _bent(_Y, -1.8 * turn * np.sin(a))),
        "head": _bent(_X, -0.6 * lean + 0.0 * a),
    }
    for side, b, outward in (("left", a, 1.0), ("right", a + np.pi, -1.0)):
        swing = np.sin(b)
        lifted = np.maximum(np.cos(b), 0.0) ** 2  # while it comes forward
        turns[f"{side} upper leg"] = _bent(_X, -leg * swing - 0.25 * leg * lifted - 0.3 * lean)
        turns[f"{side} lower leg"] = _bent(_X, knee * lifted + 0.12)
        turns[f"{side} foot"] = _bent(_X, -0.25 * leg * swing + 0.15 * knee * lifted)
        turns[f"{side} upper arm"] = quat.multiply(_bent(_Z, outward * 0.12 + 0.0 * a), _bent(_X, arm * swing))
        turns[f"{side} lower arm"] = _bent(_X, -elbow - 0.3 * arm * np.maximum(-swing, 0.0))
    return turns, -0.5 * bob * (1.0 - np.cos(2.0 * a)) - 0.03 * leg


def _idle(a: F8) -> _Pose:
    breath = np.sin(a)
    turns = {
        "spine": _bent(_X, 0.015 * breath),
        "chest": _bent(_X, 0.02 * breath),
        "head": quat.multiply(_bent(_Y, 0.12 * np.sin(a)), _bent(_X, -0.02 * breath)),
    }
    for side, outward in (("left", 1.0), ("right", -1.0)):
        turns[f"{side} upper arm"] = _bent(_Z, outward * (0.14 + 0.015 * breath))
        turns[f"{side} lower arm"] = _bent(_X, -0.15 + 0.0 * a)
        for part in ("upper leg", "lower leg", "foot"):
            turns[f"{side} {part}"] = _bent(_X, 0.0 * a)
    turns["hips"] = _bent(_X, 0.0 * a)
    return turns, 0.006 * breath


def _wave(a: F8) -> _Pose:
    return {
        "right upper arm": _bent(_Z, -2.1 + 0.08 * np.sin(a)),
        "right lower arm": _bent(_Z, -0.55 + 0.45 * np.sin(2.0 * a)),
        "right hand": _bent(_Z, 0.25 * np.sin(2.0 * a - 0.6)),
    }, None


_Pose = tuple[dict[str, F8], F8 | None]
_POSES = {
    "idle": _idle,
    "walk": lambda a: _stride(a, 0.5, 0.95, 0.45, 0.25, 0.05, 0.035, 0.08),
    "run": lambda a: _stride(a, 0.85, 1.75, 0.9, 1.45, 0.28, 0.07, 0.14),
    "wave": _wave,
}
