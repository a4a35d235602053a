"""Animator: all characters of one rig, a step of time on: states, blends, layers, events, root motion, into nodes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation import mixing, poses
from engine.animation.events import Fired, crossings
from engine.animation.graph import AnimationGraph, LayerUse
from engine.animation.layers import LayerJob
from engine.animation.mixing import Mix
from engine.animation.playhead import Playheads, Step, Who, chosen
from engine.animation.root_motion import RootMotion, extract
from engine.animation.state_machine import FROZEN, NO_FADE, StateMachine
from engine.assets.records import did_you_mean
from engine.core.errors import InputError
from engine.math import quat
from engine.scene.nodes import NodeTable

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]


class Animator:
    """m characters that do what `graph` says. `poses` f8[10,m,n]: where they are now (see poses.py).

    `speed` f8[m] scales each one's time; negative plays back. `travel` f8[m,3]: how far root motion has carried each
    (x, z, yaw), `step` f8[m,3] how far in the last update, in the character's own space then. `above` f8[3,4]: from
    the root's parent to the character's space, at rest. Raises InputError for a graph that does not hold together.
    """

    def __init__(self, graph: AnimationGraph, characters: int = 1, *, above: F8 | None = None) -> None:
        if characters < 0:
            raise InputError(f"{characters} characters")
        self.graph = graph
        self.machine = StateMachine(graph, characters)
        self.poses = poses.resting(graph.rig.rest, characters)
        self.speed: F8 = np.ones(characters)
        self.travel: F8 = np.zeros((characters, 3))
        self.step: F8 = np.zeros((characters, 3))
        self.layer_heads = [Playheads(characters, layer.play) for layer in graph.layers]
        self.ways: list[RootMotion | None] = [
            extract(clip.sampler, graph.root, above) if graph.root >= 0 else None for clip in graph.clips
        ]
        #: names of the markers that Fired.marker counts in
        self.marker_names = graph.marker_names
        self._base = np.zeros_like(self.poses) if graph.layers else self.poses
        self._held: F8 | None = None
        #: what the last update blended, layers apart
        self.heard = mixing.voices([], np.zeros(0), np.zeros(0))
        self._mixer = mixing.Mixer(graph.clips, graph.rig.rest, self.ways)
        self._markers = self._marker_phases()
        self._covers: NDArray[np.bool_] = np.zeros((3, len(graph.rig)), np.bool_)
        for clip in graph.clips:
            self._covers |= clip.sampler.covers
        self._covers_all = bool(self._covers.all())
        self.update(0.0)

    def __len__(self) -> int:
        return len(self.speed)

    # -- steering -----------------------------------------------------------------------------------------------------

    def set(self, param: str, value: ArrayLike, who: Who = slice(None)) -> None:
        """Set a parameter of the characters `who`. Raises InputError for an unknown one."""
        self.machine.set(param, value, who)

    def seek(self, time_s: ArrayLike, who: Who = slice(None)) -> None:
        """Put the characters `who` `time_s` seconds into their states. Nothing in between is passed: no events."""
        where = chosen(who, len(self))
        seconds, _ = self._seconds(self.machine.state)
        at = np.broadcast_to(np.asarray(time_s, np.float64), where.shape)
        length = seconds[where]
        self.machine.heads.seek(np.where(length > 0.0, at / np.where(length > 0.0, length, 1.0), 0.0), where)

    def enter(self, state: str, who: Who = slice(None)) -> None:
        """Put the characters `who` into a state at once, at its start. Raises InputError for an unknown one."""
        names = [s.name for s in self.graph.states]
        if state not in names:
            raise InputError(f"there is no state {state!r}", hint=did_you_mean(state, names))
        where = chosen(who, len(self))
        number = names.index(state)
        self.machine.state[where], self.machine.source[where] = number, NO_FADE
        self.machine.heads.mode[where] = Playheads(1, self.graph.states[number].mode).mode[0]
        self.machine.heads.seek(0.0, where)

    def adopt(self, other: Animator) -> None:
        """Go on where `other`, of an earlier version of the graph, is: parameters, states and layers by their names;
        what is no longer there begins anew. Both have as many characters. Raises InputError otherwise."""
        if len(other) != len(self):
            raise InputError(f"{len(other)} characters go on as {len(self)}")
        for number, param in enumerate(other.graph.params):
            if param.name in [p.name for p in self.graph.params]:
                self.machine.values[self.machine.param(param.name)] = other.machine.values[number]
        names = {s.name: i for i, s in enumerate(self.graph.states)}
        for number, state in enumerate(other.graph.states):
            who = np.flatnonzero(other.machine.state == number)
            if state.name in names and len(who):
                self.enter(state.name, who)
                mode = self.machine.heads.mode.copy()
                self.machine.heads.copy_from(other.machine.heads, who)
                self.machine.heads.mode[who] = mode[who]
        heads = {layer.name: h for layer, h in zip(other.graph.layers, other.layer_heads, strict=True)}
        everyone = np.arange(len(self))
        for layer, mine in zip(self.graph.layers, self.layer_heads, strict=True):
            if layer.name in heads:
                mode = mine.mode.copy()
                mine.copy_from(heads[layer.name], everyone)
                mine.mode[:] = mode
        self.speed[:], self.travel[:] = other.speed, other.travel
        self.update(0.0)

    # -- time ---------------------------------------------------------------------------------------------------------

    def update(self, dt: float, awake: ArrayLike | None = None) -> Fired:
        """Go on by `dt` seconds (negative: back) and pose the characters; returns the markers passed.

        Those not `awake` (bool[m]) are not posed, but their time, events and root motion go on.
        """
        machine = self.machine
        delta = float(dt) * self.speed
        if not np.isfinite(delta).all():
            delta = np.nan_to_num(delta, posinf=0.0, neginf=0.0)
        cut = machine.decide() if self.graph.transitions else None
        if cut is not None and cut.any():
            if self._held is None:
                self._held = np.zeros_like(self.poses)
            self._held[:, cut] = self._base[:, cut]
        seconds, mixes = self._seconds(machine.state)
        fades = bool((machine.source != NO_FADE).any())
        source_seconds, source_mixes = self._seconds(machine.source) if fades else (seconds, [])
        step, source_step = machine.advance(
            delta, self._rates(seconds, machine.state), self._rates(source_seconds, machine.source) if fades else None
        )
        fired = self._events(mixes, step)
        level = machine.weight()
        fading = np.where(machine.source == NO_FADE, 0.0, 1.0 - level) if fades else np.zeros(len(self))
        self._travel([(mixes, step, level), (source_mixes, source_step, fading)])
        who = np.arange(len(self)) if awake is None else np.flatnonzero(np.asarray(awake, np.bool_))
        heard = mixing.together(
            mixing.voices(mixes, machine.heads.fraction, level),
            mixing.voices(source_mixes, machine.source_heads.fraction, fading),
        )
        self.heard = heard
        frozen = np.where(machine.source == FROZEN, fading, 0.0) if fades else None
        if len(who):
            self._mixer.pose(heard, who, self._base, self._held, frozen)
        return fired.joined(self._layers(delta, who))

    def write(self, nodes: NodeTable, rows: I8, *, only: ArrayLike | None = None) -> None:
        """Write the poses to `nodes`: `rows` i8[m,n], the row of each character's rig nodes (-1: none). Properties that
        no clip moves are left as they are. `only` bool[m]: just these characters. Call `nodes.update()` afterwards.
        """
        covers = self.covers()
        if only is None and self._covers_all and rows.size and rows.min() >= 0:
            t, q, s = (self.poses[part].reshape(part.stop - part.start, -1).T for part in (poses.T, poses.R, poses.S))
            nodes.set_trs(rows.reshape(-1), t, q, s)
            return
        who = slice(None) if only is None else np.flatnonzero(np.asarray(only, np.bool_))
        setters = (nodes.set_translation, nodes.set_rotation, nodes.set_scale)
        for path, (part, setter) in enumerate(zip((poses.T, poses.R, poses.S), setters, strict=True)):
            columns = slice(None) if covers[path].all() else np.flatnonzero(covers[path])
            target = rows[who][:, columns].reshape(-1)
            values = self.poses[part][:, who][:, :, columns].reshape(part.stop - part.start, -1).T
            if len(target) and target.min() < 0:
                values, target = values[target >= 0], target[target >= 0]
            if len(target):
                setter(target, values)

    def covers(self) -> NDArray[np.bool_]:
        """bool[3,rig nodes]: the translations, rotations and scales that some clip moves."""
        return self._covers

    def move(self, nodes: NodeTable, rows: I8) -> None:
        """Carry the nodes `rows` i8[m] (the characters' own, one each) by the last update's root motion."""
        turn = quat.from_axis_angle(np.array([0.0, 1.0, 0.0]), self.step[:, 2])
        way = np.stack([self.step[:, 0], np.zeros(len(self)), self.step[:, 1]], axis=1)
        rotation, scale = nodes.rotation[rows], nodes.scale[rows]
        nodes.set_translation(rows, nodes.translation[rows] + quat.rotate(rotation, scale * way))
        nodes.set_rotation(rows, quat.multiply(rotation, turn))

    # -- inside -------------------------------------------------------------------------------------------------------

    def _marker_phases(self) -> list[tuple[F8, I8]]:
        """Per clip its markers' phases and numbers."""
        result, first = [], 0
        for clip in self.graph.clips:
            length = clip.sampler.duration
            times = np.array([m.time for m in clip.markers], np.float64)
            phases = np.minimum(times / length, 1.0) if length > 0.0 else np.zeros(len(times))
            result.append((phases, np.arange(first, first + len(times))))
            first += len(times)
        return result

    def _seconds(self, states: I8) -> tuple[F8, list[Mix]]:
        """How long each character's state lasts, f8[m], and the mixes of those who are in one."""
        seconds = np.zeros(len(self))
        mixes = []
        for number in sorted(set(states.tolist()) - {NO_FADE, FROZEN}):
            m = mixing.mix(self.graph.states[number].motion, np.flatnonzero(states == number), self.machine.values)
            seconds[m.who] = m.seconds(self.graph.clips)
            mixes.append(m)
        return seconds, mixes

    def _rates(self, seconds: F8, states: I8) -> F8:
        speeds = np.array([s.speed for s in self.graph.states])[np.maximum(states, 0)]
        return _per(speeds, seconds)

    def _events(self, mixes: Sequence[Mix], step: Step) -> Fired:
        """Of blended clips the one with the greatest share is heard: its markers count."""
        if not self.marker_names:
            return Fired()
        found = []
        for m in mixes:
            loudest = np.argmax(m.shares, axis=0)
            for row, clip in enumerate(m.motion.clips):
                phases, numbers = self._markers[clip]
                who = m.who[loudest == row] if len(numbers) else m.who[:0]
                if len(who):
                    found.append(crossings(step.part(who), phases, numbers, who))
        return Fired().joined(found)

    def _travel(self, parts: Sequence[tuple[list[Mix], Step, F8]]) -> None:
        if self.graph.root < 0:
            return
        step = np.zeros((3, len(self)))
        for mixes, moved, level in parts:
            for m in mixes:
                for row, clip in enumerate(m.motion.clips):
                    way = self.ways[clip]
                    assert way is not None
                    step[:, m.who] += m.shares[row] * level[m.who] * way.travel(moved.part(m.who))
        self.step = step.T
        yaw = self.travel[:, 2]
        cosine, sine = np.cos(yaw), np.sin(yaw)
        x, z, turn = step
        self.travel = self.travel + np.stack([cosine * x + sine * z, cosine * z - sine * x, turn], axis=1)

    def _layers(self, delta: F8, who: I8) -> list[Fired]:
        if not self.graph.layers:
            return []
        if len(who):
            self.poses[:, who] = self._base[:, who]
        pairs = zip(self.graph.layers, self.layer_heads, strict=True)
        return [self._layer(layer, heads, delta, who) for layer, heads in pairs]

    def _layer(self, layer: LayerUse, heads: Playheads, delta: F8, who: I8) -> Fired:
        everyone = np.arange(len(self))
        m = mixing.mix(layer.motion, everyone, self.machine.values)
        step = heads.advance(delta * _per(np.full(len(self), layer.speed), m.seconds(self.graph.clips)))
        weight = np.full(len(self), layer.constant) if layer.weight < 0 else self.machine.values[layer.weight]
        audible = who[weight[who] != 0.0]
        if len(audible):
            over = np.zeros_like(self.poses)
            self._mixer.pose(mixing.voices([m], heads.fraction, np.ones(len(self))), audible, over)
            job = LayerJob(
                self.poses[:, audible], over[:, audible], weight[audible], layer.mask, layer.mode, layer.reference
            )
            job.run()
            self.poses[:, audible] = job.base
        return self._events([m], step)


def _per(speeds: F8, seconds: F8) -> F8:
    """Phases a second; 0 where one run takes no time."""
    return np.where(seconds > 0.0, speeds / np.where(seconds > 0.0, seconds, 1.0), 0.0)
