"""ClipDeck: which of a scene's clips are playing, or the animator that plays them instead."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.animation.animator import Animator
from engine.animation.clock import MODES
from engine.animation.events import Fired
from engine.animation.sample import ClipPlayer
from engine.assets.clip import ClipAsset
from engine.assets.records import did_you_mean
from engine.core.errors import InputError
from engine.math import quat
from engine.scene.nodes import NodeTable

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]


class ClipDeck:
    """`clips` and their `players`; `active`: the numbers of those that play, the first one to begin with.

    `fired`: the markers that the last `apply` passed, where an animator plays.
    """

    def __init__(self, nodes: NodeTable, clips: Sequence[ClipAsset], players: Sequence[ClipPlayer]) -> None:
        self.clips, self.players = clips, players
        self.active: list[int] = [0] if players else []
        self.mode, self.speed = "loop", 1.0
        self.animator: Animator | None = None
        self.fired = Fired()
        self._rows: I8 = np.zeros((0, 0), np.int64)
        self._top = -1
        self._nodes = nodes
        self._generation = nodes.generation.copy()
        self._rest = (nodes.translation.copy(), nodes.rotation.copy(), nodes.scale.copy())
        self._time = 0.0

    @property
    def duration(self) -> float:
        """Seconds of the longest clip that plays; 0 where none does."""
        return max((self.clips[i].duration for i in self.active), default=0.0)

    def find(self, clip: int | str) -> int:
        """The number of a clip given by number or name. Raises InputError with what was perhaps meant."""
        names = [c.name for c in self.clips]
        if isinstance(clip, str) and clip in names:
            return names.index(clip)
        if isinstance(clip, int) and 0 <= clip < len(names):
            return clip
        hint = did_you_mean(clip, names) if isinstance(clip, str) else ""
        raise InputError(f"there is no clip {clip!r}", hint=hint or f"clips: {', '.join(names) or 'none'}")

    def play(self, *clips: int | str, mode: str = "loop", speed: float = 1.0) -> None:
        """Play these clips, the later over the earlier where they move the same; none: everything rests.

        What only the clips before have moved goes back to where it stood when the scene was opened. An animator is
        taken off. Raises InputError for an unknown clip or mode, or a speed that is not finite.
        """
        chosen = [self.find(clip) for clip in clips]
        if mode not in MODES:
            raise InputError(f"unknown play mode {mode!r}", hint=f"choose one of {', '.join(MODES)}")
        if not np.isfinite(speed):
            raise InputError(f"a speed of {speed}")
        self._rest_rows(self._moved())
        self.active, self.mode, self.speed, self.animator = chosen, mode, float(speed), None

    def animate(self, animator: Animator, rows: I8, top: int = -1) -> None:
        """Let `animator`, of one character, pose the scene: `rows` i8[1,n] as for Animator.write. Time starts where it
        is. `top`: the row, a root of the scene, that root motion carries."""
        self._rest_rows(self._moved())
        self.animator, self._rows, self._top, self.active = animator, rows, top, []

    def apply(self, time_s: float) -> None:
        """Pose the nodes at `time_s`; an animator goes on (or back) by what time has passed since the last call."""
        passed, self._time = time_s - self._time, time_s
        if self.animator is not None:
            self.fired = self.animator.update(passed)
            self.animator.write(self._nodes, np.where(self._living(self._rows), self._rows, -1))
            self._carry(self.animator)
            return
        for number in self.active:
            self.players[number].apply(self._nodes, time_s * self.speed, self.mode)

    def _moved(self) -> I8:
        rows = [self.players[i].node_rows for i in self.active]
        if self.animator is not None:
            rows += [self._rows[self._rows >= 0], np.full(int(self._top >= 0), self._top)]
        return np.unique(np.concatenate(rows)) if rows else np.zeros(0, np.int64)

    def _rest_rows(self, rows: I8) -> None:
        rows = rows[self._living(rows)]
        if len(rows):
            self._nodes.set_trs(rows, *(column[rows] for column in self._rest))

    def _living(self, rows: I8) -> NDArray[np.bool_]:
        """Which rows still hold the nodes that they held when the scene was opened."""
        nodes = self._nodes
        known = (rows >= 0) & (rows < len(self._generation))
        safe = np.where(known, rows, 0)
        if len(self._generation) == 0:
            return known
        result: NDArray[np.bool_] = known & nodes.alive[safe] & (nodes.generation[safe] == self._generation[safe])
        return result

    def _carry(self, animator: Animator) -> None:
        """Put the top node where root motion has carried it: the way since the start, times where it stood."""
        if self._top < 0 or not self._living(np.array([self._top]))[0]:
            return
        x, z, yaw = animator.travel[0]
        turn = quat.from_axis_angle([0.0, 1.0, 0.0], yaw)
        translation, rotation, _ = (column[self._top] for column in self._rest)
        self._nodes.set_translation(self._top, quat.rotate(turn, translation) + np.array([x, 0.0, z]))
        self._nodes.set_rotation(self._top, quat.multiply(turn, rotation))
