"""Whether the microfacet terms that a material chooses belong together: a masking makes or loses light with a
distribution that it was not derived for."""

from __future__ import annotations

from collections.abc import Iterable

from engine.math.microfacet import DISTRIBUTIONS, FRESNELS, MASKINGS, MATCHED, chosen

NAMES = {
    "ggx": "GGX", "beckmann": "Beckmann", "blinn_phong": "Blinn-Phong", "smith": "height-correlated Smith for GGX",
    "schlick": "Smith by Schlick's fraction", "walter": "Smith for Beckmann (Walter)",
    "cook_torrance": "V-cavities (Cook-Torrance)", "implicit": "the implicit n.l n.v",
}  # fmt: skip
_DEFAULTS = {"distribution": DISTRIBUTIONS[0], "masking": MASKINGS[0], "fresnel": FRESNELS[0]}


#: perceptual roughness up to which Blinn-Phong is like Beckmann, whose masking it borrows (experiment brdf_energy)
ALIKE = 0.6


def pairing(
    features: Iterable[str], effect: str = "microfacet", roughness: float | None = None
) -> list[tuple[str, str]]:
    """(what is wrong, what would match) for the features of a material of that effect; empty where all is well.
    `roughness`: the material's, where it is known."""
    if effect == "blinn_phong":
        return []  # a fixed pair, and said to lose light
    on = set(features)
    found: list[tuple[str, str]] = []
    for kind, names in (("distribution", DISTRIBUTIONS), ("masking", MASKINGS), ("fresnel", FRESNELS)):
        several = [f"{kind}_{name}" for name in names if f"{kind}_{name}" in on]
        if len(several) > 1:
            found.append((f"{' and '.join(several)}: only {several[0]} counts", f"keep one {kind} feature"))
    distribution, masking, _ = chosen(on)
    if masking not in MATCHED[distribution]:
        loses = masking == "implicit"
        what = "loses light at grazing" if loses else "makes or loses light: it was derived for another distribution"
        text = f"{NAMES[distribution]} with {NAMES[masking]} {what}"
        found.append((text, f"with {NAMES[distribution]} belong: {', '.join(_said(m) for m in MATCHED[distribution])}"))
    borrowed = (distribution, masking) == ("blinn_phong", "walter")
    if borrowed and roughness is not None and roughness > ALIKE:
        text = f"{NAMES[distribution]} with {NAMES[masking]} makes light, up to 24 %, above roughness {ALIKE:g}"
        found.append((text, f"take {NAMES['cook_torrance']} (masking_cook_torrance), or distribution_beckmann"))
    if "energy_compensation" in on and (distribution, masking) != ("ggx", "smith"):
        text = f"energy_compensation does nothing with {NAMES[distribution]} and {NAMES[masking]}"
        found.append((text, "its table is of GGX with Smith's masking, the defaults"))
    if "anisotropy" in on and (distribution, masking) != ("ggx", "smith"):
        text = f"anisotropy stretches GGX with Smith's masking; {NAMES[distribution]} and {NAMES[masking]} are not used"
        found.append((text, "take distribution and masking features off, or anisotropy"))
    return found


def _said(masking: str) -> str:
    feature = "the default" if masking == _DEFAULTS["masking"] else f"masking_{masking}"
    return f"{NAMES[masking]} ({feature})"
