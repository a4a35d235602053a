"""A scene's lights as the path tracer samples them: suns, points, spots, rectangles and disks, in arrays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from engine.assets.environment_dds import sun_direction
from engine.assets.scene import EnvironmentAsset
from engine.scene.lights import FIRST_AREA, LIGHT_TYPES, WORLD_LIGHT

F8 = NDArray[np.float64]

DIRECTIONAL, SPOT, DISK = (LIGHT_TYPES.index(name) for name in ("directional", "spot", "disk"))


@dataclass(slots=True)
class LampSamples:
    """What arrives at n places: unit `towards` the light [n,3] and `distance` (m; inf from suns), `light` [n,3]:
    irradiance across the ray of lights without extent (`density` 0), else radiance, sampled with `density` (1/sr)."""

    towards: F8
    distance: F8
    light: F8
    density: F8


class Lamps:
    """`rows`: WORLD_LIGHT."""

    def __init__(self, rows: NDArray[np.void]) -> None:
        self.rows = rows
        self.count = len(rows)
        self.area = np.flatnonzero(rows["type"] >= FIRST_AREA)
        self._out = rows["direction"].astype(np.float64)
        self._right = rows["right"].astype(np.float64)
        self._up = np.cross(-self._out, self._right)
        self._half = rows["half_size"].astype(np.float64)
        disk = np.where(rows["type"] == DISK, np.pi / 4.0, 1.0)
        self._surface = 4.0 * self._half.prod(axis=1) * disk  # m^2

    def sample(self, which: NDArray[np.int64], places: F8, u: F8) -> LampSamples:
        """What lamp which[i] brings to places[i] [n,3]; `u` [n,2] in [0, 1) chooses a place on those with area."""
        rows = self.rows[which]
        kind = rows["type"]
        target = rows["position"].astype(np.float64)
        extended = kind >= FIRST_AREA
        if extended.any():
            xy = _in_square_or_disk(u, kind == DISK) * self._half[which]
            target = target + xy[:, :1] * self._right[which] + xy[:, 1:] * self._up[which]
        to = target - places
        d2 = np.maximum(np.einsum("ij,ij->i", to, to), 1e-24)
        distance = np.sqrt(d2)
        towards = to / distance[:, None]
        sun = kind == DIRECTIONAL
        towards = np.where(sun[:, None], -self._out[which], towards)
        facing = -np.einsum("ij,ij->i", towards, self._out[which])
        strength = np.where(sun | extended, 1.0, 1.0 / np.maximum(d2, 1e-12))
        strength *= np.where(sun, 1.0, self._window(which, places, distance))
        inner, outer = rows["cos_inner"].astype(np.float64), rows["cos_outer"].astype(np.float64)
        cone = np.clip((facing - outer) / np.maximum(inner - outer, 1e-4), 0.0, 1.0)  # KHR_lights_punctual
        strength *= np.where(kind == SPOT, cone * cone, 1.0)
        strength *= np.where(extended & (facing <= 0.0) & ~rows["two_sided"], 0.0, 1.0)
        density = np.where(extended, d2 / np.maximum(np.abs(facing) * self._surface[which], 1e-30), 0.0)
        light = rows["radiant"].astype(np.float64) * strength[:, None]
        return LampSamples(towards, np.where(sun, np.inf, distance), light, density)

    def met(self, start: F8, direction: F8) -> Iterator[tuple[F8, F8, F8]]:
        """Each area light as the rays meet it: distance f8[n] (inf: not), radiance [n,3], the density of `sample`."""
        for i in self.area.tolist():
            row = self.rows[i]
            across = direction @ self._out[i]
            to = row["position"] - start
            with np.errstate(divide="ignore", invalid="ignore"):
                t = to @ self._out[i] / across
                place = t[:, None] * direction - to
                x = place @ self._right[i] / self._half[i, 0]
                y = place @ self._up[i] / self._half[i, 1]
                inside = x * x + y * y <= 1.0 if row["type"] == DISK else np.maximum(np.abs(x), np.abs(y)) <= 1.0
            met = inside & (t > 0.0) & np.isfinite(t) & ((across < 0.0) | bool(row["two_sided"]))
            t = np.where(met, t, np.inf)
            window = np.where(met, self._window(np.full(len(t), i), start, np.where(met, t, 0.0)), 0.0)
            density = np.where(met, t, 0.0) ** 2 / np.where(met, np.abs(across) * self._surface[i], 1.0)
            yield t, row["radiant"].astype(np.float64) * window[:, None], density

    def _window(self, which: NDArray[np.int64], places: F8, distance: F8) -> F8:
        """Lagarde and de Rousiers 2014, "Moving Frostbite to PBR", listing 2: smooth to zero at the range, which is
        counted from an area light's nearest point."""
        reach = self.rows["range"][which].astype(np.float64)
        near2 = distance * distance
        extended = (self.rows["type"][which] >= FIRST_AREA) & (reach > 0.0)
        if extended.any():
            to = places - self.rows["position"][which]
            x, y = np.einsum("ij,ij->i", to, self._right[which]), np.einsum("ij,ij->i", to, self._up[which])
            z = np.einsum("ij,ij->i", to, self._out[which])
            hx, hy = self._half[which].T
            out = np.maximum(np.abs(x) - hx, 0.0) ** 2 + np.maximum(np.abs(y) - hy, 0.0) ** 2 + z * z
            near2 = np.where(extended, out, near2)
        x2 = near2 / np.maximum(reach * reach, 1e-30)
        return np.where(reach > 0.0, np.clip(1.0 - x2 * x2, 0.0, 1.0) ** 2, 1.0)


def _in_square_or_disk(u: F8, disk: NDArray[np.bool_]) -> F8:
    """[-1, 1]^2, or even over the unit disc where `disk`."""
    square = u * 2.0 - 1.0
    radius, turn = np.sqrt(u[:, 0]), 2.0 * np.pi * u[:, 1]
    round_ = np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1)
    return np.where(disk[:, None], round_, square)


def lamps_of(world: NDArray[np.void], environment: EnvironmentAsset, rotation: float = 0.0) -> Lamps:
    """The lights WORLD_LIGHT of a scene with its environment's sun, which `rotation` (radians, the view's) turns."""
    if not environment.sun_illuminance > 0.0:
        return Lamps(world)
    sun = np.zeros(1, WORLD_LIGHT)
    turned = environment.sun_azimuth + environment.rotation + rotation
    sun["direction"] = -sun_direction(replace(environment, sun_azimuth=turned))
    sun["radiant"] = environment.sun_illuminance
    sun["profile"] = -1
    return Lamps(np.concatenate([sun, world]))
