"""Skins: clusters become joints with inverse bind matrices, and influences per control point.

Vertices that no cluster moves stay with the mesh's node, as FBX has it: the node is then a joint of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import Skeleton
from importers.fbx.document import FbxDocument, Json

#: influences kept per control point before the eight strongest are chosen
_MOST = 64
#: stands for the mesh's own node among the joints
OWN_NODE = -1


@dataclass(slots=True)
class Skin:
    """`joints`: document nodes in the skeleton's order, OWN_NODE for the mesh's. Influences by control point:
    `rows` i8[n,k], `weights` f8[n,k]. `method`: linear, rigid, dual_quaternion, blended_dq_linear;
    `dq_share` f8[n]: how much of dual quaternions each point takes."""

    skeleton: Skeleton
    joints: list[int]
    rows: NDArray[np.int64]
    weights: NDArray[np.float64]
    method: str
    dq_share: NDArray[np.float64]


def read_skin(doc: FbxDocument, mesh: Json, node: int, where: str) -> Skin | None:
    """The first skin of a mesh that hangs on `node`; None (with a finding) where it has no usable joint."""
    if len(mesh["skins"]) > 1:
        doc.findings.warn("fbx.skin", f"{len(mesh['skins'])} skins on one mesh; the first is used", where)
    skin = mesh["skins"][0]
    points = len(doc.array(mesh["positions"]))
    bones = [int(b) for b in skin["bones"]]
    if not bones or len(bones) >= 0xFFFF:
        doc.findings.error("fbx.skin", f"the skin has {len(bones)} usable joints; the mesh stays rigid", where)
        return None
    binds = _matrices(doc, skin["bone_from_geometry"], len(bones), where)
    columns, weights = _influences(doc, skin, points, where)
    unmoved = ~(weights > 0).any(axis=1)
    if unmoved.any():
        columns[unmoved, 0], weights[unmoved, 0] = len(bones), 1.0
        bones = [*bones, OWN_NODE]
        geometry = np.eye(4)
        geometry[:3] = doc.array(doc.data["node_from_geometry"])[node]
        binds = np.concatenate([binds, geometry[None]])
        doc.findings.info(
            "fbx.skin", f"{int(unmoved.sum()):,} of {points:,} points have no weight; they stay with the node", where
        )  # fmt: skip
    skeleton, joints, order = _skeleton(doc, bones, node, binds)
    share = np.full(points, 1.0 if skin["method"] == "dual_quaternion" else 0.0)
    if skin["method"] == "blended_dq_linear":
        vertices, given = doc.array(skin["dq_vertices"]), doc.array(skin["dq_weights"])
        good = (vertices < points) & np.isfinite(given)
        share[vertices[good]] = np.clip(given[good], 0.0, 1.0)
    return Skin(skeleton, joints, order[columns], weights, str(skin["method"]), share)


def _matrices(doc: FbxDocument, name: str, count: int, where: str) -> NDArray[np.float64]:
    matrices = np.tile(np.eye(4), (count, 1, 1))
    matrices[:, :3] = np.asarray(doc.array(name), np.float64).reshape(count, 3, 4)
    bad = ~(np.abs(matrices) < 1e18).all(axis=(1, 2))
    if bad.any():
        doc.findings.error(
            "fbx.not-finite", f"{int(bad.sum())} bind matrices are no numbers; taken as identities", where
        )
        matrices[bad] = np.eye(4)
    return matrices


def _influences(doc: FbxDocument, skin: Json, points: int, where: str) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Clusters i8[points,k] and weights f8[points,k], the strongest first."""
    counts = np.asarray(skin["counts"], np.int64)
    vertices = doc.array(skin["vertices"]).astype(np.int64)
    weights = np.asarray(doc.array(skin["weights"]), np.float64)
    cluster = np.repeat(np.arange(len(counts)), counts)
    outside = vertices >= points
    if outside.any():
        doc.findings.error(
            "fbx.skin", f"{int(outside.sum()):,} weights are for points beyond the mesh's {points:,}; ignored", where
        )  # fmt: skip
    bad = ~np.isfinite(weights) | (weights < 0)
    if bad.any():
        doc.findings.warn("fbx.weights", f"{int(bad.sum()):,} weights are negative or no numbers; ignored", where)
    keep = ~outside & ~bad & (weights > 0)
    vertices, weights, cluster = vertices[keep], weights[keep], cluster[keep]
    order = np.lexsort((cluster, -weights, vertices))
    vertices, weights, cluster = vertices[order], weights[order], cluster[order]
    rank = np.arange(len(vertices)) - np.searchsorted(vertices, vertices)
    width = min(max(int(rank.max(initial=0)) + 1, 1), _MOST)
    keep = rank < width
    columns = np.zeros((points, width), np.int64)
    values = np.zeros((points, width))
    columns[vertices[keep], rank[keep]] = cluster[keep]
    values[vertices[keep], rank[keep]] = weights[keep]
    return columns, values


def _skeleton(
    doc: FbxDocument, bones: list[int], own: int, binds: NDArray[np.float64]
) -> tuple[Skeleton, list[int], NDArray[np.int64]]:
    """Joints depth first; `order[k]` is the row of bone k."""
    actual = [own if bone == OWN_NODE else bone for bone in bones]
    position = {node: k for k, node in enumerate(doc.sequence)}
    ranked = sorted(range(len(bones)), key=lambda k: (position[actual[k]], k))
    order = np.empty(len(bones), np.int64)
    order[ranked] = np.arange(len(bones))
    row_of: dict[int, int] = {}
    for row, k in enumerate(ranked):
        row_of.setdefault(actual[k], row)
    nearest: dict[int, int] = {-1: -1}
    for node in doc.sequence:
        nearest[node] = row_of.get(node, nearest[doc.parents[node]])
    parents = np.array([nearest[doc.parents[actual[k]]] for k in ranked], "<i4")
    names = [doc.names[actual[k]] for k in ranked]
    skeleton = Skeleton(names, parents, np.ascontiguousarray(binds[ranked].astype("<f4")))
    return skeleton, [bones[k] for k in ranked], order
