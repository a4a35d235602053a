"""The workshop: the document that the sample becomes, its materials by name, its clip; turns as quaternions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sample_glb import Glb
from sample_shapes import Mesh

DURATION = 12.0  # s, every turning part makes whole turns in it
SUN_HEIGHT = 0.36  # m above the floor; the planets circle in this plane
FLOOR_RADIUS = 0.70  # m
PEDESTAL_RADIUS = 0.19  # m
PEDESTAL_HEIGHT = 0.060  # m


@dataclass(slots=True)
class Workshop:
    """The document being made, its materials by name, and the clip's channels."""

    glb: Glb
    materials: dict[str, int] = field(default_factory=dict)
    channels: list[tuple[int, str, NDArray[Any], NDArray[Any]]] = field(default_factory=list)

    def part(self, name: str, mesh: Mesh, material: str, parent: int, **node: Any) -> int:
        """A node with a mesh of one material."""
        return self.glb.add_node(name, parent, mesh=self.mesh(name, mesh, material), **node)

    def mesh(self, name: str, mesh: Mesh, material: str) -> int:
        return self.glb.add_mesh(name, [(mesh, self.materials[material])])

    def spin(self, node: int, axis: Sequence[float], turns: int) -> None:
        """Turn `node` about `axis` (its own frame, after its rest rotation) `turns` times in the loop.

        Keys lie a quarter turn apart, so that the shorter way is always the meant one; signs are continuous."""
        steps = 4 * abs(turns)
        angles = np.linspace(0, math.tau * turns, steps + 1) / 2
        unit = np.array(axis, np.float64) / np.linalg.norm(axis)
        turning = np.concatenate([np.sin(angles)[:, None] * unit, np.cos(angles)[:, None]], 1)
        rest = np.array(self.glb.document["nodes"][node].get("rotation", [0, 0, 0, 1]), np.float64)
        values = multiply(np.broadcast_to(rest, turning.shape), turning)
        values[-1] = values[0] if values[-1] @ values[0] > 0 else -values[0]
        self.channels.append((node, "rotation", np.linspace(0, DURATION, steps + 1), values))


def multiply(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Hamilton product of quaternions xyzw: first b, then a."""
    av, aw, bv, bw = a[:, :3], a[:, 3:], b[:, :3], b[:, 3:]
    return np.concatenate([aw * bv + bw * av + np.cross(av, bv), aw * bw - np.sum(av * bv, 1, keepdims=True)], 1)


def about(axis: str, angle: float) -> list[float]:
    """Quaternion xyzw of a turn about x, y or z."""
    value = [0.0, 0.0, 0.0, math.cos(angle / 2)]
    value["xyz".index(axis)] = math.sin(angle / 2)
    return value


def look_from(eye: Sequence[float], target: Sequence[float]) -> list[float]:
    """Quaternion xyzw that turns -Z towards `target` with +Y up."""
    back = np.array(eye, np.float64) - np.array(target, np.float64)
    yaw = math.atan2(back[0], back[2])
    pitch = -math.atan2(back[1], math.hypot(back[0], back[2]))
    return [float(v) for v in multiply(np.array([about("y", yaw)]), np.array([about("x", pitch)]))[0]]
