"""Root motion: how far a clip carries the character, taken out of the pose and given to the character instead.

The character's way is planar: x, z and the turn about +Y of the root, in the space above the rig at rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.animation import poses
from engine.animation.playhead import PING_PONG, Step
from engine.animation.poses import R, T
from engine.animation.sampler import ClipSampler
from engine.core.errors import InputError
from engine.math import quat

F8 = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class RootMotion:
    """The way of rig node `root` through one clip: `phases` f8[k], `points` f8[k,3] metres (to be drawn),
    `yaw` f8[k] radians, unwrapped. `above` f8[3,3] and `below`, its inverse: the linear part of what lies above the
    root; `offset` f8[3] where that stands."""

    root: int
    duration: float
    phases: F8
    points: F8
    yaw: F8
    above: F8
    below: F8
    offset: F8

    def at(self, phase: F8) -> F8:
        """f8[3,m]: x, z, yaw at phases in [0,1]."""
        columns = (self.points[:, 0], self.points[:, 2], self.yaw)
        return np.stack([np.interp(phase, self.phases, column) for column in columns])

    def travel(self, step: Step) -> F8:
        """f8[3,m]: x, z (metres) and yaw (radians) that each character went, in the space it had before the step.

        Whole turns of a loop are put together in closed form, so 100 times the speed costs the same. A ping-pong's
        turns cancel out.
        """
        there = step.mode == PING_PONG
        start = self._carried(_folded(step.phase0, there))
        end = self._carried(_folded(step.phase1, there))
        turns = np.where(there, 0, step.turn1 - step.turn0).astype(np.float64)
        way = _compose(_inverse(start), _repeat(self._carried(np.ones(1)), turns))
        place, yaw = _compose(way, end)
        return np.stack([place.real, -place.imag, yaw])

    def _carried(self, phase: F8) -> tuple[NDArray[np.complex128], F8]:
        """The planar motion that takes the root from where the clip starts to where it is: none at phase 0."""
        here, start = self.at(phase), self.at(np.zeros(1))
        turn = here[2] - start[2]
        return (here[0] - 1j * here[1]) - np.exp(1j * turn) * (start[0] - 1j * start[1]), turn

    def take_out(self, phase: F8, out: F8) -> None:
        """Put the root of the poses f8[10,m,n], sampled at `phase` f8[m], back to where the clip starts."""
        here, start = self.at(phase), self.at(np.zeros(1))
        turn = start[2] - here[2]
        place = self.above @ out[T, :, self.root] + self.offset[:, None]
        x, z = place[0] - here[0], place[2] - here[1]
        cosine, sine = np.cos(turn), np.sin(turn)
        place[0] = start[0] + cosine * x + sine * z
        place[2] = start[1] - sine * x + cosine * z
        out[T, :, self.root] = self.below @ (place - self.offset[:, None])
        axis = self.below @ np.array([0.0, 1.0, 0.0])
        q = quat.from_axis_angle(np.broadcast_to(axis, (len(turn), 3)), turn).T
        out[R, :, self.root] = poses.multiply(q, out[R, :, self.root])


def extract(sampler: ClipSampler, root: int, above: F8 | None = None, *, rate: float = 60.0) -> RootMotion:
    """The way of `root` through the clip, at its start, its end and `rate` samples a second between.

    `above` f8[3,4]: world from the root's parent, at rest (identity without). Raises InputError for a
    root that does not exist, or an `above` that cannot be inverted.
    """
    rig = sampler.rig
    if not 0 <= root < len(rig):
        raise InputError(f"root {root} of a rig of {len(rig)} nodes")
    whole = np.eye(3, 4) if above is None else np.asarray(above, np.float64)
    linear, offset = whole[:, :3], whole[:, 3]
    sizes = np.linalg.svd(linear, compute_uv=False)
    if not sizes[2] > 1e-7 * sizes[0]:
        raise InputError("the root's parent is flattened by its scale: no way can be taken out")
    count = max(2, min(int(np.ceil(sampler.duration * rate)) + 1, 1_000_000))
    phases = np.linspace(0.0, 1.0, count)
    out = poses.resting(rig.rest, count)
    sampler.sample(phases * sampler.duration, out)
    points = (linear @ out[T, :, root] + offset[:, None]).T
    # the turn about +Y is what remains of the rotation when its axis is laid on +Y (swing-twist)
    axis = np.linalg.inv(linear) @ np.array([0.0, 1.0, 0.0])
    axis /= np.linalg.norm(axis)
    q = out[R, :, root]
    half = np.arctan2(axis @ q[:3], q[3])
    yaw = 2.0 * np.unwrap(half, period=np.pi) if count > 1 else 2.0 * half
    below = np.asarray(np.linalg.inv(linear), np.float64)
    return RootMotion(root, sampler.duration, phases, points, yaw, linear, below, offset)


def _folded(phase: F8, there: NDArray[np.bool_]) -> F8:
    return np.where(there & (phase > 1.0), 2.0 - phase, phase)


# A planar motion is z -> e^(i yaw) z + place with z = x - i z_axis: a turn about +Y takes +Z towards +X.


def _compose(
    a: tuple[NDArray[np.complex128], F8], b: tuple[NDArray[np.complex128], F8]
) -> tuple[NDArray[np.complex128], F8]:
    """First b, then a."""
    return a[0] + np.exp(1j * a[1]) * b[0], a[1] + b[1]


def _inverse(a: tuple[NDArray[np.complex128], F8]) -> tuple[NDArray[np.complex128], F8]:
    return -np.exp(-1j * a[1]) * a[0], -a[1]


def _repeat(a: tuple[NDArray[np.complex128], F8], times: F8) -> tuple[NDArray[np.complex128], F8]:
    """a, `times` times over: the geometric series place (1 - e^(i yaw k)) / (1 - e^(i yaw))."""
    place, yaw = a
    # (1 - e^(i k y)) / (1 - e^(i y)) = e^(i (k - 1) y / 2) sin(k y / 2) / sin(y / 2)
    half = np.sin(yaw / 2.0)
    ratio = np.where(np.abs(half) > 1e-12, np.sin(times * yaw / 2.0) / np.where(half == 0.0, 1.0, half), times)
    return place * np.exp(0.5j * (times - 1.0) * yaw) * ratio, yaw * times
