"""`lucarna inspect MATERIAL --brdf OUT.png`: the lobe of a material, its albedo, furnace and terms, as a picture."""

from __future__ import annotations

import math
from pathlib import Path

from engine.assets.material import MaterialAsset
from engine.assets.material_toml import read_material
from engine.core.errors import UsageError
from engine.core.paths import shaders_dir
from engine.materials.library import EffectLibrary
from engine.materials.lobe_plots import LobePlots, half_angles, plots_of
from engine.report.image import save_png
from engine.report.plot_sheet import Plot, draw_sheet

SUFFIX = ".material.toml"


def write_brdf(path: Path, out: Path, degrees: float) -> list[str]:
    """Draw the material in `path`, lit at `degrees` from the normal; returns lines to print. Raises UsageError for a
    file that is no material, an effect without a lobe, an angle that is none."""
    if not path.name.lower().endswith(SUFFIX):
        raise UsageError(f"--brdf takes a material, got {path.name}", hint=f"name a *{SUFFIX}; `convert` writes them")
    if out.suffix.lower() != ".png":
        raise UsageError(f"--brdf writes a PNG, got {out.name}", hint="end the name with .png")
    if not 0.0 <= degrees < 90.0:
        raise UsageError(f"--incidence {degrees:g} is no angle from the normal", hint="from 0 to below 90 degrees")
    material = read_material(path)
    found = curves(material, [path.parent, shaders_dir()], math.radians(degrees))
    save_png(out, draw_sheet(f"{material.name or path.name}: {material.effect}, lit at {degrees:g}°", plots(found)))
    return lines(found)


def curves(material: MaterialAsset, search: list[Path], incidence: float) -> LobePlots:
    """The curves of a material. Raises UsageError where its effect has no lobe."""
    effect = EffectLibrary(search).get(material.effect)
    found = plots_of(effect, material, material.params, incidence)
    if found is None:
        raise UsageError(
            f"material {material.name!r} of effect {material.effect!r} reflects by no lobe that is known here",
            hint="surface, microfacet, layered and blinn_phong have one, unless unlit",
        )
    return found


def plots(found: LobePlots) -> list[Plot]:
    """Six plots: the slice linear and logarithmic, albedo, furnace, D, F and V."""
    polar = []
    for name, logarithmic in (("Lobe, linear", False), ("Lobe, four decades", True)):
        parts = [(part, found.out, found.radius(part, logarithmic=logarithmic)) for part in found.polar]
        polar.append(Plot(name, parts, polar=True, marks=[-found.incidence]))
    x, label = found.theta, "degrees"
    albedo = [(name, x, value) for name, value in found.albedo.items()]
    terms = [(name, x, found.f[:, i]) for i, name in enumerate(("F red", "F green", "F blue"))]
    return [
        *polar,
        Plot("Albedo", [*albedo, ("all", x, found.total)], label, low=0.0,
             high=max(1.1, float(found.total.max())), marks=[1]),
        Plot("Furnace: white specular lobe", [("furnace", x, found.furnace)], label, low=0.0,
             high=max(1.2, float(found.furnace.max())), marks=[1]),
        Plot("D", [("D", half_angles(), found.d)], "degrees of the half vector", logarithmic=True),
        Plot("F, and G where n·v = n·l", [*terms, ("G", x, found.g)], label, low=0.0, high=1.0),
    ]  # fmt: skip


def lines(found: LobePlots) -> list[str]:
    """What the picture says, in words."""
    least, most = found.furnace_error
    told = [
        f"furnace error: {least:+.3f} to {most:+.3f}",
        f"albedo: {found.total.min():.3f} to {found.total.max():.3f}",
    ]
    told += [f"note: {note}" for note in found.notes]
    return told + [f"warning: {wrong}; {advice}" for wrong, advice in found.pairs]
