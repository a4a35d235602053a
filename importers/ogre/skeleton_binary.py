"""Binary `.skeleton` files, versions 1.10 and 1.80, either endianness.

Source: Ogre manual and the comments of its OgreSkeletonFileFormat header. A bone's and a key's length leaves the name
out, and says by its size whether a scale follows.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.core.findings import Findings
from importers.ogre.chunks import Chunks
from importers.ogre.data import Bone, BoneTrack, OgreSkeleton, SkeletonAnimation

BLEND_MODE, BONE, PARENT, ANIMATION, BASE, TRACK, KEY, LINK = (
    0x1010, 0x2000, 0x3000, 0x4000, 0x4010, 0x4100, 0x4110, 0x5000,
)  # fmt: skip
BONE_WITHOUT_SCALE = 36
KEY_WITHOUT_SCALE = 38


def read_skeleton(data: bytes, file: str, findings: Findings) -> OgreSkeleton:
    """The skeleton in `data`. Raises FormatError (with the byte) where it is cut or breaks the format."""
    c = Chunks(data, file)
    line = c.header("an Ogre skeleton")
    name, _, number = line.rpartition("_v")
    if name != "Serializer" or number not in ("1.00", "1.10", "1.80"):
        raise c.error(f"the version {line[:60]!r} is not known", "known are Serializer_v1.10 and _v1.80", 2)
    skeleton = OgreSkeleton(number)
    by_handle: dict[int, Bone] = {}
    while (found := c.next_id()) >= 0:
        if found == BONE:
            bone = _bone(c, len(skeleton.bones))
            if bone.handle in by_handle:
                raise c.error(f"the bones {by_handle[bone.handle].name!r} and {bone.name!r} share the handle "
                              f"{bone.handle}", at=c.chunk_start)  # fmt: skip
            by_handle[bone.handle] = bone
            skeleton.bones.append(bone)
        elif found == PARENT:
            c.enter("a bone's parent")
            child, parent = c.u16("a bone's parent"), c.u16("a bone's parent")
            if child not in by_handle or parent not in by_handle:
                raise c.error(f"bone {child} is to hang on bone {parent}; one of them does not exist")
            by_handle[child].parent = parent
        elif found == ANIMATION:
            skeleton.animations.append(_animation(c, f"animations[{len(skeleton.animations)}]"))
        elif found == LINK:
            c.enter("a linked skeleton")
            skeleton.links.append((c.text("a linked skeleton's name"), c.floats(1, "a linked skeleton's scale")[0]))
        else:
            if found != BLEND_MODE:
                findings.warn("ogre.chunk", f"the unknown chunk 0x{found:04X} is left out", f"byte {c.position:,}")
            c.skip("a chunk of the skeleton")
    return skeleton


def _bone(c: Chunks, number: int) -> Bone:
    where = f"bones[{number}]"
    c.enter(where)
    scaled = c.chunk_length > BONE_WITHOUT_SCALE
    bone = Bone(c.text(f"{where}'s name"), c.u16(f"{where}'s handle"))
    x, y, z = c.floats(3, f"{where}'s position")
    bone.position = (x, y, z)
    x, y, z, w = c.floats(4, f"{where}'s rotation")
    bone.rotation = (x, y, z, w)
    if scaled:
        x, y, z = c.floats(3, f"{where}'s scale")
        bone.scale = (x, y, z)
    return bone


def _animation(c: Chunks, where: str) -> SkeletonAnimation:
    c.enter(where)
    animation = SkeletonAnimation(c.text(f"{where}'s name"), c.floats(1, f"{where}'s length")[0])
    if c.next_id() == BASE:
        c.enter(where)
        animation.base = c.text(f"{where}'s base")
        c.floats(1, f"{where}'s base time")
    while c.next_id() == TRACK:
        c.enter(where)
        animation.tracks.append(_track(c, f"{where}.tracks[{len(animation.tracks)}]"))
    return animation


def _track(c: Chunks, where: str) -> BoneTrack:
    bone = c.u16(f"the bone of {where}")
    plain: list[Any] = [("time", "f4"), ("rotation", "f4", 4), ("translation", "f4", 3)]
    columns: list[list[np.ndarray]] = [[], [], [], []]
    while c.next_id() == KEY:
        start = c.position
        c.enter(where)
        scaled = c.chunk_length > KEY_WITHOUT_SCALE
        c.position = start
        # keys with and without a scale may take turns: each run at once
        rows = c.records(KEY, [*plain, ("scale", "f4", 3)] if scaled else plain, f"a key of {where}")
        scale = rows["scale"] if scaled else np.ones((len(rows), 3), np.float32)
        for column, values in zip(columns, (rows["time"], rows["rotation"], rows["translation"], scale), strict=True):
            column.append(values)
    if not columns[0]:
        return BoneTrack(bone, *(np.zeros(shape, np.float32) for shape in (0, (0, 4), (0, 3), (0, 3))))
    return BoneTrack(bone, *(np.concatenate(column) for column in columns))
