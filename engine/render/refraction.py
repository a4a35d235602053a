"""How transmissive bodies show what is behind them. Part of the facts."""

from __future__ import annotations

from engine.render.settings import REFRACTIONS, RenderSettings

STRAIGHT, BENT, TESTED = REFRACTIONS


def refraction_of(settings: RenderSettings, transmissive: bool) -> str:
    """One of REFRACTIONS; straight where nothing is transmissive, for which it is the same."""
    return str(settings.refraction) if transmissive else STRAIGHT


def untested(refraction: str) -> str:
    """The same where there is no picture of what is in front of bodies (passes/scene_front.py)."""
    return BENT if refraction == TESTED else refraction
