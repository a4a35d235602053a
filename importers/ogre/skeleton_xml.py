"""`.skeleton.xml`, the XML twin of `.skeleton`. Bones go by name here; rotations are an angle about an axis.

Source: Ogre's ogreskeletonxml.dtd (elements and attributes) and what OgreXMLConverter writes.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from engine.core.findings import Findings
from engine.math import quat
from importers.ogre.data import Bone, BoneTrack, OgreSkeleton, SkeletonAnimation
from importers.ogre.xml_reader import Attributes, XmlReader

_NO_TURN = (0.0, (1.0, 0.0, 0.0))


def read_skeleton_xml(data: bytes, file: str, findings: Findings) -> OgreSkeleton:
    """The skeleton in `data`. Raises FormatError with the line."""
    del findings  # nothing in the format can be left out
    return _SkeletonXml(file).read(data)


class _SkeletonXml:
    def __init__(self, file: str) -> None:
        self._xml = XmlReader(file)
        self._skeleton = OgreSkeleton("XML")
        self._by_name: dict[str, Bone] = {}
        self._handles: set[int] = set()
        self._bone: Bone | None = None
        self._turn: tuple[float, tuple[float, float, float]] = _NO_TURN
        self._track: tuple[int, list[list[float]]] | None = None
        self._key: list[float] | None = None

    def read(self, data: bytes) -> OgreSkeleton:
        xml = self._xml
        xml.starts = {
            "bone": self._start_bone, "position": self._position, "rotation": self._angle, "rotate": self._angle,
            "axis": self._axis, "scale": self._scale, "boneparent": self._parent, "animation": self._animation,
            "baseinfo": self._base, "track": self._start_track, "keyframe": self._start_key,
            "translate": self._translate, "animationlink": self._link,
        }  # fmt: skip
        ends: dict[str, Callable[[], None]] = {
            "rotation": self._end_turn, "rotate": self._end_turn, "bone": self._end_bone,
            "keyframe": self._end_key, "track": self._end_track,
        }  # fmt: skip
        xml.ends = ends
        xml.parse(data)
        return self._skeleton

    # --- bones ---

    def _start_bone(self, a: Attributes) -> None:
        handle = self._xml.whole(a, "id")
        name = a["name"]
        if handle > 0xFFFF or handle in self._handles:
            raise self._xml.error(f"the id {handle} of bone {name!r} is taken or over 65535")
        if name in self._by_name:
            raise self._xml.error(f"two bones are called {name!r}")
        self._handles.add(handle)
        self._bone = self._by_name[name] = Bone(name, handle)
        self._skeleton.bones.append(self._bone)

    def _end_bone(self) -> None:
        self._bone = None

    def _position(self, a: Attributes) -> None:
        if self._bone is not None:
            self._bone.position = self._xml.vector(a)

    def _angle(self, a: Attributes) -> None:
        self._turn = self._xml.number(a, "angle"), _NO_TURN[1]

    def _axis(self, a: Attributes) -> None:
        self._turn = self._turn[0], self._xml.vector(a)

    def _end_turn(self) -> None:
        angle, axis = self._turn
        self._turn = _NO_TURN
        x, y, z, w = (0.0, 0.0, 0.0, 1.0)
        if any(axis):
            x, y, z, w = quat.from_axis_angle(np.array(axis), angle).tolist()
        if self._key is not None:
            self._key[1:5] = x, y, z, w
        elif self._bone is not None:
            self._bone.rotation = (x, y, z, w)

    def _scale(self, a: Attributes) -> None:
        if "factor" in a:
            factor = self._xml.number(a, "factor")
            scale = (factor, factor, factor)
        else:
            scale = (self._xml.number(a, "x", 1.0), self._xml.number(a, "y", 1.0), self._xml.number(a, "z", 1.0))
        if self._key is not None:
            self._key[8:11] = scale
        elif self._bone is not None:
            self._bone.scale = scale

    def _parent(self, a: Attributes) -> None:
        child, parent = (self._named(a[name]) for name in ("bone", "parent"))
        child.parent = parent.handle

    def _named(self, name: str) -> Bone:
        if name not in self._by_name:
            raise self._xml.error(f"there is no bone {name!r}")
        return self._by_name[name]

    # --- animations ---

    def _animation(self, a: Attributes) -> None:
        self._skeleton.animations.append(SkeletonAnimation(a["name"], self._xml.number(a, "length")))

    def _base(self, a: Attributes) -> None:
        if self._skeleton.animations:
            self._skeleton.animations[-1].base = a.get("baseanimationname", "")

    def _start_track(self, a: Attributes) -> None:
        self._track = self._named(a["bone"]).handle, []

    def _end_track(self) -> None:
        if self._track is None:
            return
        (handle, rows), self._track = self._track, None
        table = np.array(rows, np.float64).reshape(-1, 11).astype(np.float32)
        track = BoneTrack(handle, table[:, 0].copy(), table[:, 1:5].copy(), table[:, 5:8].copy(), table[:, 8:].copy())
        if self._skeleton.animations:
            self._skeleton.animations[-1].tracks.append(track)

    def _start_key(self, a: Attributes) -> None:
        # time, rotation, translation, scale
        self._key = [self._xml.number(a, "time"), 0, 0, 0, 1, 0, 0, 0, 1, 1, 1]

    def _end_key(self) -> None:
        if self._track is not None and self._key is not None:
            self._track[1].append(self._key)
        self._key = None

    def _translate(self, a: Attributes) -> None:
        if self._key is not None:
            self._key[5:8] = self._xml.vector(a)

    def _link(self, a: Attributes) -> None:
        name = a.get("skeletonname") or a.get("skeletonName") or self._xml.text(a, "skeletonname")
        self._skeleton.links.append((name, self._xml.number(a, "scale", 1.0)))
