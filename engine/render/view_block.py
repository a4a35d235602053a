"""The uniform block that every shader sees, generated from one declaration."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.gpu.glsl_layout import Field, layout
from engine.render.camera import Camera
from engine.render.light_rows import MAX_SUNS, LightRows
from engine.render.view import View

#: shadow maps of the first sun
MAX_CASCADES = 8

VIEW_LAYOUT = layout(
    [
        Field("clip_from_origin", "mat4"),  # origin-relative world -> clip
        Field("view_from_origin", "mat4"),  # origin-relative world -> view
        Field("camera", "vec4"),  # perspective: xyz = position rel. to the origin, w = 1; else direction back, w = 0
        Field("ray_center", "vec4"),  # the view ray at the middle of the picture, world
        Field("ray_right", "vec4"),  # added to it per ndc x
        Field("ray_up", "vec4"),  # added to it per ndc y
        Field("environment", "vec4"),  # cos, sin of the rotation, intensity, mips
        Field("sh", "vec4", 9),  # irradiance / pi as SH
        Field("size", "vec4"),  # width, height, 1/width, 1/height
        Field("suns", "vec4", 2 * MAX_SUNS),  # direction (where it shines), illuminance; for each directional light
        Field("counts", "uvec4"),  # lights in the buffer, suns
        # where a pixel is (lib/position.glsl). Perspective: base + (z + x ndc.x + y ndc.y) * near / depth, base.w =
        # near; else base + x ndc.x + y ndc.y + z (1 - depth)
        Field("place_base", "vec4"),
        Field("place_x", "vec4"),
        Field("place_y", "vec4"),
        Field("place_z", "vec4"),
        Field("tiles", "uvec4"),  # of light lists: log2 of the size, entries there is room for, columns, rows
        Field("clusters", "vec4"),  # slice = log2(view depth) * x + y; z slices, 0 where lists are of tiles
        Field("shadow_axes", "vec4", 3),  # world -> light space: right, up, towards the sun
        Field("shadow", "vec4"),  # cascades, filter radius in texels, tangent of the sun's half angle, 1 / map size
        # view depth where shadows begin to fade, 1 / how long they do; moments: exponent, part of light that is none
        Field("shadow_fade", "vec4"),
        # per cascade: x, y (light space, rel. to the origin), 1 / half width, texel in m; bottom, 1 / depth, half width
        Field("shadow_cascades", "vec4", 2 * MAX_CASCADES),
    ],
    rule="std140",
)


def fill_view_block(
    view: View, origin: NDArray[np.float64], irradiance_sh: NDArray[np.float32], environment_mips: int,
    environment_intensity: float, environment_rotation: float, lights: LightRows,
    jitter: tuple[float, float] = (0.0, 0.0),
) -> NDArray[np.void]:  # fmt: skip
    """One row of VIEW_LAYOUT. `environment_rotation` in radians; `jitter`: pixels that the picture is shifted right and
    down by."""
    row = np.zeros((), VIEW_LAYOUT.dtype)
    fill_camera(row, view, origin, jitter)
    row["environment"] = (
        math.cos(environment_rotation), math.sin(environment_rotation), environment_intensity, environment_mips,
    )  # fmt: skip
    row["sh"] = irradiance_sh
    row["suns"] = lights.suns.reshape(-1, 4)
    row["counts"] = (lights.count, lights.sun_count, 0, 0)
    return row


def fill_camera(
    row: NDArray[np.void], view: View, origin: NDArray[np.float64], jitter: tuple[float, float] = (0.0, 0.0)
) -> None:
    """Write the fields of a row of VIEW_LAYOUT that say where from and how the scene is seen."""
    camera = view.camera
    world_from_camera = camera.world_from_camera
    origin_from_camera = world_from_camera.copy()
    origin_from_camera[:3, 3] -= origin
    view_from_origin = np.linalg.inv(origin_from_camera)
    # what is shifted is seen where the pixel less the shift would see it
    shift = np.array([2.0 * jitter[0] / view.width, -2.0 * jitter[1] / view.height])
    moved = np.eye(4)
    moved[:2, 3] = shift
    clip_from_view = moved @ camera.clip_from_view(view.aspect)
    row["clip_from_origin"] = (clip_from_view @ view_from_origin).T
    row["view_from_origin"] = view_from_origin.T
    right, up, back = world_from_camera[:3, 0], world_from_camera[:3, 1], world_from_camera[:3, 2]
    if camera.ymag > 0.0:
        row["camera"] = (*back, 0.0)
        row["ray_center"] = (*-back, 0.0)
        row["ray_right"] = row["ray_up"] = 0.0
    else:
        half_height = math.tan(camera.yfov / 2)
        row["camera"] = (*origin_from_camera[:3, 3], 1.0)
        row["ray_center"] = (*-back, 0.0)
        row["ray_right"] = (*(right * half_height * view.aspect), 0.0)
        row["ray_up"] = (*(up * half_height), 0.0)
    row["size"] = (view.width, view.height, 1.0 / view.width, 1.0 / view.height)
    _fill_place(row, camera, origin_from_camera, view.aspect)
    if jitter != (0.0, 0.0):
        row["ray_center"] -= shift[0] * row["ray_right"] + shift[1] * row["ray_up"]
        place = "place_base" if camera.ymag > 0.0 else "place_z"
        row[place] -= shift[0] * row["place_x"] + shift[1] * row["place_y"]


def _fill_place(row: NDArray[np.void], camera: Camera, origin_from_camera: NDArray[np.float64], aspect: float) -> None:
    """The fields that lead from a pixel and its depth to a point relative to the origin."""
    right, up, back, eye = origin_from_camera[:3].T
    if camera.ymag > 0.0:
        # depth falls from 1 at znear to 0 at zfar
        row["place_base"] = (*(eye - back * camera.znear), 0.0)
        row["place_x"] = (*(right * camera.ymag * aspect), 0.0)
        row["place_y"] = (*(up * camera.ymag), 0.0)
        row["place_z"] = (*(-back * (camera.zfar - camera.znear)), 0.0)
    else:
        half_height = math.tan(camera.yfov / 2)
        row["place_base"] = (*eye, camera.znear)
        row["place_x"] = (*(right * half_height * aspect), 0.0)
        row["place_y"] = (*(up * half_height), 0.0)
        row["place_z"] = (*-back, 0.0)
