"""ClipDeck: what poses a scene: some of its clips, or an animation file's timeline or states instead."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation import poses
from engine.animation.animator import Animator
from engine.animation.clock import MODES, wrap
from engine.animation.events import Fired
from engine.animation.morph import WeightPlayer
from engine.animation.sample import ClipPlayer
from engine.animation.sequence import Sequence as ClipSequence
from engine.animation.sequence import write_columns
from engine.assets.clip import ClipAsset
from engine.assets.records import did_you_mean
from engine.core.errors import InputError
from engine.math import quat
from engine.scene.copies import PATHS, Copies, OwnPlaces
from engine.scene.morphs import MorphTable
from engine.scene.nodes import NodeTable

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]
POSE_PARTS = (poses.T, poses.R, poses.S)
NO_ROWS: I8 = np.zeros((0, 0), np.int64)


class ClipDeck:
    """`clips` and their `players`; `active`: the numbers of those that play, the first one to begin with.

    `fired`: the markers that the last `apply` passed, where an animator plays. `asleep`: how many of those that play
    the last `apply` did not sample, since nobody saw what they move.
    """

    def __init__(
        self, nodes: NodeTable, clips: list[ClipAsset], players: list[ClipPlayer],
        morphs: MorphTable | None = None, node_rows: ArrayLike = (),
    ) -> None:  # fmt: skip
        self.clips, self.players = clips, players
        self.morph_players: list[WeightPlayer] = (
            [WeightPlayer(clip, node_rows, morphs) for clip in clips] if morphs is not None else []
        )
        self.active: list[int] = [0] if players else []
        self.mode, self.speed = "loop", 1.0
        self.animator: Animator | None = None
        self.sequence: ClipSequence | None = None
        self.root_motion = True
        self.fired = Fired()
        self.asleep = 0
        self._copies = Copies()
        #: where those copies stand that have a place of their own
        self.places = OwnPlaces(nodes)
        self._rows: I8 = NO_ROWS
        self._top = -1
        self._nodes, self._morphs = nodes, morphs
        self._generation = nodes.generation.copy()
        self._rest = (nodes.translation.copy(), nodes.rotation.copy(), nodes.scale.copy())
        self._time = 0.0
        #: clip name -> number
        self._numbers = {clip.name: i for i, clip in enumerate(clips)}

    def join(self, clip: ClipAsset, player: ClipPlayer, node_rows: ArrayLike) -> int:
        """Take up a clip more, bound to the nodes that now stand in `node_rows`; returns its number."""
        player.meet(self._nodes)
        self.clips.append(clip)
        self.players.append(player)
        if self._morphs is not None:
            self.morph_players.append(WeightPlayer(clip, node_rows, self._morphs))
        self._numbers.setdefault(clip.name, len(self.clips) - 1)
        return len(self.clips) - 1

    def meet(self, rows: I8) -> None:
        """Nodes that came since the scene was opened stand in `rows` as they rest: they may be posed from now on."""
        nodes, known = self._nodes, len(self._generation)
        columns = (nodes.translation, nodes.rotation, nodes.scale)
        places, turns, sizes = (np.concatenate([a, b[known:]]) for a, b in zip(self._rest, columns, strict=True))
        self._rest = places, turns, sizes
        self._generation = np.append(self._generation, nodes.generation[known:])
        for rest, column in zip(self._rest, columns, strict=True):
            rest[rows] = column[rows]
        self._generation[rows] = nodes.generation[rows]
        self._rows = np.where(np.isin(self._rows, rows), -1, self._rows)  # they held other nodes

    @property
    def posed(self) -> I8:
        """The rows that the animator or the timeline moves, where one plays."""
        source = self.sequence if self.animator is None else self.animator
        if source is None:
            return np.zeros(0, np.int64)
        return np.unique(self._rows[0][source.covers().any(axis=0)])

    @property
    def copies(self) -> Copies:
        """The nodes that are posed as others are."""
        return self._copies

    @copies.setter
    def copies(self, copies: Copies) -> None:
        self._copies = copies
        self.places.adopt(copies)

    @property
    def time(self) -> float:
        """What `apply` was last given."""
        return self._time

    @property
    def duration(self) -> float:
        """Seconds of the longest clip that plays, of the timeline where one does; 0 where nothing plays."""
        if self.sequence is not None:
            return self.sequence.duration
        return max((self.clips[i].duration for i in self.active), default=0.0)

    @property
    def playing(self) -> int:
        """How many clips play; an animator or a timeline is one."""
        return len(self.active) + int(self.animator is not None or self.sequence is not None)

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

        What only the clips before have moved goes back to where it stood when the scene was opened. An animator or a
        timeline is taken off. Raises InputError for an unknown clip or mode, or a speed that is not finite.
        """
        chosen = [self.find(clip) for clip in clips]
        if mode not in MODES:
            raise InputError(f"unknown play mode {mode!r}", hint=f"choose one of {', '.join(MODES)}")
        if not np.isfinite(speed):
            raise InputError(f"a speed of {speed}")
        self.rest()
        self.active, self.mode, self.speed = chosen, mode, float(speed)
        self.animator = self.sequence = None

    def animate(self, animator: Animator, rows: I8, top: int = -1) -> None:
        """Let `animator`, of one character, pose the scene: `rows` i8[1,n] as for Animator.write. Time starts where it
        is. `top`: the row, a root of the scene, that root motion carries."""
        self.rest()
        self.animator, self.sequence, self._rows, self._top, self.active = animator, None, rows, top, []

    def follow(self, sequence: ClipSequence, rows: I8, top: int = -1) -> None:
        """Let a timeline pose the scene; `rows` and `top` as for `animate`."""
        self.rest()
        self.animator, self.sequence, self._rows, self._top, self.active = None, sequence, rows, top, []

    def apply(self, time_s: float, visible: NDArray[np.bool_] | None = None, seers: Seers | None = None) -> None:
        """Pose the nodes at `time_s`; an animator goes on (or back) by what time has passed since the last call.

        With `visible` bool[instances] and `seers`, what only moves instances that are not visible is not sampled: time,
        markers and root motion go on all the same."""
        passed, self._time = time_s - self._time, time_s
        self.asleep = 0
        if self.animator is not None:
            awake = seers is None or visible is None or seers.sees(self._with_copies(self._rows), visible)
            self.asleep = int(not awake)
            self.fired = self.animator.update(passed, None if awake else np.zeros(len(self.animator), np.bool_))
            if awake:
                self.animator.write(self._nodes, np.where(self._living(self._rows), self._rows, -1))
                self._repeat(self.animator.poses[:, 0], self.animator.covers())
                self._weigh(self._heard())
            self._carry(self.animator.travel[0])
        elif self.sequence is not None:
            if seers is None or visible is None or seers.sees(self._with_copies(self._rows), visible):
                self._follow(self.sequence, time_s)
            else:
                self.asleep = 1
            self._carry(self.sequence.way([time_s])[0])
        for number in self.active:  # beside an animator or a timeline what those leave alone
            player = self.players[number]
            if seers is None or visible is None or seers.sees(self._with_copies(player.node_rows), visible):
                self._play(number, time_s * self.speed)
            else:
                self.asleep += 1

    def jump(self, time_s: float) -> None:
        """Let the next `apply` begin at `time_s`: an animator is that far into its state, and has passed nothing."""
        self._time = time_s
        if self.animator is not None:
            self.animator.seek(time_s)

    def rest(self) -> None:
        """Put back what the present players have moved."""
        self._rest_rows(self._moved())
        if self._morphs is not None and len(self._morphs):
            playing = range(len(self.clips)) if self.animator or self.sequence else self.active
            numbers = [self.morph_players[i].numbers for i in playing]
            moved = np.unique(np.concatenate(numbers)) if numbers else np.zeros(0, np.int64)
            self._morphs.set(moved, self._morphs.rest[moved])

    # -- inside -------------------------------------------------------------------------------------------------------

    def _play(self, number: int, time: float) -> None:
        player = self.players[number]
        weights = self.morph_players[number] if self.morph_players else None
        if weights is None or self._morphs is None or not len(weights.numbers):
            player.apply(self._nodes, time, self.mode, self.copies, self.places)
            return
        # one time for transforms and weights, whichever ends first
        length = max(player.duration, weights.duration)
        player.apply(self._nodes, wrap(time, length, self.mode), "once", self.copies, self.places)
        self._morphs.set(weights.numbers, weights.sample(wrap(time, length, self.mode)))
        self._repeat_weights(weights.numbers)

    def _follow(self, sequence: ClipSequence, time: float) -> None:
        pose = sequence.pose([time])
        rows = np.where(self._living(self._rows), self._rows, -1)[0]
        setters = (self._nodes.set_translation, self._nodes.set_rotation, self._nodes.set_scale)
        for (part, columns), setter in zip(write_columns(sequence.covers()), setters, strict=True):
            columns = columns[rows[columns] >= 0]
            if len(columns):
                setter(rows[columns], pose[part, 0, columns].T)
        self._repeat(pose[:, 0], sequence.covers())
        heard = [
            (sequence.clips[sequence.tracks[i].blocks[j].clip].sampler.name, clip_time, level)
            for i, j, level, clip_time in sequence.audible([time])
        ]
        self._weigh(heard)

    def _heard(self) -> list[tuple[str, float, float]]:
        """(clip, seconds, weight) of what the animator's first character blends."""
        assert self.animator is not None
        heard = self.animator.heard
        found = []
        for i in np.flatnonzero(heard.character == 0).tolist():
            sampler = self.animator.graph.clips[int(heard.clip[i])].sampler
            found.append((sampler.name, float(heard.phase[i]) * sampler.duration, float(heard.weight[i])))
        return found

    def _weigh(self, heard: Sequence[tuple[str, float, float]]) -> None:
        """Blend the morph weights of several clips; where their levels do not reach 1 the rest shows through."""
        morphs = self._morphs
        if morphs is None or not len(morphs) or not any(len(p.numbers) for p in self.morph_players):
            return
        total, level = np.zeros(len(morphs.weights)), np.zeros(len(morphs.weights))
        touched = np.zeros(len(morphs.weights), np.bool_)
        for player in self.morph_players:
            touched[player.numbers] = True
        for name, time, weight in heard:
            player = self.morph_players[self._numbers[name]]
            total[player.numbers] += weight * player.sample(time)
            level[player.numbers] += weight
        mixed = total / np.maximum(level, 1.0) + morphs.rest * np.maximum(1.0 - level, 0.0)
        morphs.set(np.flatnonzero(touched), mixed[touched])
        self._repeat_weights(np.flatnonzero(touched))

    def _repeat(self, pose: F8, covers: NDArray[np.bool_]) -> None:
        """Give copies of the rig's nodes the `pose` f8[10,rig nodes], where something moves it."""
        if not len(self.copies):
            return
        for path, part, moved in zip(PATHS, POSE_PARTS, covers, strict=True):
            self.places.write(self.copies, path, self._rows[0][moved], pose[part][:, moved].T)
        which, to = self.copies.moving.repeat(self._rows[0])
        setters = (self._nodes.set_translation, self._nodes.set_rotation, self._nodes.set_scale)
        for part, moved, setter in zip(POSE_PARTS, covers, setters, strict=True):
            some = moved[which]
            if some.any():
                setter(to[some], pose[part][:, which[some]].T)

    def _repeat_weights(self, numbers: I8) -> None:
        """Give copies the weights that `numbers` (of the morph table) were just set to."""
        morphs, copies = self._morphs, self.copies
        if morphs is None or not len(copies) or not len(numbers):
            return
        mine = morphs.of_nodes(copies.row)
        for leader, row in zip(copies.leader[mine >= 0], mine[mine >= 0], strict=True):  # those with targets only
            (of_leader,) = np.nonzero(morphs.node == leader)
            lead = int(of_leader[0]) if len(of_leader) else -1  # rows stay, so the first is that of the file
            if lead >= 0 and morphs.count[lead] == morphs.count[row] and morphs.first[lead] in numbers:
                run = np.arange(morphs.count[row])
                morphs.set(morphs.first[row] + run, morphs.weights[morphs.first[lead] + run])

    def _with_copies(self, rows: I8) -> I8:
        return np.append(rows, self.copies.repeat(rows.reshape(-1))[1]) if len(self.copies) else rows

    def _moved(self) -> I8:
        rows = [self.players[i].node_rows for i in self.active]
        if self.animator is not None or self.sequence is not None:
            rows += [self._rows[self._rows >= 0], np.full(int(self._top >= 0), self._top)]
        return np.unique(np.concatenate(rows)) if rows else np.zeros(0, np.int64)

    def _rest_rows(self, rows: I8) -> None:
        self.places.rest()
        which, to = self.copies.moving.repeat(rows)
        if len(to):
            self._nodes.set_trs(to, *(column[rows[which]] for column in self._rest))
        rows = rows[self._living(rows)]
        if len(rows):
            self._nodes.set_trs(rows, *(column[rows] for column in self._rest))

    def _living(self, rows: I8) -> NDArray[np.bool_]:
        """Which rows still hold the nodes that they held when the scene was opened."""
        nodes = self._nodes
        count = min(len(self._generation), len(nodes))  # undoing an addition makes the table shorter
        known = (rows >= 0) & (rows < count)
        safe = np.where(known, rows, 0)
        if count == 0:
            return known
        result: NDArray[np.bool_] = known & nodes.alive[safe] & (nodes.generation[safe] == self._generation[safe])
        return result

    def _carry(self, way: F8) -> None:
        """Put the top node where root motion has carried it: the way since the start, times where it stood."""
        if self._top < 0 or not self._living(np.array([self._top]))[0]:
            return
        x, z, yaw = way if self.root_motion else np.zeros(3)
        turn = quat.from_axis_angle([0.0, 1.0, 0.0], yaw)
        translation, rotation, _ = (column[self._top] for column in self._rest)
        self._nodes.set_translation(self._top, quat.rotate(turn, translation) + np.array([x, 0.0, z]))
        self._nodes.set_rotation(self._top, quat.multiply(turn, rotation))


