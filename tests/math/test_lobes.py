"""Slices, albedo and furnace of whole materials against known sums."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.math import ggx
from engine.math.lobes import Lobe, directional_albedo, lobe_of

ANGLES = np.array([0.1, 0.6, 1.2])


def test_albedo_is_that_of_the_split_sum() -> None:
    mu = np.cos(ANGLES)
    assert directional_albedo("ggx", "smith", 0.25, mu, 96) == pytest.approx(ggx.albedo(0.5, mu), rel=2e-4)
    f0 = 0.3
    found = directional_albedo("ggx", "smith", 0.25, mu, 96, lambda c: ggx.F_Schlick(c, f0))
    ab = ggx.dfg(0.5, mu)
    assert found == pytest.approx(f0 * ab[:, 0] + ab[:, 1], rel=2e-4)


@pytest.mark.parametrize("features", [(), ("distribution_beckmann", "masking_walter"), ("fresnel_conductor",)])
def test_slice_sums_to_the_albedo_for_a_round_lobe_at_normal_incidence(features: tuple[str, ...]) -> None:
    """Lit head-on the lobe is round, so that the slice times 2 pi sin is all of it."""
    lobe = lobe_of("microfacet", features, {"metallic": 1.0, "roughness": 0.6, "base_color": (0.8, 0.6, 0.4, 1.0)})
    assert lobe is not None
    x, w = np.polynomial.legendre.leggauss(200)
    theta, w = (x + 1) * math.pi / 4, w * math.pi / 4
    parts = lobe.slice(0.0, theta)
    total = 2 * math.pi * np.sum(w * parts["specular"] * np.cos(theta) * np.sin(theta))
    assert total == pytest.approx(lobe.albedo(np.zeros(1), 96)["specular"][0], rel=2e-3)


def test_reciprocity_and_mirror() -> None:
    lobe = lobe_of("layered", ("clearcoat", "sheen"), {"roughness": 0.4, "metallic": 0.0, "clearcoat_roughness": 0.2})
    assert lobe is not None
    out = np.linspace(-1.4, 1.4, 281)
    parts = lobe.slice(0.7, out)
    assert out[np.argmax(parts["coat"])] == pytest.approx(0.7, abs=0.15)
    one, two = lobe.slice(0.7, np.array([0.3]))["coat"], lobe.slice(0.3, np.array([0.7]))["coat"]
    assert one[0] / math.cos(0.7) == pytest.approx(two[0] / math.cos(0.3), rel=1e-9)


def test_no_material_sends_out_more_than_it_gets() -> None:
    for features in ((), ("clearcoat",), ("sheen",), ("transmission",), ("clearcoat", "sheen", "transmission")):
        lobe = lobe_of("layered", features, {"metallic": 0.0, "roughness": 0.5, "sheen_color": (1, 1, 1)})
        assert lobe is not None
        total = sum(lobe.albedo(ANGLES).values())
        assert isinstance(total, np.ndarray)
        assert (total < 1.05).all(), features  # diffuse light is counted by its own Fresnel: a little may be twice
        assert (total > 0.7).all(), features


def test_furnace() -> None:
    rough = Lobe(alpha=1.0)
    assert (rough.furnace(ANGLES) < 0.8).all()
    assert Lobe(alpha=1.0, compensated=True).furnace(ANGLES) == pytest.approx(1.0, abs=2e-2)
    assert (Lobe(alpha=0.5, masking="walter").furnace(np.array([1.4])) > 1.05).all(), "a mismatched pair makes light"


def test_thesis_model() -> None:
    lobe = lobe_of("blinn_phong", (), {"exponent": 10.0, "metallic": 1.0})
    assert lobe is not None
    assert lobe.furnace(np.array([0.0, math.acos(0.3), math.acos(0.1)]), 128) == pytest.approx(
        [0.717, 0.179, 0.101], abs=2e-3
    )


def test_what_has_no_lobe() -> None:
    assert lobe_of("toon", (), {}) is None
    assert lobe_of("surface", ("unlit",), {}) is None


def test_stretched() -> None:
    along = lobe_of("layered", ("anisotropy",), {"roughness": 0.3, "anisotropy": 0.9})
    across = lobe_of("layered", ("anisotropy",), {"roughness": 0.3, "anisotropy": 0.9}, across=True)
    assert along is not None
    assert across is not None
    assert along.d(0.5) > 20 * across.d(0.5)
    assert along.d(0.0) == pytest.approx(across.d(0.0))
