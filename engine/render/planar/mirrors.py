"""Mirrors: what the mirrors of a frame see, ready to be drawn, and the block that surfaces look them up by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Buffer, Device
from engine.math.frustum import planes_from_matrix
from engine.render.draw_commands import fit_buffer
from engine.render.draw_list import DrawList
from engine.render.draw_states import Batch
from engine.render.light_lists import LightLists
from engine.render.light_rows import LightBounds
from engine.render.planar.camera import mirrored_camera
from engine.render.planar.choice import Planar
from engine.render.planar.planes import MirrorPlane, MirrorPlanes
from engine.render.view import View
from engine.render.view_block import fill_camera
from engine.resources.residency import Residency
from engine.scene.culling import visible_instances
from engine.scene.scene import Scene

F8 = NDArray[np.float64]

#: planes that may mirror at once
MOST = 4
#: uniform binding of the block that surfaces read
PLANAR_BINDING = 2
BLOCK = layout(
    [
        Field("planes", "vec4", MOST),  # n, w relative to the view's origin: n.p + w = 0
        Field("near", "vec4"),  # metres off each plane that count as in it
        Field("mirrors", "uint"),
        Field("roughness", "float"),  # from which on it is none
        Field("levels", "float"),  # mips of the pictures, less one
        Field("per_pixel", "float"),  # texels of a picture to a pixel of the view
    ],
    rule="std140",
)
PRELUDE = BLOCK.block_glsl("PlanarBlock", PLANAR_BINDING, "planar") + "\n"
CLIP = layout([Field("plane", "vec4")], rule="std140")
#: the plane that cuts what is behind a mirror
CLIP_PRELUDE = CLIP.block_glsl("ClipBlock", 1, "mirror_clip") + "\n"


@dataclass(frozen=True, slots=True)
class Mirror:
    """What one mirror shows: a row of VIEW_LAYOUT, one of CLIP, and the batches of what it sees."""

    view_row: NDArray[np.void]
    clip_row: NDArray[np.void]
    opaque: list[Batch]
    blended: list[Batch]


class Mirrors:
    """`shown`: the mirrors of this frame, at most `Planar.mirrors`. `ids`, `commands`: what their batches draw."""

    def __init__(self, device: Device, residency: Residency) -> None:
        self._device = device
        self.planes = MirrorPlanes(residency)
        self.ids: Buffer = device.buffer(4, label="mirror ids")
        self.commands: Buffer = device.buffer(20, label="mirror commands")
        self.shown: list[Mirror] = []
        #: of the mirror that is drawn, where there are many lights
        self.lists = LightLists(device)
        self.light_bounds: LightBounds | None = None
        #: for surface shaders, by binding; empty where no frame has a mirror
        self.uniforms: Mapping[int, Any] = {}
        self._block: Buffer | None = None

    def update(
        self, scene: Scene, view: View, planar: Planar, draws: DrawList, block: NDArray[np.void], origin: F8,
        bounds: LightBounds, jitter: tuple[float, float] = (0.0, 0.0), *, everything: bool = False,
    ) -> None:  # fmt: skip
        """Find the mirrors of this frame and what they see. `block`: the view's row of VIEW_LAYOUT; `bounds`: what
        local lights reach; `jitter`: the pixels that the view is shifted by. `everything`: have a block also where
        there is none."""
        self.light_bounds = bounds
        found = self.planes.of_view(scene, view, planar.mirrors) if planar.wanted else []
        self.shown, self.uniforms = [], {}
        if not planar.wanted and not everything:
            return
        commands: list[NDArray[np.void]] = []
        ids: list[NDArray[np.uint32]] = []
        first_command = first_id = 0
        for mirror in found:
            seen = replace(view, camera=mirrored_camera(view.camera, mirror.plane))
            eye, forward = seen.camera.position, -seen.camera.world_from_camera[:3, 2]
            visible = _before(scene, seen, mirror)
            c, i, opaque, blended = draws.seen_from(scene, visible, eye, forward, first_command, first_id)
            commands.append(c)
            ids.append(i)
            first_command, first_id = first_command + len(c), first_id + len(i)
            self.shown.append(
                Mirror(_view_row(block, seen, planar, origin, jitter), _clip_row(mirror, origin), opaque, blended)
            )
        if first_id:
            self.ids = fit_buffer(self._device, self.ids, np.concatenate(ids))
            self.commands = fit_buffer(self._device, self.commands, np.concatenate(commands))
        self._write(view, planar, found, origin)

    def _write(self, view: View, planar: Planar, found: list[MirrorPlane], origin: F8) -> None:
        row = np.zeros((), BLOCK.dtype)
        for k, mirror in enumerate(found):
            row["planes"][k] = _at_origin(mirror.plane, origin)
            row["near"][k] = mirror.near
        width, height = planar.size(view.width, view.height)
        row["mirrors"], row["roughness"] = len(found), view.settings.planar_roughness
        row["levels"] = max(width, height).bit_length() - 1
        row["per_pixel"] = height / view.height
        data = row.tobytes()
        if self._block is None:
            self._block = self._device.buffer(data, label="mirrors")
        else:
            self._block.write(data)
        self.uniforms = {PLANAR_BINDING: self._block}

    def release(self) -> None:
        for buffer in (self.ids, self.commands, self._block):
            if buffer is not None:
                buffer.release()
        self.lists.release()
        self._block, self.uniforms = None, {}


def _before(scene: Scene, seen: View, mirror: MirrorPlane) -> NDArray[np.bool_]:
    """bool[instances]: what the eye behind the mirror sees before it."""
    visible = visible_instances(scene, planes_from_matrix(seen.camera.clip_from_world(seen.aspect)))
    table = scene.instances
    rows = np.flatnonzero(visible)
    ahead = table.world_center[rows] @ mirror.plane[:3] + mirror.plane[3] + table.world_radius[rows]
    visible[rows[ahead < 0.0]] = False
    visible[mirror.rows] = False
    return visible


def _view_row(
    block: NDArray[np.void], seen: View, planar: Planar, origin: F8, jitter: tuple[float, float]
) -> NDArray[np.void]:
    """As the view's, from behind the mirror; left and right are exchanged."""
    row = block.copy()
    fill_camera(row, seen, origin, (-jitter[0], jitter[1]))
    width, height = planar.size(seen.width, seen.height)
    row["size"] = width, height, 1.0 / width, 1.0 / height
    row["tiles"] = row["clusters"] = 0
    return row


def _clip_row(mirror: MirrorPlane, origin: F8) -> NDArray[np.void]:
    """A little of what is behind stays, so that what stands on the mirror touches its image."""
    row = np.zeros((), CLIP.dtype)
    plane = _at_origin(mirror.plane, origin)
    plane[3] += mirror.near
    row["plane"] = plane
    return row


def _at_origin(plane: F8, origin: F8) -> F8:
    return np.append(plane[:3], plane[3] + plane[:3] @ origin)
