"""A small path tracer: whole pictures of a scene, on arrays of paths. Unbiased, seeded, float64 sums.

    camera rays ─> nearest surface ─┬─ one light + one direction of the surroundings (next event estimation)
          ^                         └─ one direction of the surface ─> what it meets: light, surroundings or a surface
          └────── the next bounce; after ROULETTE bounces weak paths end by chance ──────────────────┘

Both ways to reach a light are weighed by the balance heuristic (Veach and Guibas 1995). A light without extent is only
reached by the first. All batches have generators of their own: what a picture is does not depend on how it was paused.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.experiments.truth.lamps import Lamps
from engine.experiments.truth.lobes import Lobes
from engine.experiments.truth.rays import Hits
from engine.experiments.truth.surfaces import surface_at
from engine.experiments.truth.traced_scene import TracedScene, camera_rays, free, lifted, nearest, nothing
from engine.render.camera import Camera

F8 = NDArray[np.float64]

#: part of every cached picture's key: raise it when the tracer's pictures change
VERSION = 2
#: paths at once
BATCH = 1 << 15
#: bounces that every path may have before chance ends it
ROULETTE = 3
#: so many lamps are all looked at from every place
FEW_LAMPS = 4


@dataclass(frozen=True, slots=True)
class Settings:
    """`bounces`: surfaces a path may meet before it has to reach a light; 1 = direct light only, and then surfaces
    that glow light nothing. `shadows`: off, nothing is in the way of light. `samples`: paths for each pixel."""

    samples: int = 64
    bounces: int = 1
    shadows: bool = True
    seed: int = 1


@dataclass(slots=True)
class Film:
    """`mean`: scene-linear radiance f8[h,w,3]; `halves`: the same of two disjoint halves of the paths."""

    mean: F8
    halves: tuple[F8, F8]
    samples: int

    @property
    def noise(self) -> float:
        """Root mean square error that chance leaves in `mean`: half of that between its independent halves."""
        return float(np.sqrt(np.mean((self.halves[0] - self.halves[1]) ** 2))) / 2.0


def trace(
    scene: TracedScene, camera: Camera, width: int, height: int, settings: Settings | None = None,
    progress: Callable[[float], bool] | None = None,
) -> Film | None:  # fmt: skip
    """The whole picture. `progress` hears how much of 1 is done; where it returns False the picture is given up."""
    steps = trace_steps(scene, camera, width, height, settings or Settings())
    while True:
        try:
            done = next(steps)
        except StopIteration as stop:
            film: Film = stop.value
            return film
        if progress is not None and not progress(done):
            return None


def trace_steps(
    scene: TracedScene, camera: Camera, width: int, height: int, settings: Settings
) -> Generator[float, None, Film]:
    """`trace` with a pause after every batch of paths; yields how much of 1 is done."""
    pixels = width * height
    # an even number of batches of each pixel, half of them for each half
    each = max(1, min(settings.samples // 2, BATCH // max(pixels, 1)))
    rounds = 2 * max(1, math.ceil(settings.samples / (2 * each)))
    sums = np.zeros((2, pixels, 3))
    blocks = np.array_split(np.arange(pixels), max(1, math.ceil(pixels / BATCH)))
    for number in range(rounds):
        for part, block in enumerate(blocks):
            rng = np.random.default_rng([settings.seed, number, part])
            at = np.repeat(block, each)
            start, direction = camera_rays(camera, width, height, at, rng.random((len(at), 2)))
            light = radiance(scene, start, direction, settings, rng)
            sums[number % 2, block] += light.reshape(len(block), each, 3).sum(axis=1)
            yield (number * len(blocks) + part + 1) / (rounds * len(blocks))
    total = rounds * each
    first, second = (np.asarray(s.reshape(height, width, 3) / (total // 2)) for s in sums)
    return Film((first + second) / 2.0, (first, second), total)


def radiance(scene: TracedScene, start: F8, direction: F8, settings: Settings, rng: np.random.Generator) -> F8:
    """One path each: an estimate of the radiance f8[n,3] that comes back along the rays."""
    total = np.zeros((len(start), 3))
    weight = np.ones((len(start), 3))
    alive = np.arange(len(start))
    chosen = np.zeros(len(start))  # density with which the last surface chose this direction; 0: the camera did
    for depth in range(settings.bounces + 1):
        last = depth == settings.bounces
        direct = last and settings.bounces == 1
        if direct and scene.surroundings.dark and not scene.lamps.area.size:
            break  # nothing but glowing surfaces could be met
        if settings.shadows or depth == 0:
            hits = nearest(scene, start, direction, rng, first=depth == 0)
        else:
            hits = nothing(len(start))
        met = hits.triangle >= 0
        total[alive] += weight * _met_lights(scene, start, direction, chosen, hits, depth)
        if direct:
            break
        rows = np.flatnonzero(met)
        if rows.size == 0:
            break
        s = surface_at(scene.triangles, scene.materials, hits, rows, direction[rows])
        alive, weight = alive[rows], weight[rows]
        own = np.where(s.unlit[:, None], s.base, s.glow)
        total[alive] += weight * own
        if last:
            break
        lit = np.flatnonzero(~s.unlit)
        alive, weight = alive[lit], weight[lit]
        lobes = Lobes.make(s.normal[lit], -direction[rows][lit], s.roughness[lit], s.f0[lit], s.f90[lit], s.albedo[lit])
        place, face = s.place[lit], s.face[lit]
        total[alive] += weight * _lamps(scene, place, face, lobes, settings, rng)
        total[alive] += weight * _sky(scene, place, face, lobes, settings, rng)
        out = lobes.sample(rng.random((len(lit), 3)))
        f, density = lobes.value(out)
        good = (density > 0.0) & (f > 0.0).any(axis=1)
        weight = weight * f / np.where(good, density, 1.0)[:, None]
        if depth >= ROULETTE:
            keep = np.clip(weight.max(axis=1), 0.05, 1.0)
            good &= rng.random(len(keep)) < keep
            weight /= keep[:, None]
        rows = np.flatnonzero(good)
        alive, weight, chosen = alive[rows], weight[rows], density[rows]
        start, direction = lifted(place[rows], face[rows], out[rows], scene.rays.lift), out[rows]
        if rows.size == 0:
            break
    return total


def _met_lights(scene: TracedScene, start: F8, d: F8, chosen: F8, hits: Hits, depth: int) -> F8:
    """What area lights and the surroundings send straight back along the rays, weighed against next event estimation.

    As in our own pictures lamps are not seen, and are in nobody's way."""
    out = np.zeros((len(d), 3))
    away = np.flatnonzero(hits.triangle < 0)
    if depth == 0:
        behind = scene.background
        out[away] = scene.surroundings.radiance(d[away]) if behind is None else behind
        return out
    for near, light, density in scene.lamps.met(start, d):
        share = chosen / np.maximum(chosen + density * lamp_chance(scene.lamps), 1e-300)
        out += light * (share * (near < hits.distance))[:, None]
    if away.size and not scene.surroundings.dark:
        share = chosen[away] / (chosen[away] + scene.surroundings.density(d[away]))
        out[away] += scene.surroundings.radiance(d[away]) * share[:, None]
    return out


