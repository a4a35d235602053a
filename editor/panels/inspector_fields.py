"""The fields of cameras, environment and look as parameters, so that they get widgets like any other.

Angles are radians here (unit `rad`) and degrees in the window."""

from __future__ import annotations

import dataclasses
import math

from engine.assets.scene import CameraAsset, EnvironmentAsset, LookAsset
from engine.core.param import Param

_PI = math.pi
CAMERA: tuple[Param, ...] = (
    Param("yfov", "float", _PI / 4, 0.01, 3.1, unit="rad", doc="Vertical field of view"),
    Param("znear", "float", 0.05, 1e-6, unit="m", doc="Nothing nearer is shown"),
)
ENVIRONMENT: tuple[Param, ...] = (
    Param(
        "kind", "enum", "studio", choices=("sky", "studio", "uniform", "image", "none"), doc="What the light comes from"
    ),
    Param("color", "color3", (1.0, 1.0, 1.0), 0.0, 100.0, doc="Of a uniform environment"),
    Param("turbidity", "float", 3.0, 1.0, 10.0, doc="Haze of the sky"),
    Param("intensity", "float", 1.0, 0.0, doc="Scales the light from all around"),
    Param("rotation", "float", 0.0, -_PI, _PI, unit="rad", doc="Turns it about +Y"),
    Param("sun_illuminance", "float", 2.0, 0.0, doc="The sun that comes with it; 0 = none"),
    Param("sun_elevation", "float", _PI / 4, -_PI / 2, _PI / 2, unit="rad", doc="Height of the sun above the horizon"),
    Param("sun_azimuth", "float", 0.6, -_PI, _PI, unit="rad", doc="Direction of the sun"),
    Param("background", "enum", "environment", choices=("environment", "color"), doc="What is behind the scene"),
    Param("background_color", "color3", (0.05, 0.05, 0.06), 0.0, 1.0, doc="Where the background is a colour"),
    Param("background_blur", "float", 0.0, 0.0, 1.0, doc="A roughness: 0 is sharp"),
)
LOOK: tuple[Param, ...] = (
    Param("exposure", "float", 0.0, -10.0, 10.0, unit="EV", doc="0 shows scene values as they are"),
    Param("tone_map", "enum", "neutral", choices=("agx", "aces", "neutral", "none"), doc="Curve to the display"),
)


def _with_defaults(fields: tuple[Param, ...], record: object) -> tuple[Param, ...]:
    """The same fields with the defaults of the engine's own record."""
    return tuple(dataclasses.replace(f, default=getattr(record, f.name)) for f in fields)


CAMERA = _with_defaults(CAMERA, CameraAsset())
ENVIRONMENT, LOOK = _with_defaults(ENVIRONMENT, EnvironmentAsset()), _with_defaults(LOOK, LookAsset())

#: fields that only some kinds of environment have
ONLY_OF = {"color": {"uniform"}, "turbidity": {"sky"}}
#: fields whose change has a sky painted anew, too slow to follow a drag: applied when it ends
SLOW_OF_SKY = {"sun_elevation", "sun_azimuth", "turbidity"}


def environment_fields(environment: object) -> tuple[Param, ...]:
    """The fields that mean something for this environment."""
    kind = getattr(environment, "kind", "")
    fields = tuple(f for f in ENVIRONMENT if kind in ONLY_OF.get(f.name, {kind}))
    if getattr(environment, "path", ""):
        return fields
    choices = tuple(c for c in fields[0].choices if c != "image")  # there is no image to choose
    return (dataclasses.replace(fields[0], choices=choices), *fields[1:])
