"""Units of light: what a lamp's label says (lumen, watt, lux) as what the engine keeps (candela, lux, nit).

Every lamp is taken as shining evenly over the solid angle or area named. Source: CIE S 017:2020, "International
Lighting Vocabulary", 17-21; Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", table 3.
"""

from __future__ import annotations

import math

from engine.core.errors import InputError

#: the most lumen a watt of light can give, at 540 THz (BIPM, SI brochure 9, 2019: K_cd)
PEAK_EFFICACY = 683.0
#: lumen per watt of electricity: usual figures of lamps, for rough work
EFFICACY = {"incandescent": 15.0, "halogen": 20.0, "fluorescent": 80.0, "led": 110.0, "monochrome": PEAK_EFFICACY}

#: what `LightAsset.intensity` is in, by type
NATIVE_UNIT = {"directional": "lux", "point": "candela", "spot": "candela", "rectangle": "nit", "disk": "nit"}
#: in which units a light of each type can be given, its own first
UNITS = {
    "directional": ("lux",),
    "point": ("candela", "lumen", "watt", "lux at 1 m"),
    "spot": ("candela", "lumen", "watt", "lux at 1 m"),
    "rectangle": ("nit", "lumen", "watt", "candela"),
    "disk": ("nit", "lumen", "watt", "candela"),
}


def cone_solid_angle(inner: float, outer: float) -> float:
    """Return the steradians that a spot light fills, half angles in radians, weighted by its falloff.

    KHR_lights_punctual's falloff is the square of a line in cos(angle) between the cones: its integral is a third.
    """
    outer = max(outer, 0.0)
    cos_inner, cos_outer = math.cos(min(max(inner, 0.0), outer)), math.cos(outer)
    # 1 - cos as 2 sin^2(x/2): a narrow beam keeps its digits
    core = 2.0 * math.sin(0.5 * min(max(inner, 0.0), outer)) ** 2
    return 2.0 * math.pi * (core + (cos_inner - cos_outer) / 3.0)


def light_area(kind: str, width: float, height: float) -> float:
    """Return the area of a rectangle, or of a disk with these diameters, m^2."""
    return width * height * (math.pi / 4.0 if kind == "disk" else 1.0)


def lumen_per_unit(
    kind: str, *, inner: float = 0.0, outer: float = math.pi / 4, width: float = 1.0, height: float = 1.0,
    two_sided: bool = False,
) -> float:  # fmt: skip
    """Return the luminous flux (lm) of a light of one native unit: 4 pi for a point of 1 cd, pi A for a Lambertian
    surface of 1 nit (both sides: twice that). Raises InputError for a directional light, whose flux is endless."""
    if kind == "point":
        return 4.0 * math.pi
    if kind == "spot":
        return cone_solid_angle(inner, outer)
    if kind in ("rectangle", "disk"):
        return math.pi * light_area(kind, width, height) * (2.0 if two_sided else 1.0)
    raise InputError(f"a {kind} light has no luminous flux", hint="give its illuminance in lux")


def to_native(
    value: float, unit: str, kind: str, *, efficacy: float = EFFICACY["led"], inner: float = 0.0,
    outer: float = math.pi / 4, width: float = 1.0, height: float = 1.0, two_sided: bool = False,
) -> float:  # fmt: skip
    """Return the `LightAsset.intensity` of a light of `value` `unit` (one of UNITS[kind]).

    `efficacy`: lumen per watt, for "watt". Raises InputError where the unit does not fit the kind, or a light of no
    extent would have to be endlessly bright.
    """
    return value * _native_per(unit, kind, efficacy, inner, outer, width, height, two_sided)


def from_native(
    intensity: float, unit: str, kind: str, *, efficacy: float = EFFICACY["led"], inner: float = 0.0,
    outer: float = math.pi / 4, width: float = 1.0, height: float = 1.0, two_sided: bool = False,
) -> float:  # fmt: skip
    """Return what `to_native` was given. Raises as it does."""
    return intensity / _native_per(unit, kind, efficacy, inner, outer, width, height, two_sided)


def _native_per(
    unit: str, kind: str, efficacy: float, inner: float, outer: float, width: float, height: float, two_sided: bool
) -> float:
    if kind not in UNITS:
        raise InputError(f"unknown kind of light {kind!r}", hint=f"use {', '.join(UNITS)}")
    if unit not in UNITS[kind]:
        raise InputError(f"a {kind} light cannot be given in {unit}", hint=f"use {', '.join(UNITS[kind])}")
    if unit in (NATIVE_UNIT[kind], "lux at 1 m"):  # at one metre a candela gives a lux
        return 1.0
    if unit == "candela":  # straight ahead a surface has luminance times area
        return 1.0 / _extent(light_area(kind, width, height), kind)
    flux = lumen_per_unit(kind, inner=inner, outer=outer, width=width, height=height, two_sided=two_sided)
    return (efficacy if unit == "watt" else 1.0) / _extent(flux, kind)


def _extent(value: float, kind: str) -> float:
    if value <= 0.0:
        raise InputError(f"a {kind} light of no extent gives no lumen", hint="give it a size or an angle first")
    return value


def watts_of(lumen: float, lamp: str = "led") -> float:
    """Return the electric watts of a usual `lamp` (EFFICACY) of `lumen`. Raises InputError for an unknown one."""
    if lamp not in EFFICACY:
        raise InputError(f"unknown lamp {lamp!r}", hint=f"use {', '.join(EFFICACY)}")
    return lumen / EFFICACY[lamp]
