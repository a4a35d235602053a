"""IndirectState: what light between surfaces keeps from frame to frame: the cameras before, the size of the scene."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.render.camera import Camera
from engine.render.facts import SceneFacts
from engine.render.gi.choice import lengths_of, size_of
from engine.render.transforms import origin_near
from engine.render.view import View
from engine.scene.scene import Scene

#: views that are remembered, as many as the frame graph keeps compiled
VIEWS = 8
#: a camera that turned by more, or went farther (of the scene's size) in one frame, is another one: a cut
CUT_COSINE, CUT_PART = 0.5, 0.25


@dataclass(slots=True)
class _Seen:
    camera: Camera
    aspect: float
    subject: int
    frames: int


class IndirectState:
    """Of one renderer. Its numbers go to the passes as look["indirect"]."""

    def __init__(self) -> None:
        self._views: OrderedDict[Hashable, _Seen] = OrderedDict()
        self._size: tuple[object, float] = ((), 1.0)

    def look(self, scene: Scene, view: View, facts: SceneFacts) -> dict[str, Any]:
        """`facts`: of this frame."""
        key = view.key  # that of the frame graph
        if not facts.indirect.wanted:
            return {**lengths_of(view.settings, 1.0), **_nothing_before()}
        size = self._size_of(scene)
        lengths = lengths_of(view.settings, size)
        if view.seconds is None:
            self._views.pop(key, None)
            return {**lengths, **_nothing_before()}
        before = self._views.pop(key, None)
        if view.cut:
            before = None
        frames = before.frames + 1 if before is not None else 0
        self._views[key] = _Seen(_copied(view.camera), view.aspect, id(scene), frames)
        while len(self._views) > VIEWS:
            self._views.popitem(last=False)
        if before is None or before.subject != id(scene) or is_cut(before.camera, view.camera, size):
            self._views[key].frames = 0
            return {**lengths, **_nothing_before()}
        found = _before(before.camera, before.aspect, origin_near(view.camera.position, view.camera.znear))
        # a golden ratio's steps: neither they nor their sums come back soon
        return {**lengths, **found, "turn": frames * 0.618033988749895 % 1.0, "known": 1.0}

    def _size_of(self, scene: Scene) -> float:
        key = (id(scene), scene.transform_rev, scene.instances.drawn_rev)
        if self._size[0] != key:
            self._size = (key, size_of(*scene.bounds()))
        return self._size[1]


def is_cut(before: Camera, now: Camera, size: float) -> bool:
    """Whether a camera jumped: no picture of the one before tells about this one."""
    a, b = before.world_from_camera, now.world_from_camera
    turned = float(a[:3, 2] @ b[:3, 2])
    moved = float(np.linalg.norm(a[:3, 3] - b[:3, 3]))
    return not (turned > CUT_COSINE and moved < CUT_PART * size) or (before.ymag > 0.0) != (now.ymag > 0.0)


def _copied(camera: Camera) -> Camera:
    return replace(camera, world_from_camera=camera.world_from_camera.copy())


def _before(camera: Camera, aspect: float, origin: NDArray[np.float64]) -> dict[str, Any]:
    pose = camera.world_from_camera.copy()
    pose[:3, 3] -= origin
    view_from_origin = np.linalg.inv(pose)
    clip = camera.clip_from_view(aspect) @ view_from_origin
    return {"before_clip": clip.T, "before_depth": -view_from_origin[2]}


def _nothing_before() -> dict[str, Any]:
    return {"before_clip": np.eye(4), "before_depth": np.zeros(4), "turn": 0.0, "known": 0.0}
