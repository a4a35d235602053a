"""Fewer keys in fewer bits in a model's clips, within an error at the skin; and what that error came to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.animation.compress import clip_nbytes, compress
from engine.animation.key_reduction import skin_budget
from engine.animation.reach import joint_reach
from engine.animation.rig import Rig, rig_of
from engine.animation.sampler import ClipSampler
from engine.assets.clip import ClipAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import NodeAsset
from engine.math.transform import compose
from importers.model import ImportedModel

F8 = NDArray[np.float64]
#: of the model's size: what a vertex may be off by where nothing else is said. In a picture 2,000 pixels high, which
#: the model fills, that is a fifth of a pixel
SHARE = 1e-4
#: factors of the budget that are tried, the largest first
_OVERDRAWN = (16.0, 8.0, 4.0, 2.0, 1.0)
#: matrices that are compared in one go
_MATRICES = 1 << 16


def reduce_model(model: ImportedModel, skin_error: float) -> None:
    """Replace the clips by ones with fewer keys in fewer bits, no vertex off by more than `skin_error` metres, or a
    SHARE of the model's size where that is negative; a finding for each."""
    size = model_size(model.nodes, model.meshes)
    allowed = skin_error if skin_error >= 0.0 else SHARE * size
    if not 0.0 < allowed < np.inf:
        return
    reach = node_reach(model.nodes, model.meshes)
    for row, node in enumerate(model.nodes):
        if node.camera is not None or node.light is not None:  # what it looks at lies as far off as the model goes
            reach[row] = max(reach[row], size)
    for number, clip in enumerate(model.clips):
        short = reduced(clip, model.nodes, reach, allowed)
        before, after = clip_nbytes(clip), clip_nbytes(short)
        if short is clip or after >= before:
            continue
        error = 1000.0 * clip_error(clip, short, model.nodes, reach)
        model.findings.info(
            "clip.keys", f"{key_count(clip):,} keys became {key_count(short):,}, {before:,} bytes {after:,}; "
            f"the skin moves by {error:.3g} mm at most",
            f"clips[{clip.name}]",
        )  # fmt: skip
        model.clips[number] = short


def model_size(nodes: list[NodeAsset], meshes: list[MeshAsset]) -> float:
    """Metres: the longest side of the largest mesh, as large as its node stands at rest; skinned ones as bound."""
    scale = np.ones(len(nodes))
    size = 0.0
    for row, node in enumerate(nodes):
        own = float(np.abs(np.asarray(node.scale, np.float64)).max())
        if node.matrix is not None:
            own = float(np.abs(np.reshape(np.asarray(node.matrix, np.float64), (4, 4))[:3, :3]).max())
        scale[row] = own * (scale[node.parent] if node.parent >= 0 else 1.0)
        if node.mesh is None:
            continue
        mesh = meshes[node.mesh.index]
        points = np.asarray(mesh.streams["position"], np.float64)
        grown = scale[row]
        if mesh.skeleton is not None and node.joints:
            # a joint's world over its bind pose: what the skin is scaled by
            bind = np.asarray(mesh.skeleton.inverse_bind, np.float64)[0, :3, :3]
            grown = scale[node.joints[0]] * float(np.linalg.norm(bind, axis=0).max())
        if len(points):
            size = max(size, float(np.ptp(points, axis=0).max()) * float(grown))
    return size if np.isfinite(size) else 0.0


def reduced(clip: ClipAsset, nodes: list[NodeAsset], reach: F8, skin_error: float) -> ClipAsset:
    """The clip with fewer keys in fewer bits. The budget is for errors that all add up, which they hardly do: it is
    overdrawn as far as the error that is then measured allows."""
    parents = [node.parent for node in nodes]
    translation, scale = [node.translation for node in nodes], [node.scale for node in nodes]
    budget = skin_budget(clip, parents, translation, scale, reach, skin_error)
    for factor in _OVERDRAWN:
        short = compress(clip, {key: factor * share for key, share in budget.items()})
        if clip_error(clip, short, nodes, reach) <= skin_error:
            return short
    return clip  # a hierarchy in which errors add up otherwise than the budget knows


def node_reach(nodes: list[NodeAsset], meshes: list[MeshAsset]) -> F8:
    """f8[n]: how far from each node, in its own space, vertices lie that follow it."""
    reach = np.zeros(len(nodes))
    for row, node in enumerate(nodes):
        if node.mesh is None:
            continue
        mesh = meshes[node.mesh.index]
        positions = np.asarray(mesh.streams["position"], np.float64)
        if mesh.skeleton is not None and node.joints:
            names = [n for n in ("joints", "joints1") if n in mesh.streams]
            joints = np.concatenate([mesh.streams[n] for n in names], axis=1)
            weights = np.concatenate([mesh.streams[n.replace("joints", "weights")] for n in names], axis=1)
            far = joint_reach(positions, joints, weights, mesh.skeleton.inverse_bind)
            np.maximum.at(reach, np.array(node.joints), far[: len(node.joints)])
        else:
            reach[row] = max(reach[row], float(np.linalg.norm(positions, axis=1).max(initial=0.0)))
    return reach


def key_count(clip: ClipAsset) -> int:
    return sum(len(channel.times) for channel in clip.channels)


def clip_error(clip: ClipAsset, other: ClipAsset, nodes: list[NodeAsset], reach: F8) -> float:
    """Metres by which the two put any vertex apart at most: the worst, over all key times, the moments between them,
    and the nodes that carry vertices, of a ball with its reach."""
    times = np.unique(np.concatenate([np.asarray(c.times, np.float64) for c in clip.channels] or [np.zeros(1)]))
    times = np.concatenate([times, (times[1:] + times[:-1]) / 2])
    rig = rig_of(nodes)
    samplers = ClipSampler(clip, rig), ClipSampler(other, rig)
    carries = np.flatnonzero(reach > 0.0)
    worst = 0.0
    chunk = max(1, _MATRICES // max(len(nodes), 1))
    for start in range(0, len(times), chunk):
        at = times[start : start + chunk]
        one, two = (_world(sampler, rig, nodes, at)[:, carries, :3, :4] for sampler in samplers)
        off = one - two
        # of a ball about the node's place: how that moves, and how far a turn or stretch takes its surface
        far = np.linalg.norm(off[..., 3], axis=2) + reach[carries] * np.linalg.norm(off[..., :3], 2, axis=(2, 3))
        worst = max(worst, float(far.max(initial=0.0)))
    return worst


def _world(sampler: ClipSampler, rig: Rig, nodes: list[NodeAsset], times: F8) -> F8:
    """World matrices f8[m,n,4,4] of all nodes at `times`."""
    pose = np.repeat(rig.rest[:, None, :], len(times), axis=1)
    sampler.sample(times, pose)
    parts = np.moveaxis(pose, 0, -1)
    world = compose(parts[..., 0:3], parts[..., 3:7], parts[..., 7:10])
    for row, node in enumerate(nodes):
        if node.matrix is not None and not sampler.covers[:, row].any():
            world[:, row] = np.reshape(node.matrix, (4, 4)).T
        if node.parent >= 0:
            world[:, row] = world[:, node.parent] @ world[:, row]
    return np.asarray(world)
