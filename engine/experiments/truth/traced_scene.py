"""What paths meet: triangles, materials, lights and surroundings; and rays that pass what lets them through."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.experiments.truth.lamps import Lamps, lamps_of
from engine.experiments.truth.rays import Hits, Rays
from engine.experiments.truth.surfaces import OPAQUE, Materials, Surface, materials_of, passes_through, surface_at
from engine.experiments.truth.surroundings import Surroundings
from engine.experiments.truth.triangles import Triangles, triangles_of
from engine.render.camera import Camera
from engine.render.environments import usable
from engine.render.settings import RenderSettings

if TYPE_CHECKING:
    from engine.experiments.harness.context import OpenScene

F8 = NDArray[np.float64]

#: holes and glasses that a ray may pass
LAYERS = 16


@dataclass(slots=True)
class TracedScene:
    """All that paths meet. `background`: radiance behind everything that the camera sees, f8[3]; None: surroundings."""

    triangles: Triangles
    rays: Rays
    materials: Materials
    lamps: Lamps
    surroundings: Surroundings
    background: F8 | None = None
    #: whether rays can pass anything
    holes: bool = False
    notes: list[str] = field(default_factory=list)


def traced(scene: OpenScene, settings: RenderSettings | None = None) -> TracedScene:
    """The scene as it is posed now, under the environment that it is drawn in. Raises LucarnaError without embreex."""
    settings = settings or RenderSettings()
    tables, residency = scene.scene, scene.residency
    tables.update()
    triangles = triangles_of(tables, residency)
    materials = materials_of(residency, residency.device, triangles.material)
    environment = usable(tables.environment)
    rotation = math.radians(settings.environment_rotation)
    world = tables.lights.world()
    lit = environment.kind != "none"
    intensity = environment.intensity * settings.environment_intensity if lit else 0.0
    faces = scene.environment_faces() if intensity > 0.0 else np.zeros((6, 1, 1, 3), np.float32)
    notes = list(materials.notes)
    if (world["profile"] >= 0).any():
        notes.append("lights with an IES profile shine evenly here")
    lamps = lamps_of(world, environment, rotation)
    if environment.sun_illuminance > 0.0 and settings.sun_intensity != 1.0:
        lamps.rows["radiant"][0] *= settings.sun_intensity
    shown = environment.background if settings.background == "scene" else settings.background
    return TracedScene(
        triangles, Rays(triangles.corners), materials, lamps,
        Surroundings(faces * intensity, environment.rotation + rotation),
        None if shown == "environment" and lit else np.array(environment.background_color, np.float64),
        bool((materials.mode[np.unique(triangles.material)] != OPAQUE).any()), notes,
    )  # fmt: skip


def camera_rays(camera: Camera, width: int, height: int, pixel: NDArray[np.int64], jitter: F8) -> tuple[F8, F8]:
    """Start and unit direction [n,3], world, through the places `jitter` [n,2] in [0, 1) of pixels (row by row)."""
    x = ((pixel % width) + jitter[:, 0]) / width * 2.0 - 1.0
    y = 1.0 - ((pixel // width) + jitter[:, 1]) / height * 2.0
    pose = camera.world_from_camera
    aspect = width / height
    if camera.ymag > 0.0:
        local = np.stack([x * camera.ymag * aspect, y * camera.ymag, np.zeros_like(x)], axis=1)
        start = pose[:3, 3] + local @ pose[:3, :3].T
        return start, np.broadcast_to(-pose[:3, 2], start.shape).copy()
    tangent = math.tan(camera.yfov / 2.0)
    d = np.stack([x * tangent * aspect, y * tangent, -np.ones_like(x)], axis=1) @ pose[:3, :3].T
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return np.broadcast_to(pose[:3, 3], d.shape).copy(), d


def surface_seen(scene: TracedScene, camera: Camera, width: int, height: int) -> tuple[NDArray[np.bool_], Surface]:
    """Where pixels' middles meet a surface, bool[h*w], and that surface for each of them."""
    at = np.arange(width * height)
    start, d = camera_rays(camera, width, height, at, np.full((len(at), 2), 0.5))
    hits = nearest(scene, start, d, np.random.default_rng(0), first=True)
    met = hits.triangle >= 0
    rows = np.flatnonzero(met)
    return met, surface_at(scene.triangles, scene.materials, hits, rows, d[rows])


def nearest(
    scene: TracedScene, start: F8, d: F8, rng: np.random.Generator, *, first: bool, limit: F8 | None = None
) -> Hits:
    """The first thing that each ray does not pass. `first`: from the camera, which does not see backs of one-sided
    surfaces."""
    hits = scene.rays.nearest(start, d, limit)
    if len(scene.triangles) == 0 or not (scene.holes or first):
        return hits
    at, rows = start.copy(), np.arange(len(start))
    gone = np.zeros(len(start))
    for _ in range(LAYERS):
        sub = Hits(hits.triangle[rows], hits.u[rows], hits.v[rows], hits.distance[rows])
        through = passes_through(scene.triangles, scene.materials, sub, rng.random(len(rows))) if scene.holes else (
            np.zeros(len(rows), bool)
        )  # fmt: skip
        if first:
            met = sub.triangle >= 0
            back = np.einsum("ij,ij->i", scene.triangles.face[sub.triangle], d[rows]) >= 0.0
            through |= met & back & ~scene.materials.double_sided[scene.triangles.material[sub.triangle]]
        rows = rows[through]
        if rows.size == 0:
            break
        step = hits.distance[rows] + scene.rays.lift
        gone[rows] += step
        at[rows] += step[:, None] * d[rows]
        again = scene.rays.nearest(at[rows], d[rows], None if limit is None else limit[rows] - gone[rows])
        hits.triangle[rows], hits.u[rows], hits.v[rows] = again.triangle, again.u, again.v
        hits.distance[rows] = again.distance
    else:
        hits.triangle[rows] = -1
    if gone.any():
        hits.distance[:] += gone
    return hits


def free(scene: TracedScene, place: F8, face: F8, d: F8, distance: F8, rng: np.random.Generator) -> F8:
    """1 where nothing is between the places and what is `distance` (m) away along d, else 0."""
    if len(place) == 0:
        return np.ones(0)
    lift = scene.rays.lift
    start = lifted(place, face, d, lift)
    limit = np.maximum(distance * (1.0 - 1e-6) - 2.0 * lift, 0.0)
    if not scene.holes:
        return np.asarray(~scene.rays.blocked(start, d, limit), np.float64)
    hits = nearest(scene, start, d, rng, first=False, limit=limit)
    return np.asarray(hits.triangle < 0, np.float64)


def nothing(count: int) -> Hits:
    """As many rays that meet nothing."""
    return Hits(np.full(count, -1, np.int32), np.zeros(count), np.zeros(count), np.full(count, np.inf))


def lifted(place: F8, face: F8, d: F8, lift: float) -> F8:
    """Lifted off the triangle to the side that the ray leaves to."""
    side = np.where(np.einsum("ij,ij->i", face, d) >= 0.0, lift, -lift)
    result: F8 = place + face * side[:, None]
    return result
