"""Skins: joints in depth-first order with their inverse bind matrices.

Source: glTF 2.0 specification (Khronos, 2021), section 3.7.3 (skins).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import Skeleton
from importers.gltf.accessors import Accessors
from importers.gltf.document import Document


@dataclass(slots=True)
class Skin:
    """`joints`: the source's nodes in the skeleton's order. `order[j]`: skeleton row of the source's joint j."""

    skeleton: Skeleton
    joints: list[int]
    order: NDArray[np.int64]


def read_skin(
    doc: Document, accessors: Accessors, index: int, parents: list[int], sequence: list[int], names: list[str]
) -> Skin | None:
    """Skin `index`; `parents[n]` is node n's parent (-1: none), `sequence` all nodes depth first.

    None (with a finding) where it has no usable joint.
    """
    where = f"skins[{index}]"
    skin = doc.objects("skins")[index]
    joints = doc.indices(skin, "joints", where, "nodes")
    if not joints or len(joints) > 0xFFFF:
        doc.findings.error("gltf.skin", f"the skin has {len(joints)} usable joints; its meshes stay unskinned", where)
        return None
    if len(joints) != len(doc.array(skin, "joints", where)):
        doc.findings.error("gltf.skin", "some joints are missing, so the weights cannot be matched; left out", where)
        return None
    if len(set(joints)) != len(joints):
        doc.findings.warn("gltf.skin", "a joint is named twice", f"{where}.joints")
    position = {node: k for k, node in enumerate(sequence)}
    sorted_slots = sorted(range(len(joints)), key=lambda j: (position[joints[j]], j))
    order = np.empty(len(joints), np.int64)
    order[sorted_slots] = np.arange(len(joints))
    ordered = [joints[j] for j in sorted_slots]
    # The nearest joint above each node, itself included: plain nodes between joints are legal
    row_of: dict[int, int] = {}
    for row, node in enumerate(ordered):
        row_of.setdefault(node, row)
    nearest: dict[int, int] = {-1: -1}
    for node in sequence:
        nearest[node] = row_of.get(node, nearest[parents[node]])
    joint_parents = np.array([nearest[parents[node]] for node in ordered], "<i4")
    matrices = _inverse_binds(doc, accessors, skin, len(joints), where)[sorted_slots]
    skeleton = Skeleton([names[n] for n in ordered], joint_parents, np.ascontiguousarray(matrices))
    return Skin(skeleton, ordered, order)


def _inverse_binds(
    doc: Document, accessors: Accessors, skin: dict[str, object], count: int, where: str
) -> NDArray[np.float32]:
    """f4[count,4,4], row-major for column vectors; identities where the source gives none."""
    identity = np.tile(np.eye(4, dtype="<f4"), (count, 1, 1))
    if "inverseBindMatrices" not in skin:
        return identity
    place = f"{where}.inverseBindMatrices"
    index = doc.index(skin, "inverseBindMatrices", where, "accessors")
    values = None if index is None else accessors.floats(index)
    if values is None or values.shape[1] != 16 or len(values) < count:
        doc.findings.error("gltf.skin", f"not {count} matrices; taken as identities", place)
        return identity
    matrices = values[:count].reshape(count, 4, 4).transpose(0, 2, 1).astype("<f4")
    bad = ~(np.abs(matrices) < 1e18).all(axis=(1, 2))
    if bad.any():
        doc.findings.error("gltf.not-finite", f"{int(bad.sum())} matrices are no numbers; taken as identities", place)
        matrices[bad] = np.eye(4)
    return matrices
