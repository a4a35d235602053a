"""A prefab's own animation file on its instances: its timeline or its states pose the nodes that came with it.

It lives on a deck of its own beside the scene's, so that each prefab, and the scene, keeps its own blends. Root motion
carries nobody: where an instance stands is said by the scene that it stands in.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.animation.clock import wrap
from engine.animation.sample import ClipPlayer
from engine.app.animation import open_animation
from engine.app.clip_deck import ClipDeck, Seers
from engine.assets.prefab_clips import PrefabClips
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.scene.copies import Copies
from engine.scene.scene import Scene


class InstanceAnimation:
    """`deck` plays it; `rows`: the nodes of the first instance that it may move."""

    def __init__(self, deck: ClipDeck, rows: NDArray[np.int64]) -> None:
        self._deck, self.rows = deck, rows
        deck.root_motion = False

    @property
    def duration(self) -> float:
        """Seconds of the timeline; 0 where states go on as they will."""
        return self._deck.duration

    def apply(
        self, time_s: float, copies: Copies, visible: NDArray[np.bool_] | None = None, seers: Seers | None = None
    ) -> None:
        """Pose the instances at `time_s`: a timeline again and again, states on from where they are."""
        deck = self._deck
        deck.copies = copies
        if deck.animator is None:
            time_s = wrap(time_s, deck.duration, "loop")
        elif time_s < deck.time:  # the clock began anew, or somebody went back
            deck.jump(time_s)
        deck.apply(time_s, visible, seers)

    def rest(self) -> None:
        """Put back what it has moved."""
        self._deck.rest()


def instance_animation(
    path: Path, found: PrefabClips, leader: Mapping[str, int], scene: Scene, findings: Findings
) -> InstanceAnimation | None:
    """The animation of the prefab at `path` on the rows `leader`, by key; None where it has none, or lets its clips
    play. What is wrong with it is a finding."""
    asset = found.asset
    if asset is None or not asset.animation or asset.drive == "clips":
        return None
    file = path.parent / asset.animation
    try:
        text = file.read_text("utf-8")
        animation = open_animation(text, str(file), asset.nodes, found.own, None, asset.drive)
    except (InputError, OSError, UnicodeDecodeError) as error:
        findings.error("animation.unreadable", str(error), hint=f"instances of {path.name} play their clips without it")
        return None
    rows = np.array([leader.get(key, -1) for key in found.keys], np.int64)
    players = [ClipPlayer(clip, rows) for clip in found.own]
    deck = ClipDeck(scene.nodes, list(found.own), players, scene.morphs, rows)
    mine = rows[animation.rig.source][None]
    if animation.sequence is not None and animation.drive == "timeline":
        deck.follow(animation.sequence, mine)
    elif animation.animator is not None:
        deck.animate(animation.animator, mine)
    else:
        return None
    return InstanceAnimation(deck, mine[0][mine[0] >= 0])
