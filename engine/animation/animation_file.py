"""An animation file resolved against a scene: names become rig nodes, clips and numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.animation import mask, poses
from engine.animation.blend_space import BlendSpace
from engine.animation.events import Marker
from engine.animation.graph import (
    AnimationGraph,
    ClipUse,
    Condition,
    LayerUse,
    Motion,
    Param,
    State,
    Transition,
)
from engine.animation.rig import Rig, moved_nodes, rig_of
from engine.animation.root_motion import extract
from engine.animation.sampler import ClipSampler
from engine.animation.sequence import Block, Track
from engine.animation.sequence import Sequence as Sequence_
from engine.assets.animation_toml import AnimationModel, LayerModel, TrackModel, condition, read_animation
from engine.assets.clip import ClipAsset
from engine.assets.records import did_you_mean
from engine.assets.scene import NodeAsset
from engine.core.errors import FormatError, InputError
from engine.core.findings import Findings
from engine.core.toml_source import KeyPath, TomlSource
from engine.math.transform import compose

F8 = NDArray[np.float64]


def load_animation(
    path: Path, nodes: Sequence[NodeAsset], clips: Sequence[ClipAsset], findings: Findings | None = None
) -> AnimationGraph:
    """Read an animation file for a scene's nodes and clips.

    The rig is every node that one of the file's clips moves or one of its masks names.
    Raises InputError and FormatError with file:line:column. `findings` notes what was wrong in the
    clips and which masked nodes no layer moves.
    """
    model, source = read_animation(path)
    return resolve(model, source, nodes, clips, findings)


@dataclass(slots=True)
class Parts:
    """What graph and sequence are made of: samplers by the file's name of the clip, masks f8[n] by name."""

    rig: Rig
    samplers: dict[str, ClipSampler]
    uses: list[ClipUse]
    masks: dict[str, F8]


#: (clip, nodes of its rig) -> sampler: an edit of the file need not pack every clip again
SamplerCache = dict[tuple[int, bytes], ClipSampler]


def resolve(
    model: AnimationModel,
    source: TomlSource,
    nodes: Sequence[NodeAsset],
    clips: Sequence[ClipAsset],
    findings: Findings | None = None,
) -> AnimationGraph:
    """The graph that `model` describes; complaints stand where `source` has the word. Raises FormatError."""
    notes = findings if findings is not None else Findings()
    return graph_of(model, source, parts_of(model, source, nodes, clips, notes), notes)


def parts_of(
    model: AnimationModel, source: TomlSource, nodes: Sequence[NodeAsset], clips: Sequence[ClipAsset],
    notes: Findings, cache: SamplerCache | None = None,
) -> Parts:  # fmt: skip
    """The rig, the clips on it and the masks. Raises FormatError where the file names what is not there."""
    used = {key: _clip(key, model, source, clips) for key in model.clips}
    named = {s.node for m in model.masks.values() for s in m.subtrees} | {
        n for m in model.masks.values() for n in m.nodes
    }
    masked = [i for i, node in enumerate(nodes) if node.name in named]
    rig = rig_of(nodes, np.union1d(moved_nodes(used.values(), len(nodes)), np.array(masked, np.int64)))
    known = cache if cache is not None else {}
    samplers = {}
    for key, clip in used.items():
        at = (id(clip), rig.source.tobytes())
        if at not in known:
            known[at] = ClipSampler(clip, rig)
            notes.items.extend(known[at].findings)
        samplers[key] = known[at]
    uses = [ClipUse(samplers[key], [Marker(m.name, m.time) for m in clip.markers]) for key, clip in model.clips.items()]
    return Parts(rig, samplers, uses, {key: _mask(key, model, source, rig) for key in model.masks})


def sequence_of(model: AnimationModel, source: TomlSource, parts: Parts, above: F8 | None = None) -> Sequence_:
    """The timeline of `model`. `above`: see `rest_above`. Raises FormatError."""
    numbers = {key: i for i, key in enumerate(model.clips)}
    tracks = [
        Track(
            t.name,
            [
                Block(
                    numbers[b.clip], b.start, b.length, b.offset, b.speed, b.fade_in, b.fade_out, b.curve, b.play,
                    b.sync, b.weight,
                )
                for b in t.blocks
            ],
            parts.masks[t.mask] if t.mask else mask.everything(parts.rig), t.mode, float(t.weight), t.muted,
            _reference(t, t.blocks[0].clip if t.blocks else "", parts.samplers, parts.rig),
        )
        for t in model.tracks
    ]  # fmt: skip
    root = _node(model.root, ("root",), source, parts.rig) if model.root else -1
    ways = [extract(use.sampler, root, above) if root >= 0 else None for use in parts.uses]
    return Sequence_(parts.rig, parts.uses, tracks, [(m.time, m.name) for m in model.markers], ways)


