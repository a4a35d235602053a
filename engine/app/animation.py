"""Animation: an open animation file on a scene: its text, what the text means, and how it poses the scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from engine.animation.animation_file import SamplerCache, above_root, graph_of, parts_of, sequence_of
from engine.animation.animator import Animator
from engine.animation.graph import AnimationGraph
from engine.animation.rig import Rig
from engine.animation.sequence import Sequence as ClipSequence
from engine.assets.animation_toml import AnimationModel, parse_animation
from engine.assets.clip import ClipAsset
from engine.assets.scene import NodeAsset
from engine.core.errors import InputError
from engine.core.findings import Findings

#: what may pose a scene
DRIVES = ("clips", "timeline", "states")


@dataclass(slots=True)
class Animation:
    """`drive`: `timeline` (the tracks, by time) or `states` (the machine, as it goes). `top`: the number of the node
    that root motion carries, or -1."""

    text: str
    file: str
    model: AnimationModel
    rig: Rig
    graph: AnimationGraph | None
    sequence: ClipSequence | None
    animator: Animator | None
    drive: str
    top: int = -1
    findings: Findings = field(default_factory=Findings)
    _cache: SamplerCache = field(default_factory=dict)

    @property
    def duration(self) -> float:
        """Seconds of the timeline; of the longest clip where states drive."""
        if self.drive == "timeline" and self.sequence is not None:
            return self.sequence.duration
        return max((use.sampler.duration for use in self.graph.clips), default=0.0) if self.graph else 0.0


def open_animation(
    text: str, file: str, nodes: Sequence[NodeAsset], clips: Sequence[ClipAsset], before: Animation | None = None,
    drive: str = "",
) -> Animation:  # fmt: skip
    """The animation that `text` describes on these nodes and clips; it goes on where `before` was.

    `file` names it in messages. Raises FormatError with file:line:column, and then nothing has changed; InputError for
    a drive that the text has not.
    """
    model, source = parse_animation(text, file)
    notes = Findings(file)
    cache = before._cache if before is not None else {}
    parts = parts_of(model, source, nodes, clips, notes, cache)
    root = parts.rig.index(model.root) if model.root in parts.rig.names else -1
    above, top = above_root(nodes, parts.rig, root)
    graph = graph_of(model, source, parts, notes) if model.states else None
    sequence = sequence_of(model, source, parts, above) if model.tracks else None
    animator = Animator(graph, above=above) if graph is not None else None
    if animator is not None and before is not None and before.animator is not None:
        animator.adopt(before.animator)
    wanted = drive or (before.drive if before is not None else "")
    has = {"timeline": sequence is not None, "states": graph is not None}
    if drive and not has.get(drive, False):
        raise InputError(f"{file} has no {drive}", hint="timeline needs [[tracks]], states [states.NAME]")
    if not has.get(wanted, False):
        wanted = "states" if graph is not None else "timeline"
    return Animation(text, file, model, parts.rig, graph, sequence, animator, wanted, top, notes, cache)


def fresh_text(name: str, clips: Sequence[ClipAsset]) -> str:
    """An animation file that plays the first clip on a timeline and knows the others."""
    lines = ['schema = "lucarna.animation/1"', f"name = {_quoted(name)}", ""]
    for clip in clips:
        lines += [f"[clips.{_quoted(clip.name)}]"]
    first = clips[0] if clips else None
    lines += ["", "[[tracks]]", 'name = "base"']
    if first is not None:
        length = max(float(np.round(first.duration, 6)), 1e-3)
        lines += [f"blocks = [{{ clip = {_quoted(first.name)}, start = 0.0, length = {length!r} }}]"]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    plain = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in plain) + '"'
