"""Many lights at once: light nodes with colours by hue, and one clip that moves them all (no code runs per light)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.clip import Channel, ClipAsset
from engine.assets.scene import LightAsset, NodeAsset, SceneAsset

F8 = NDArray[np.float64]

#: seconds of the loop, and keys in it (the last one repeats the first)
DURATION, KEYS = 16.0, 33
#: turns -Z, where lights shine, down to -Y
DOWN = (-(0.5**0.5), 0.0, 0.0, 0.5**0.5)


@dataclass(slots=True)
class Swarm:
    """Lights of one kind: `position` f8[n,3] at rest; `path` f8[KEYS,n,3] where they move, else None; `rotation`
    f8[KEYS,n,4] where they turn; `color` f8[n,3] scene-linear; `like`: what all have in common."""

    name: str
    like: LightAsset
    position: F8
    color: F8
    path: F8 | None = None
    rotation: F8 | None = None


def phases() -> F8:
    """Return f8[KEYS,1]: 0 to 2 pi over the loop."""
    result: F8 = np.linspace(0.0, 2.0 * np.pi, KEYS)[:, None]
    return result


def swinging(yaw: ArrayLike, swing: ArrayLike, phase: ArrayLike) -> F8:
    """Return rotations f8[KEYS,n,4] of lights that look down and swing by `swing` (rad) across the direction `yaw`."""
    yaw, swing, phase = np.broadcast_arrays(*(np.atleast_1d(np.asarray(v, np.float64)) for v in (yaw, swing, phase)))
    pitch = -np.pi / 2 + swing * np.sin(phases() + phase)
    x, w = np.sin(pitch / 2), np.cos(pitch / 2)
    s, c = np.sin(yaw / 2), np.cos(yaw / 2)
    # yaw about Y after pitch about X: (0, s, 0, c) * (x, 0, 0, w)
    result: F8 = np.stack([c * x, s * w, -s * x, c * w], axis=-1)
    return result


def hues(rng: np.random.Generator, count: int, saturation: float = 0.75) -> F8:
    """Return `count` linear colours f8[n,3] of all hues, brightest channel 1."""
    turn = rng.random(count)[:, None]
    pure = np.clip(np.abs((turn * 6.0 + np.array([0.0, 4.0, 2.0])) % 6.0 - 3.0) - 1.0, 0.0, 1.0)
    result: F8 = 1.0 - saturation + saturation * pure
    return result


def add_swarm(scene: SceneAsset, clip: ClipAsset, swarm: Swarm, parent: int) -> None:
    """Add the nodes and, where they move, their channels. Loops over lights here, once; playing does not."""
    times = np.linspace(0.0, DURATION, KEYS).astype(np.float32)
    positions, colors = swarm.position.tolist(), swarm.color.tolist()
    start = swarm.rotation[0].tolist() if swarm.rotation is not None else None
    like = swarm.like
    for i, ((x, y, z), (r, g, b)) in enumerate(zip(positions, colors, strict=True)):
        node = NodeAsset(f"{swarm.name} {i + 1}", parent, (x, y, z))
        node.light = replace(like, color=(r, g, b))
        if start is not None:
            node.rotation = tuple(start[i])
        elif like.type != "point":
            node.rotation = DOWN
        index = len(scene.nodes)
        scene.nodes.append(node)
        for path, values in (("translation", swarm.path), ("rotation", swarm.rotation)):
            if values is not None:
                keys = np.ascontiguousarray(values[:, i], np.float32)
                clip.channels.append(Channel(index, path, "linear", times, keys, node.name))
