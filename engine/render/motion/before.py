"""Before: the frame before of each view, and whether it tells something about the next one."""

from __future__ import annotations

import weakref
from collections import OrderedDict
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.gpu.types import Buffer, Device
from engine.render.camera import Camera
from engine.render.draw_commands import chosen, fit_buffer
from engine.render.motion.frame import FrameMotion
from engine.render.scene_rows import SceneRows
from engine.render.view import View
from engine.scene.scene import Scene

#: views that are remembered, as many as the frame graph keeps compiled
VIEWS = 8
#: a camera that turned so far (cosine), went so far (of the scene's size) or zoomed by so much in one frame is another
CUT_COSINE, CUT_PART, CUT_ZOOM = 0.5, 0.25, 1.5


@dataclass(slots=True)
class _Rows:
    """What stood where in a view's last frame. `transforms` f4[n,3,4] relative to the frame's origin."""

    structure: tuple[object, ...]
    transform_rev: int
    morph_rev: int
    changes: int
    transforms: NDArray[np.float32]
    palettes: NDArray[np.float32]
    morphs: NDArray[np.uint32]
    weights: NDArray[np.float64]
    morph_words: int


@dataclass(slots=True)
class _Seen:
    scene: weakref.ref[Scene]
    camera: Camera
    size: tuple[int, int]
    path: str
    origin: NDArray[np.float64]
    frames: int
    state: tuple[object, ...]
    frozen: int
    rows: _Rows | None = None


@dataclass(slots=True)
class _Frame:
    """Of the frame that is being made: what `end` will remember. `state`: what a picture depends on."""

    view: View
    scene: Scene
    origin: NDArray[np.float64]
    motion: FrameMotion
    state: tuple[object, ...]
    wanted: bool = False


