"""What the BRDF explorer and `lucarna inspect --brdf` plot of a material: curves, computed in float64 without a GPU."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.material import MaterialAsset
from engine.materials.effect import Effect
from engine.materials.pairing import pairing
from engine.math.lobes import Lobe, lobe_of

F8 = NDArray[np.float64]

#: decades that a logarithmic lobe shows
DECADES = 4.0


@dataclass(frozen=True, slots=True)
class LobePlots:
    """`polar`: part -> f n.l by `out` (radians, negative towards the light); `albedo`: part -> by `theta` (degrees).
    `d`: by the half vector's angle; `v`, `f`: by `theta`, V at n.v = n.l (`g`: as G), F in red, green, blue.
    `notes`: what is not shown as it is drawn; `pairs`: (what is wrong, what would match)."""

    incidence: float
    out: F8
    polar: Mapping[str, F8]
    theta: F8
    albedo: Mapping[str, F8]
    furnace: F8
    d: F8
    v: F8
    f: F8
    notes: tuple[str, ...] = ()
    pairs: tuple[tuple[str, str], ...] = ()

    @property
    def total(self) -> F8:
        """Albedo of all parts."""
        result: F8 = np.sum(list(self.albedo.values()), axis=0)
        return result

    @property
    def g(self) -> F8:
        """Masking and shadowing, V 4 n.v n.l."""
        result: F8 = self.v * 4.0 * np.cos(np.radians(self.theta)) ** 2
        return result

    @property
    def furnace_error(self) -> tuple[float, float]:
        """(least, greatest) of the specular lobe's albedo with F = 1, less 1."""
        return float(self.furnace.min() - 1.0), float(self.furnace.max() - 1.0)

    def radius(self, part: str, *, logarithmic: bool) -> F8:
        """`polar` as a radius in [0, 1]: linear to the greatest of the sum, or over DECADES below it."""
        most = max(float(np.sum(list(self.polar.values()), axis=0).max()), 1e-12)
        value = self.polar[part] / most
        if not logarithmic:
            return value
        result: F8 = np.clip(1.0 + np.log10(np.maximum(value, 1e-12)) / DECADES, 0.0, 1.0)
        return result


def plots_of(
    effect: Effect, material: MaterialAsset, values: Mapping[str, Any], incidence: float, *, across: bool = False,
    steps: int = 181,
) -> LobePlots | None:  # fmt: skip
    """The curves of a material with these parameter values, lit at `incidence` radians; None where it has no lobe."""
    defaults = {param.name: param.default for param in effect.params}
    lobe = lobe_of(effect.name, material.features, {**defaults, **values}, across=across)
    if lobe is None:
        return None
    notes = []
    if material.textures:
        notes.append(f"textures are taken as white: {', '.join(sorted(material.textures))}")
    if "iridescence" in material.features:
        notes.append("the film by its angle to the half vector; drawn by that to the viewer")
    return _plots(
        lobe,
        incidence,
        tuple(notes),
        tuple(pairing(material.features, effect.name, {**defaults, **values}.get("roughness"))),
        steps,
    )


def _plots(
    lobe: Lobe, incidence: float, notes: tuple[str, ...], pairs: tuple[tuple[str, str], ...], steps: int
) -> LobePlots:
    # closer together about the mirror direction, where a smooth lobe is a needle
    even = np.linspace(-1.0, 1.0, steps)
    near = incidence + np.sign(even) * np.abs(even) ** 3 * 0.5
    out = np.unique(np.concatenate([even * (0.5 * math.pi - 1e-3), near[np.abs(near) < 0.5 * math.pi - 1e-3]]))
    theta = np.radians(np.linspace(0.0, 88.0, 23))
    cosine = np.cos(theta)
    half = np.radians(np.linspace(0.0, 90.0, 181))
    return LobePlots(
        incidence, out, lobe.slice(incidence, out), np.degrees(theta), lobe.albedo(theta, 32), lobe.furnace(theta, 48),
        lobe.d(half), lobe.v(cosine, cosine, np.ones_like(cosine), cosine), lobe.f(cosine), notes, pairs,
    )  # fmt: skip


def half_angles() -> F8:
    """Degrees that `d` is over."""
    return np.linspace(0.0, 90.0, 181)
