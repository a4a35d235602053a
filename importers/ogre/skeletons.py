"""A skeleton as joints of a scene: nodes in depth-first order, the binding pose, the inverse bind matrices.

Source: Ogre manual, skeletal animation (bones carry their binding pose relative to the parent; keys are relative to
it).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import Skeleton
from engine.assets.scene import NodeAsset
from engine.core.errors import FormatError, Place
from engine.core.findings import Findings
from engine.math.transform import compose, inverse_affine
from importers.ogre.data import OgreSkeleton


@dataclass(slots=True)
class Rig:
    """`skeleton`, its `nodes` in the same order (parents as rows of this list), and `rows`: bone handle -> row.

    `bind_*`: the binding pose as f8 arrays, one row a joint."""

    skeleton: Skeleton
    nodes: list[NodeAsset]
    rows: dict[int, int]
    bind_translation: NDArray[np.float64]
    bind_rotation: NDArray[np.float64]
    bind_scale: NDArray[np.float64]


def make_rig(source: OgreSkeleton, file: str, findings: Findings) -> Rig | None:
    """The rig of `source`; None where it has no bones. Raises FormatError where bones hang on one another in a ring."""
    if not source.bones:
        findings.error("ogre.skeleton", f"the skeleton {file!r} has no bones", hint="export it again")
        return None
    children: dict[int, list[int]] = {}
    handles = {bone.handle: k for k, bone in enumerate(source.bones)}
    for k, bone in enumerate(source.bones):
        children.setdefault(bone.parent if bone.parent in handles else -1, []).append(k)
    order: list[int] = []
    stack = list(reversed(children.get(-1, [])))
    while stack:
        k = stack.pop()
        order.append(k)
        stack.extend(reversed(children.get(source.bones[k].handle, [])))
    if len(order) != len(source.bones):
        lost = next(bone.name for k, bone in enumerate(source.bones) if k not in set(order))
        raise FormatError(
            "some bones hang on one another in a ring", where=Place(file, path=f"bone {lost!r}"),
            hint="repair the hierarchy and export it again",
        )  # fmt: skip
    bones = [source.bones[k] for k in order]
    rows = {bone.handle: row for row, bone in enumerate(bones)}
    parents = np.array([rows.get(bone.parent, -1) for bone in bones], "<i4")
    translation = np.array([bone.position for bone in bones], np.float64)
    rotation = np.array([bone.rotation for bone in bones], np.float64)
    scale = np.array([bone.scale for bone in bones], np.float64)
    length = np.linalg.norm(rotation, axis=1)
    none = length < 1e-9
    if none.any():
        name = bones[int(np.argmax(none))].name
        findings.error("ogre.rotation", f"{int(none.sum())} bones have a rotation of zeros; taken as none", name)
        rotation[none], length[none] = (0.0, 0.0, 0.0, 1.0), 1.0
    rotation /= length[:, None]
    skeleton = Skeleton([bone.name for bone in bones], parents, _inverse_bind(parents, translation, rotation, scale))
    nodes = [
        NodeAsset(bone.name, int(parents[row]), (t[0], t[1], t[2]), (r[0], r[1], r[2], r[3]), (s[0], s[1], s[2]))
        for row, (bone, t, r, s) in enumerate(
            zip(bones, translation.tolist(), rotation.tolist(), scale.tolist(), strict=True)
        )
    ]
    return Rig(skeleton, nodes, rows, translation, rotation, scale)


def _inverse_bind(
    parents: NDArray[np.int32], translation: NDArray[np.float64], rotation: NDArray[np.float64],
    scale: NDArray[np.float64],
) -> NDArray[np.float32]:  # fmt: skip
    """f4[j,4,4]: joint space from mesh space. Parents stand before their children."""
    world = compose(translation, rotation, scale)
    for row, parent in enumerate(parents):
        if parent >= 0:
            world[row] = world[parent] @ world[row]
    return np.ascontiguousarray(inverse_affine(world).astype("<f4"))
