"""The fields of lights, cameras, environment and look as parameters, so that they get widgets like any other.

Angles are radians here (unit `rad`) and degrees in the window."""

from __future__ import annotations

import math

from engine.core.param import Param

_PI = math.pi
LIGHT_TYPES = ("Directional", "Point", "Spot")

LIGHT = (
    Param("color", "color3", (1.0, 1.0, 1.0), 0.0, 1.0, doc="Scene-linear Rec.709"),
    Param("intensity", "float", 1.0, 0.0, doc="Lux for a directional light, candela for the others"),
    Param("range", "float", 0.0, 0.0, unit="m", doc="Where the light ends; 0 = never"),
)
SPOT = (
    Param("inner_angle", "float", 0.0, 0.0, _PI / 2, unit="rad", doc="Half angle of the full brightness"),
    Param("outer_angle", "float", _PI / 4, 0.0, _PI / 2, unit="rad", doc="Half angle where the light ends"),
)
CAMERA = (
    Param("yfov", "float", _PI / 4, 0.01, 3.1, unit="rad", doc="Vertical field of view"),
    Param("znear", "float", 0.05, 1e-6, unit="m", doc="Nothing nearer is shown"),
)
ENVIRONMENT = (
    Param("intensity", "float", 1.0, 0.0, doc="Scales the light from all around"),
    Param("rotation", "float", 0.0, -_PI, _PI, unit="rad", doc="Turns it about +Y"),
    Param("sun_illuminance", "float", 2.0, 0.0, doc="The sun that comes with it; 0 = none"),
    Param("sun_elevation", "float", _PI / 4, -_PI / 2, _PI / 2, unit="rad", doc="Height of the sun above the horizon"),
    Param("sun_azimuth", "float", 0.6, -_PI, _PI, unit="rad", doc="Direction of the sun"),
    Param("background", "enum", "environment", choices=("environment", "color"), doc="What is behind the scene"),
    Param("background_color", "color3", (0.05, 0.05, 0.06), 0.0, 1.0, doc="Where the background is a colour"),
    Param("background_blur", "float", 0.0, 0.0, 1.0, doc="A roughness: 0 is sharp"),
)
LOOK = (
    Param("exposure", "float", 0.0, -10.0, 10.0, unit="EV", doc="0 shows scene values as they are"),
    Param("tone_map", "enum", "neutral", choices=("agx", "aces", "neutral", "none"), doc="Curve to the display"),
)