def _lamps(scene: TracedScene, place: F8, face: F8, lobes: Lobes, settings: Settings, rng: np.random.Generator) -> F8:
    """The lamps' light reflected: of all of them where they are few, else of one for each place, chosen evenly."""
    out = np.zeros((len(place), 3))
    count, chance = scene.lamps.count, lamp_chance(scene.lamps)
    tries = [np.full(len(place), i) for i in range(count)] if chance == 1.0 else [rng.integers(0, count, len(place))]
    for which in tries:
        got = scene.lamps.sample(which, place, rng.random((len(place), 2)))
        f, density = lobes.value(got.towards)
        pick = got.density * chance
        # a light without extent is found by no other way
        scale = np.where(got.density > 0.0, 1.0 / np.maximum(pick + density, 1e-300), 1.0 / chance)
        light = f * got.light * scale[:, None]
        rows = np.flatnonzero((light > 0.0).any(axis=1))
        if settings.shadows:
            light[rows] *= free(scene, place[rows], face[rows], got.towards[rows], got.distance[rows], rng)[:, None]
        out[rows] += light[rows]
    return out


def lamp_chance(lamps: Lamps) -> float:
    """With which a lamp is looked at from a place."""
    return 1.0 if lamps.count <= FEW_LAMPS else 1.0 / lamps.count


def _sky(scene: TracedScene, place: F8, face: F8, lobes: Lobes, settings: Settings, rng: np.random.Generator) -> F8:
    """One direction of the surroundings for each place: its light reflected."""
    out = np.zeros((len(place), 3))
    if scene.surroundings.dark:
        return out
    d = scene.surroundings.sample(rng.random((len(place), 3)))
    f, density = lobes.value(d)
    pick = scene.surroundings.density(d)
    light = f * scene.surroundings.radiance(d) / (pick + density)[:, None]
    rows = np.flatnonzero((light > 0.0).any(axis=1))
    if settings.shadows:
        light[rows] *= free(scene, place[rows], face[rows], d[rows], np.full(len(rows), np.inf), rng)[:, None]
    out[rows] = light[rows]
    return out