class Before:
    """Of one renderer. `begin`, `find` where motion is wanted, `on_path`; then `end` when the picture is made, or
    `lose` when it was given up."""

    def __init__(self, device: Device, rows: SceneRows) -> None:
        self._device = device
        self._rows = rows
        self._views: OrderedDict[Hashable, _Seen] = OrderedDict()
        self._frame: _Frame | None = None
        self._size: tuple[object, float] = ((), 1.0)
        self._ids: Buffer | None = None
        self._commands: Buffer | None = None

    def begin(self, scene: Scene, view: View, origin: NDArray[np.float64]) -> FrameMotion:
        """Whether the view's frame before tells about this one; `origin`: of this frame, f8[3]."""
        seen = self._views.get(view.key)
        motion = FrameMotion()
        self._frame = _Frame(view, scene, origin, motion, state := self._state(scene, view))
        if seen is not None and self._follows(seen, scene, view):
            motion.known, motion.frames = True, seen.frames + 1
            motion.frozen = seen.frozen + 1 if seen.state == state else 0
        return motion

    def find(self, motion: FrameMotion) -> bool:
        """Where everything was, for motion vectors. Returns whether something solid that is seen moved by itself."""
        frame = self._frame
        assert frame is not None, "begin comes first"
        frame.wanted = True
        if not motion.known:
            return False
        view, origin, seen = frame.view, frame.origin, self._views[frame.view.key]
        motion.still = seen.camera.key() == view.camera.key()
        clip_now, motion.clip_before = (
            _clip(view.camera, view.aspect, origin),
            _clip(seen.camera, view.aspect, seen.origin),
        )
        shift = np.eye(4)
        shift[:3, 3] = origin - seen.origin
        motion.before_from_now = motion.clip_before @ shift @ np.linalg.inv(clip_now)
        if seen.rows is not None:
            self._moved(frame.scene, seen.rows, motion)
        return bool(motion.batches)

    def on_path(self, path: str) -> FrameMotion:
        """The frame's motion, now that its path is known: textures of before are not kept from path to path."""
        frame = self._frame
        assert frame is not None, "begin comes first"
        seen = self._views.get(frame.view.key)
        if seen is not None and seen.path != path and frame.motion.known:
            frame.motion = FrameMotion(jitter=frame.motion.jitter)
        return frame.motion

    def end(self, path: str) -> None:
        """The frame is made: it is the frame before of the next one."""
        frame = self._frame
        assert frame is not None, "begin comes first"
        key, view = frame.view.key, frame.view
        before = self._views.pop(key, None)
        kept = before.rows if before is not None else None
        self._views[key] = _Seen(
            weakref.ref(frame.scene), view.camera, (view.width, view.height), path, frame.origin, frame.motion.frames,
            frame.state, frame.motion.frozen,
            self._keep(frame.scene, kept) if frame.wanted else None,
        )  # fmt: skip
        while len(self._views) > VIEWS:
            self._views.popitem(last=False)

    def lose(self, key: Hashable) -> None:
        """The view's frames before tell nothing any more."""
        self._views.pop(key, None)

    def release(self) -> None:
        for buffer in (self._ids, self._commands):
            if buffer is not None:
                buffer.release()
        self._ids = self._commands = None

    def _state(self, scene: Scene, view: View) -> tuple[object, ...]:
        materials = self._rows.residency.materials
        return (
            _structure(scene), scene.transform_rev, scene.nodes.visible_rev, scene.morphs.rev, scene.lights.rev,
            materials.values_rev, self._rows.residency.structure_rev, self._rows.residency.effects.revision,
            repr(scene.environment), repr(scene.look), view.camera.key(), view.settings.key(),
        )  # fmt: skip

    # --- cuts ---

    def _follows(self, seen: _Seen, scene: Scene, view: View) -> bool:
        same = seen.scene() is scene and seen.size == (view.width, view.height)
        if not same or view.cut or view.seconds is None:
            return False
        return seen.camera.key() == view.camera.key() or not is_cut(seen.camera, view.camera, self._size_of(scene))

    def _size_of(self, scene: Scene) -> float:
        """Metres across the scene."""
        key = (id(scene), scene.transform_rev, scene.instances.drawn_rev)
        if self._size[0] != key:
            low, high = scene.bounds()
            size = float(np.linalg.norm(high - low))
            self._size = (key, size if np.isfinite(size) and size > 0.0 else np.inf)
        return self._size[1]

    # --- what moved ---

    def _keep(self, scene: Scene, kept: _Rows | None) -> _Rows:
        rows, morphs = self._rows, scene.morphs
        transforms = rows.transforms
        if kept is not None and kept.changes == transforms.changes and len(kept.transforms) == len(transforms.rows):
            copied = kept.transforms
        else:
            copied = transforms.rows.copy()
        return _Rows(
            _structure(scene), scene.transform_rev, morphs.rev, transforms.changes, copied, rows.palettes.rows,
            rows.morphs.rows, morphs.weights.copy() if kept is None or kept.morph_rev != morphs.rev else kept.weights,
            rows.morphs.offset_words,
        )  # fmt: skip

    def _moved(self, scene: Scene, before: _Rows, motion: FrameMotion) -> None:
        """Find what moved and is seen; have its rows of before beside those of now."""
        quiet = before.transform_rev == scene.transform_rev and before.morph_rev == scene.morphs.rev
        if quiet or before.structure != _structure(scene):
            return
        mask = self._rows.visible & self._moving(scene, before)
        template, runs = self._rows.draws.solid
        commands, ids, batches = chosen(template, runs, mask, 0, 0)
        if not batches:
            return
        rows = self._rows
        self._ids = fit_buffer(
            self._device, self._ids or self._device.buffer(16, label="moved ids"), ids.astype(np.uint32)
        )
        self._commands = fit_buffer(
            self._device, self._commands or self._device.buffer(20, label="moved commands"), commands
        )
        motion.batches, motion.ids, motion.commands = batches, self._ids, self._commands
        motion.nodes = rows.transforms.put_before(before.transforms)
        if len(before.palettes):
            motion.joints = rows.palettes.put_before(before.palettes)
        if len(before.morphs) and before.morph_words == rows.morphs.offset_words:
            motion.morphs = rows.morphs.put_before(before.morphs, len(scene.instances.node))

    def _moving(self, scene: Scene, before: _Rows) -> NDArray[np.bool_]:
        """bool[instances]: whose vertices are not where they were."""
        table, skins, morphs = scene.instances, scene.skins, scene.morphs
        nodes = scene.nodes.world_rev > before.transform_rev
        moving: NDArray[np.bool_] = nodes[np.maximum(table.node, 0)] & (table.node >= 0)
        if len(skins):
            bent = np.logical_or.reduceat(nodes[skins.joint], skins.first) | nodes[skins.node]
            skin = skins.of_nodes(table.node)
            moving = np.where(skin >= 0, np.append(bent, False)[skin], moving)
        if before.morph_rev != morphs.rev and len(before.weights) == len(morphs.weights) and len(morphs.weights):
            changed = np.logical_or.reduceat(before.weights != morphs.weights, morphs.first)
            moving |= np.append(changed, False)[morphs.of_nodes(table.node)]
        return moving


def is_cut(before: Camera, now: Camera, size: float) -> bool:
    """Whether a camera jumped: no picture of the one before tells about this one. `size`: of the scene, metres."""
    a, b = before.world_from_camera, now.world_from_camera
    if (before.ymag > 0.0) != (now.ymag > 0.0):
        return True
    zoom = now.ymag / before.ymag if now.ymag > 0.0 else np.tan(now.yfov / 2.0) / np.tan(before.yfov / 2.0)
    moved = float(np.linalg.norm(a[:3, 3] - b[:3, 3]))
    near = float(a[:3, 2] @ b[:3, 2]) > CUT_COSINE and moved < CUT_PART * size and 1.0 / CUT_ZOOM < zoom < CUT_ZOOM
    return not near


def _clip(camera: Camera, aspect: float, origin: NDArray[np.float64]) -> NDArray[np.float64]:
    """f8[4,4]: clip space from the world relative to `origin`."""
    pose = camera.world_from_camera.copy()
    pose[:3, 3] -= origin
    clip: NDArray[np.float64] = camera.clip_from_view(aspect) @ np.linalg.inv(pose)
    return clip


def _structure(scene: Scene) -> tuple[object, ...]:
    return (id(scene), scene.structure_rev, len(scene.nodes), len(scene.instances.node))