def graph_of(model: AnimationModel, source: TomlSource, parts: Parts, notes: Findings) -> AnimationGraph:
    """The states, transitions and layers of `model`. Raises FormatError."""
    rig, samplers, masks = parts.rig, parts.samplers, parts.masks
    numbers = {key: i for i, key in enumerate(model.clips)}
    params = {key: i for i, key in enumerate(model.params)}
    states = {key: i for i, key in enumerate(model.states)}

    def motion(clip: str, blend: str) -> Motion:
        if clip:
            return Motion((numbers[clip],))
        chosen = model.blends[blend]
        space = BlendSpace(np.array([s.at for s in chosen.samples]))
        return Motion(
            tuple(numbers[s.clip] for s in chosen.samples), space, tuple(params[name] for name in chosen.params)
        )

    graph = AnimationGraph(
        rig,
        parts.uses,
        [State(key, motion(s.clip, s.blend), s.speed, s.mode) for key, s in model.states.items()],
        [Param(key, p.type, float(p.default)) for key, p in model.params.items()],
        [
            Transition(
                -1 if t.source == "any" else states[t.source], states[t.target],
                tuple(_condition(text, params) for text in t.when), t.fade, t.curve, t.exit, t.sync,
            )
            for t in model.transitions
        ],
        name=model.name,
        root=_node(model.root, ("root",), source, rig) if model.root else -1,
        start=states[model.start] if model.start else 0,
    )  # fmt: skip
    for i, layer in enumerate(model.layers):
        over = masks[layer.mask] if layer.mask else mask.everything(rig)
        made = motion(layer.clip, layer.blend)
        free = mask.uncovered(rig, over, [graph.clips[c].sampler for c in made.clips])
        if layer.mask and free:
            notes.warn(
                "layer.uncovered", f"layer {layer.name!r}: its clips do not move {', '.join(free)}",
                f"layers[{i}]", "there the layer holds the rest pose",
            )  # fmt: skip
        by_param = isinstance(layer.weight, str)
        graph.layers.append(
            LayerUse(
                layer.name, made, over, layer.mode, _reference(layer, layer.clip, samplers, rig),
                params[str(layer.weight)] if by_param else -1, 1.0 if by_param else float(layer.weight),
                layer.speed, layer.play,
            )
        )  # fmt: skip
    graph.validate()
    return graph


def rest_above(nodes: Sequence[NodeAsset], graph: AnimationGraph) -> tuple[F8 | None, int]:
    """As `above_root`, of a graph."""
    return above_root(nodes, graph.rig, graph.root)


def above_root(nodes: Sequence[NodeAsset], rig: Rig, root: int) -> tuple[F8 | None, int]:
    """For root motion: world from the root's parent at rest, f8[3,4], and the node above it all; (None, -1) without."""
    if root < 0:
        return None, -1
    top = node = int(rig.source[root])
    world = np.eye(4)
    while (node := nodes[node].parent) >= 0:
        n, top = nodes[node], node
        local = compose(n.translation, n.rotation, n.scale) if n.matrix is None else np.reshape(n.matrix, (4, 4)).T
        world = local @ world
    # a root without parents is posed itself: it cannot be carried as well
    return world[:3], top if top != int(rig.source[root]) else -1


def _clip(key: str, model: AnimationModel, source: TomlSource, clips: Sequence[ClipAsset]) -> ClipAsset:
    wanted = model.clips[key].source or key
    for clip in clips:
        if clip.name == wanted:
            return clip
    names = [clip.name for clip in clips]
    keys: KeyPath = ("clips", key, "source") if model.clips[key].source else ("clips", key)
    hint = did_you_mean(wanted, names) or f"clips: {', '.join(names) or 'none'}"
    raise source.error(keys, f"the scene has no clip {wanted!r}", hint=hint, value=bool(model.clips[key].source))


def _node(name: str, keys: KeyPath, source: TomlSource, rig: Rig) -> int:
    try:
        return rig.index(name)
    except InputError as error:
        raise source.error(keys, error.message, hint=error.hint, value=True) from None


def _mask(key: str, model: AnimationModel, source: TomlSource, rig: Rig) -> F8:
    chosen = model.masks[key]
    parts = []
    for i, part in enumerate(chosen.subtrees):
        _node(part.node, ("masks", key, "subtrees", i, "node"), source, rig)
        parts.append(mask.subtree(rig, part.node, part.weight, part.fall_off))
    for name in chosen.nodes:
        _node(name, ("masks", key, "nodes", name), source, rig)
    return mask.combine(rig, parts, chosen.nodes)


def _condition(text: str, params: dict[str, int]) -> Condition:
    parsed = condition(text)
    if parsed is None:
        raise FormatError(f"{text!r} is no condition")
    return Condition(params[parsed[0]], parsed[1], parsed[2])


def _reference(layer: LayerModel | TrackModel, own: str, samplers: dict[str, ClipSampler], rig: Rig) -> F8 | None:
    """f8[10,n]: what an additive layer is measured from; `own`: its clip."""
    if layer.mode != "additive":
        return None
    pose = poses.resting(rig.rest, 1)
    name = own if layer.reference is None else layer.reference
    if name:
        samplers[name].sample([layer.reference_time], pose)
    return pose[:, 0]
