"""Units of light against figures that can be worked out by hand, and colours of black bodies against the CIE's."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.math import photometry
from engine.math.blackbody import black_body, planckian_xy, planckian_xyz, rec709_of
from engine.math.color import luminance


@pytest.mark.parametrize(
    ("value", "unit", "kind", "shape", "native"),
    [
        (4.0 * math.pi, "lumen", "point", {}, 1.0),
        (1521.0, "lumen", "point", {}, 121.037),  # a 100 W incandescent bulb
        (10.0, "watt", "point", {"efficacy": 100.0}, 1000.0 / (4.0 * math.pi)),
        (683.0, "watt", "point", {"efficacy": 1.0}, 683.0 / (4.0 * math.pi)),
        (7.0, "lux at 1 m", "spot", {}, 7.0),
        (2.0 * math.pi, "lumen", "spot", {"inner": math.pi / 2, "outer": math.pi / 2}, 1.0),  # a hemisphere
        (math.pi, "lumen", "rectangle", {}, 1.0),  # a Lambertian square metre
        (math.pi, "lumen", "rectangle", {"two_sided": True}, 0.5),
        (math.pi**2 / 4.0, "lumen", "disk", {}, 1.0),
        (6.0, "candela", "rectangle", {"width": 2.0, "height": 3.0}, 1.0),
        (5.0, "lux", "directional", {}, 5.0),
    ],
)
def test_known_lamps(value: float, unit: str, kind: str, shape: dict[str, float], native: float) -> None:
    found = photometry.to_native(value, unit, kind, **shape)
    assert found == pytest.approx(native, rel=1e-5)
    assert photometry.from_native(found, unit, kind, **shape) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(("inner", "outer"), [(0.0, 0.3), (0.2, 0.9), (0.7, 0.7), (1e-4, 2e-4)])
def test_a_cone_fills_what_its_falloff_says(inner: float, outer: float) -> None:
    angle = (np.arange(400_000) + 0.5) / 400_000 * outer
    span = math.cos(inner) - math.cos(outer)
    falloff = np.clip((np.cos(angle) - math.cos(outer)) / span, 0, 1) ** 2 if span > 0 else np.ones_like(angle)
    truth = float((falloff * np.sin(angle)).sum() * 2 * math.pi * outer / 400_000)
    assert photometry.cone_solid_angle(inner, outer) == pytest.approx(truth, rel=1e-5)


@pytest.mark.parametrize(
    ("value", "unit", "kind", "shape"),
    [
        (1.0, "lumen", "directional", {}),
        (1.0, "parsec", "point", {}),
        (1.0, "lumen", "laser", {}),
        (1.0, "lumen", "disk", {"width": 0.0}),
        (1.0, "lumen", "spot", {"outer": 0.0}),
    ],
)
def test_what_cannot_be_converted_is_refused(value: float, unit: str, kind: str, shape: dict[str, float]) -> None:
    with pytest.raises(InputError):
        photometry.to_native(value, unit, kind, **shape)
    with pytest.raises(InputError, match="candle"):
        photometry.watts_of(1.0, "candle")


@pytest.mark.parametrize(
    ("kelvin", "xy"),
    [(2856, (0.4476, 0.4074)), (6504, (0.3134, 0.3236)), (10_000, (0.2807, 0.2884)), (1e9, (0.2399, 0.2341))],
)
def test_chromaticity_of_black_bodies(kelvin: float, xy: tuple[float, float]) -> None:
    """CIE 15:2018, illuminant A and the Planckian locus; our fit of the observer is 0.0015 off."""
    assert planckian_xy(kelvin) == pytest.approx(xy, abs=1.6e-3)


def test_black_body_is_a_colour_of_luminance_one() -> None:
    kelvin = np.array([math.nan, -5.0, 0.0, 1e-6, 500.0, 1900.0, 2700.0, 6500.0, 1e5, 1e9, math.inf])
    rgb = black_body(kelvin)
    assert np.isfinite(rgb).all()
    assert (rgb >= 0.0).all()
    assert luminance(rgb) == pytest.approx(1.0)
    assert rgb[6, 0] > 1.5 * rgb[6, 1] > 1.5 * rgb[6, 2], "a bulb is orange"
    assert rgb[-2, 2] > rgb[-2, 1] > rgb[-2, 0], "what is very hot is blue"
    assert np.abs(rgb[7] - 1.0).max() < 0.05


def test_the_table_is_the_sum() -> None:
    kelvin = np.geomspace(500.0, 1e6, 501)
    assert np.abs(black_body(kelvin) - rec709_of(planckian_xyz(kelvin))).max() < 1e-5
