"""What is said of microfacet terms that do not belong together."""

from __future__ import annotations

import pytest

from engine.materials.pairing import pairing


@pytest.mark.parametrize(
    "features",
    [(), ("distribution_beckmann", "masking_walter"), ("masking_schlick",),
     ("distribution_beckmann", "masking_schlick"),
     ("masking_cook_torrance",), ("energy_compensation",), ("clearcoat", "normal_map")],
)  # fmt: skip
def test_matched_pairs_are_silent(features: tuple[str, ...]) -> None:
    assert pairing(features) == []


@pytest.mark.parametrize(
    ("features", "wrong", "advice"),
    [
        (("masking_walter",), "GGX with Smith for Beckmann", "the default"),
        (("distribution_beckmann",), "Beckmann with height-correlated Smith for GGX", "masking_walter"),
        (("masking_implicit",), "loses light at grazing", "belong"),
        (("distribution_beckmann", "distribution_blinn_phong", "masking_walter"), "_beckmann counts", "keep"),
        (("energy_compensation", "masking_schlick"), "does nothing", "defaults"),
        (("anisotropy", "masking_schlick"), "not used", "take"),
    ],
)  # fmt: skip
def test_others_are_told(features: tuple[str, ...], wrong: str, advice: str) -> None:
    ((text, hint),) = pairing(features)
    assert wrong in text
    assert advice in hint


def test_blinn_phong_borrows_a_masking_that_fits_it_when_smooth() -> None:
    features = ("distribution_blinn_phong", "masking_walter")
    assert pairing(features, roughness=0.5) == []
    ((text, hint),) = pairing(features, roughness=0.9)
    assert "makes light" in text
    assert "cook_torrance" in hint
