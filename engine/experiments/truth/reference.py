"""Path-traced pictures out of the cache: by a hash of all that paths meet, of camera, settings, seed, version."""

from __future__ import annotations

import hashlib
import importlib.metadata
from collections.abc import Generator
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.experiments.truth.path_tracer import VERSION, Film, Settings, trace_steps
from engine.experiments.truth.traced_scene import TracedScene
from engine.render.camera import Camera

if TYPE_CHECKING:
    from engine.experiments.harness.context import Context


def content_hash(scene: TracedScene) -> str:
    """SHA-256 over the triangles, materials with their texels, lights and surroundings."""
    digest = hashlib.sha256()
    t, m = scene.triangles, scene.materials
    for array in (
        t.corners, t.normals, t.uv0, t.uv1, t.tangents, t.colors, t.material, m.base, m.emissive, m.specular_color,
        m.mode, m.unlit, m.double_sided, *m.values.values(), scene.lamps.rows, scene.surroundings.faces,
        scene.background if scene.background is not None else np.zeros(0), *scene.surroundings.turn,
    ):  # fmt: skip
        digest.update(np.ascontiguousarray(array).tobytes())
    for (material, slot), lookup in sorted(m.lookups.items()):
        digest.update(f"{material} {slot} {lookup.said}".encode())
        digest.update(lookup.pixels.tobytes())
    return digest.hexdigest()


def picture(
    ctx: Context, name: str, scene: TracedScene, camera: Camera, width: int, height: int, settings: Settings
) -> Generator[tuple[float, str], None, Film]:
    """A path-traced picture, from the cache where it is there; else traced in slices: yields how much of 1 is done,
    and what is being done."""
    key: dict[str, Any] = {
        "tracer": VERSION, "embreex": importlib.metadata.version("embreex"), "scene": content_hash(scene),
        "camera": repr((camera.world_from_camera.tolist(), camera.yfov, camera.ymag)),
        "size": [width, height], "samples": settings.samples, "bounces": settings.bounces,
        "shadows": settings.shadows,
    }  # fmt: skip
    found = ctx.references.find(name, key, seed=settings.seed)
    if found is None:
        steps = trace_steps(scene, camera, width, height, settings)
        while True:
            try:
                done = next(steps)
            except StopIteration as stop:
                film: Film = stop.value
                break
            yield done, f"path tracing {name}, {done:.0%}"
        ctx.references.put(
            name, key, {"first": film.halves[0], "second": film.halves[1], "samples": film.samples,
                        "noise_floor": film.noise}, seed=settings.seed,
        )  # fmt: skip
        return film
    halves = (found["first"], found["second"])
    return Film((halves[0] + halves[1]) / 2.0, halves, int(found["samples"]))