class Seers:
    """Which instances are placed by which node rows: what has to be visible for a pose to matter."""

    def __init__(self, parent: ArrayLike, instance_node: ArrayLike, joints: Sequence[tuple[int, I8]]) -> None:
        """`parent` i[nodes]; `instance_node` i[instances]; `joints`: (node of a skin, its joints' rows)."""
        self._parent = np.asarray(parent, np.int64)
        self._node = np.asarray(instance_node, np.int64)
        self._joints = joints
        self._known: dict[bytes, NDArray[np.bool_]] = {}

    def sees(self, rows: I8, visible: NDArray[np.bool_]) -> bool:
        """Whether a visible instance hangs on one of `rows`; where none hangs at all, it may be a light or a camera:
        yes."""
        key = rows.tobytes()
        if key not in self._known:
            self._known[key] = self._placed(rows)
        placed = self._known[key]
        if len(placed) != len(visible) or not placed.any():
            return True
        return bool((placed & visible).any())

    def _placed(self, rows: I8) -> NDArray[np.bool_]:
        below = np.zeros(len(self._parent) + 1, np.bool_)
        below[rows[rows >= 0]] = True
        while True:  # a level of the hierarchy a turn
            more = below | np.append(below[self._parent], False)
            more[-1] = False
            if (more == below).all():
                break
            below = more
        skinned = {node: bool(below[joints].any()) for node, joints in self._joints}
        return np.array([skinned.get(int(n), bool(below[n])) if n >= 0 else False for n in self._node], np.bool_)
