"""Clips of prefabs on the instances that stand in an open scene.

    scene.sources ─► standing: prefab -> its instances' nodes by key ─┬► a prefab that is new: its clips join the deck,
                     (whenever the structure changed)                 │    led by the first instance
                                                                      ├► the other instances: copies of that one
                                                                      └► one of which none stands: its clips rest

A scene that opens plays, beside its own, what each prefab plays that is opened itself: its animation file, which has a
deck of its own (instance_animation.py), or its first clip. A clip that is chosen plays instead; what the scene's own
timeline or states move is theirs; the rest of the instances play on.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.animation.sample import ClipPlayer
from engine.app.clip_deck import Seers
from engine.app.instance_animation import InstanceAnimation, instance_animation
from engine.assets.prefab import NODE, file_of
from engine.assets.prefab_clips import PrefabClips, prefab_clips
from engine.assets.scene import NodeAsset
from engine.core.errors import InputError
from engine.scene.copies import Copies
from engine.scene.drift import DRIFT
from engine.scene.scene import Scene

if TYPE_CHECKING:
    from engine.app.runtime import Runtime

I8 = NDArray[np.int64]


def standing(scene: Scene, folder: Path) -> dict[Path, list[tuple[int, dict[str, int]]]]:
    """Prefab -> its instances in the scene, as (row, rows of the nodes that came with it by their keys)."""
    sources = scene.sources
    roots = {row: source for row, source in sources.items() if file_of(source) and NODE not in source.extras}
    if not roots:
        return {}
    parent = scene.nodes.parent.tolist()
    home: dict[int, int] = {row: row for row in roots}
    rows: dict[int, dict[str, int]] = {row: {} for row in roots}
    for row in sorted(sources):
        key = sources[row].extras.get(NODE)
        if not isinstance(key, str):
            continue
        chain, above = [], row
        while above >= 0 and above not in home:
            chain.append(above)
            above = parent[above]
        found = home.get(above, -1)
        home.update(dict.fromkeys(chain, found))
        if found >= 0:
            rows[found].setdefault(key, row)
    instances: dict[Path, list[tuple[int, dict[str, int]]]] = {}
    for row in sorted(roots):
        path = Path(os.path.normpath((folder / file_of(roots[row])).absolute()))
        instances.setdefault(path, []).append((row, rows[row]))
    return instances


@dataclass(slots=True)
class _Cast:
    """`numbers`: of the prefab's clips in the deck; `leader`: key -> row of the nodes that they are bound to, and
    `generation` of each: others may stand there by now; `rested`: those that played when the last instance went, None
    while one stands. `firsts`: those that play when the scene is opened, beside `animation`, unless that is `quiet`."""

    numbers: list[int] = field(default_factory=list)
    leader: dict[str, int] = field(default_factory=dict)
    generation: dict[int, int] = field(default_factory=dict)
    rested: list[int] | None = None
    firsts: list[int] = field(default_factory=list)
    animation: InstanceAnimation | None = None
    quiet: bool = False
    copies: Copies = field(default_factory=Copies)


class InstanceClips:
    """`copies`: the nodes that move as the first instance's. `driven`: all rows that clips of prefabs move."""

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._casts: dict[Path, _Cast] = {}
        self._taken: frozenset[int] = frozenset()
        self.copies = Copies()
        self.driven: frozenset[int] = frozenset()

    def prefab_of(self, number: int) -> Path | None:
        """Whose clip that is; None: the scene's own."""
        return next((path for path, cast in self._casts.items() if number in cast.numbers), None)

    def stands(self, number: int) -> bool:
        """Whether there is anybody to play that clip."""
        return all(cast.rested is None for cast in self._casts.values() if number in cast.numbers)

    def follow(self) -> None:
        """After the structure changed: who plays what."""
        scene, deck = self._runtime.scene, self._runtime.deck
        found = standing(scene, scene.folder or Path())
        for path in found:
            if path not in self._casts:
                self._casts[path] = self._join(path, found[path])
        generation = scene.nodes.generation
        everybody: list[tuple[int, int]] = []
        driven: set[int] = set()
        for path, cast in self._casts.items():
            if path not in found and cast.rested is None:
                cast.rested = [n for n in deck.active if n in cast.numbers]
                deck.active = [n for n in deck.active if n not in cast.numbers]
            elif path in found and cast.rested is not None:
                deck.active, cast.rested = [*deck.active, *cast.rested], None
            pairs: list[tuple[int, int]] = []
            for _row, rows in found.get(path, ()):
                mine = [(cast.leader[key], row) for key, row in rows.items() if key in cast.leader]
                pairs += [p for p in mine if p[0] != p[1] or generation[p[1]] != cast.generation[p[0]]]
                driven.update(row for _leader, row in mine)
            cast.copies = _copies(pairs)
            everybody += pairs
        self.copies = _copies(everybody)
        self.driven = frozenset(driven)

    def beside(self, moved: I8) -> list[int]:
        """Of each prefab what plays at first; from now on the rows `moved` belong to somebody else, who takes off
        whatever would move one of them, too."""
        self._taken, chosen = frozenset(moved.tolist()), []
        for cast in self._casts.values():
            cast.quiet = False
            firsts = cast.firsts if cast.rested is None else []
            chosen += [n for n in firsts if self._taken.isdisjoint(self._runtime.players[n].node_rows.tolist())]
        return chosen

    def hush(self, path: Path | None = None) -> None:
        """Clips play from now on, and the animation of that prefab, or of all of them, no more: it goes to rest."""
        self._taken = frozenset()
        for known, cast in self._casts.items():
            if cast.animation is not None and not cast.quiet and path in (None, known):
                cast.animation.rest()
                cast.quiet = True

    def animations(self) -> dict[Path, bool]:
        """The prefabs with an animation of their own, of which some instance stands, and whether it plays."""
        playing = {path for path, _cast in self._playing()}
        return {
            p: p in playing for p, cast in self._casts.items() if cast.animation is not None and cast.rested is None
        }

    def play(self, clip: int | str) -> None:
        """Play this clip, of a prefab or of the scene itself, instead of the others of the same; all else goes on."""
        runtime = self._runtime
        number = runtime.deck.find(clip)
        whose = self.prefab_of(number)
        runtime.follow_structure()
        others = [n for n in runtime.deck.active if self.prefab_of(n) != whose]
        self.hush(whose or Path())
        runtime.deck.play(number, *others, mode=runtime.deck.mode, speed=runtime.deck.speed)
        runtime.pose_again()

    def play_animation(self, path: Path) -> None:
        """Let a prefab's own animation play again, instead of its clips."""
        deck, cast = self._runtime.deck, self._casts[path]
        others = [n for n in deck.active if n not in cast.numbers]
        deck.play(*others, *cast.firsts, mode=deck.mode, speed=deck.speed)
        cast.quiet = False
        self._runtime.pose_again()

    @property
    def duration(self) -> float:
        """Seconds of the longest timeline of a prefab that plays."""
        return max((animation.duration for _path, (animation, _copies) in self._playing()), default=0.0)

    def pose(self, time_s: float, visible: NDArray[np.bool_] | None = None, seers: Seers | None = None) -> None:
        """Let the prefabs' own animations pose their instances."""
        for _path, (animation, copies) in self._playing():
            animation.apply(time_s, copies, visible, seers)

    def _playing(self) -> Iterator[tuple[Path, tuple[InstanceAnimation, Copies]]]:
        for path, cast in self._casts.items():
            animation = cast.animation
            if animation is None or cast.quiet or cast.rested is not None:
                continue
            if self._taken.isdisjoint(animation.rows.tolist()):
                yield path, (animation, cast.copies)

    def _join(self, path: Path, instances: list[tuple[int, dict[str, int]]]) -> _Cast:
        """Read the prefab's clips and let the first of its instances play them."""
        runtime = self._runtime
        try:
            found = prefab_clips(path, runtime.findings)
        except InputError:  # told of when the scene was read
            found = PrefabClips()
        cast = _Cast()
        if not found.clips:
            return cast
        known = {row: i for i, row in enumerate(runtime.cast_rows.tolist()) if row >= 0}
        new: list[int] = []
        wanted = {found.keys[c.node] for clip in found.clips for c in clip.channels}
        for root, rows in instances:
            mine = {key: row for key, row in rows.items() if key in wanted and key not in cast.leader}
            cast.leader |= mine
            if any(row not in known for row in mine.values()):
                new += [row for row in (root, *rows.values()) if row not in known]
        cast.generation = {row: int(runtime.scene.nodes.generation[row]) for row in cast.leader.values()}
        if new:
            known |= self._add(new, known)
        for clip in found.clips:
            channels = [
                channel.of_node(known[cast.leader[key]])
                for channel in clip.channels
                if (key := found.keys[channel.node]) in cast.leader
            ]
            bound = replace(clip, channels=channels)
            player = ClipPlayer(bound, runtime.cast_rows)
            runtime.findings.items.extend(player.findings)
            cast.numbers.append(runtime.deck.join(bound, player, runtime.cast_rows))
        cast.animation = instance_animation(path, found, cast.leader, runtime.scene, runtime.findings)
        names = [clip.name.rpartition("/")[2] for clip in found.clips]
        firsts = [i for i in found.firsts if cast.animation is None or i >= len(found.own)]
        drifts = [i for i, name in enumerate(names) if name == DRIFT and i not in firsts]
        cast.firsts = [cast.numbers[i] for i in (*firsts, *drifts)]
        runtime.deck.active = [*runtime.deck.active, *cast.firsts]
        return cast

    def _add(self, rows: list[int], known: Mapping[int, int]) -> dict[int, int]:
        """Let nodes that came since the scene was opened be of its cast; returns row -> number of each."""
        runtime, nodes = self._runtime, self._runtime.scene.nodes
        parent = nodes.parent.tolist()
        rows = sorted(dict.fromkeys(rows), key=lambda row: (_depth(row, parent), row))
        numbers = {row: len(runtime.cast) + i for i, row in enumerate(rows)}
        at = {**known, **numbers}
        for row in rows:
            t, r, s = (tuple(column[row].tolist()) for column in (nodes.translation, nodes.rotation, nodes.scale))
            runtime.cast.append(NodeAsset(nodes.name[row], at.get(parent[row], -1), t, r, s))
        runtime.deck.meet(np.array(rows, np.int64))
        runtime.cast_rows = np.append(np.where(np.isin(runtime.cast_rows, rows), -1, runtime.cast_rows), rows)
        return numbers


def _copies(pairs: list[tuple[int, int]]) -> Copies:
    table = np.array(pairs, np.int64).reshape(-1, 2)
    return Copies(table[:, 0], table[:, 1], np.zeros(len(table), np.bool_))


def _depth(row: int, parent: list[int]) -> int:
    depth = 0
    while parent[row] >= 0:
        row, depth = parent[row], depth + 1
    return depth
