"""Environments from formulas: a photographer's studio, a clear sky, and plain light.

Each is a function of directions f8[n,3] -> radiance f8[n,3], scene-linear Rec.709, +Y up, the viewer's side is +Z.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.assets.environment_dds import sun_direction
from engine.assets.scene import EnvironmentAsset

Doubles = NDArray[np.float64]

#: Clear-sky luminance of the Preetham model is in kcd/m^2; this brings a midday sky to 0.35 of a white diffuser.
SKY_SCALE = 0.038

#: albedo of the ground below a sky's horizon
GROUND = np.array([0.20, 0.185, 0.17])

_RGB_FROM_XYZ = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)

# Preetham, Shirley, Smits 1999, "A Practical Analytic Model for Daylight", appendix A.2: A..E = row @ (turbidity, 1).
_PEREZ_Y = np.array([[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]])
_PEREZ_X = np.array([[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]])
_PEREZ_YY = np.array([[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]])
# Zenith chromaticity: (T^2, T, 1) @ M @ (theta^3, theta^2, theta, 1).
_ZENITH_X = np.array(
    [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]]
)
_ZENITH_Y = np.array(
    [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]]
)


def uniform(d: Doubles, color: tuple[float, float, float]) -> Doubles:
    """The same light from everywhere."""
    return np.broadcast_to(np.asarray(color, np.float64), d.shape).copy()


#: (centre, half width, half height, feather, radiance): panels as seen from the subject, sizes as tangents
_PANELS = (
    ((-0.72, 0.78, 0.62), 0.62, 0.46, 0.10, 8.0),  # key: a large soft box, high on the left in front
    ((0.08, 1.00, -0.02), 0.52, 0.30, 0.14, 3.6),  # overhead bank
    ((-0.93, 0.22, -0.55), 0.11, 0.95, 0.05, 5.0),  # rim strip, left behind
    ((0.88, 0.25, -0.66), 0.11, 0.95, 0.05, 7.0),  # rim strip, right behind
    ((0.95, 0.16, 0.58), 0.70, 0.62, 0.25, 0.75),  # fill: a big dim reflector on the right
)

#: brings a white diffuser that faces up to 0.9
STUDIO_SCALE = 0.4332


def studio(d: Doubles) -> Doubles:
    """A neutral photo studio: key, overhead bank, two rim strips and a fill, in a seamless grey room.

    A white diffuser reads 0.9 facing up; all light is grey, so that materials show their own colours.
    """
    y = d[:, 1]
    floor = 0.16 + 0.26 * _smooth(-1.0, 0.1, y)
    room = np.where(y < 0.1, floor, 0.26 + 0.16 * _smooth(0.7, 0.1, y) + 0.19 * _smooth(0.5, 1.0, y))
    light = room
    for centre, width, height, feather, radiance in _PANELS:
        light = np.maximum(light, _panel(d, np.array(centre), width, height, feather, radiance))
    return np.repeat((STUDIO_SCALE * light)[:, None], 3, axis=1)


def _panel(d: Doubles, centre: Doubles, width: float, height: float, feather: float, radiance: float) -> Doubles:
    """A soft box: a rectangle with soft edges, its middle a third brighter than its rim."""
    forward = centre / np.linalg.norm(centre)
    up = np.array([0.0, 1.0, 0.0]) if abs(forward[1]) < 0.99 else np.array([0.0, 0.0, -1.0])
    right = np.cross(up, forward)
    right /= np.linalg.norm(right)
    up = np.cross(forward, right)
    depth = d @ forward
    safe = np.maximum(depth, 1e-6)
    x, y = np.abs(d @ right) / safe, np.abs(d @ up) / safe
    mask = _smooth(width + feather, width - feather, x) * _smooth(height + feather, height - feather, y)
    glow = 1.0 - 0.25 * np.minimum(1.0, np.square(x / width) + np.square(y / height))
    return np.where(depth > 0.0, radiance * mask * glow, 0.0)


def _smooth(outside: float, inside: float, x: Doubles) -> Doubles:
    t = np.clip((x - outside) / (inside - outside), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def sky(d: Doubles, environment: EnvironmentAsset) -> Doubles:
    """A clear sky after Preetham et al. 1999 without the sun's disk (the sun is a directional light), over grey ground.

    Turbidity is held in 2..10, where the model stands. With the sun below the horizon the sky of the setting sun fades
    by a factor of ten every 3 degrees, which is about how twilight goes. Positive and finite everywhere.
    """
    turbidity = min(max(environment.turbidity, 2.0), 10.0)
    elevation = min(max(environment.sun_elevation, -math.pi / 2), math.pi / 2)
    held = EnvironmentAsset(sun_elevation=max(elevation, 0.0), sun_azimuth=environment.sun_azimuth)
    fade = 10.0 ** (min(0.0, math.degrees(elevation)) / 3.0)
    sun = sun_direction(held)
    above = d.copy()
    above[:, 1] = np.abs(d[:, 1])
    light = _preetham(above, sun, turbidity) * (SKY_SCALE * fade)
    # The ground mirrors nothing: it returns what falls on a level plane, sun and sky, as a diffuser.
    level = _level_irradiance(sun, turbidity) * (SKY_SCALE * fade)
    level = level + environment.sun_illuminance / math.pi * max(0.0, math.sin(elevation))
    below = _smooth(0.0, -0.03, d[:, 1])[:, None]
    result: Doubles = np.maximum(light * (1.0 - below) + GROUND * level * below, 1e-7)
    return result


def _level_irradiance(sun: Doubles, turbidity: float) -> Doubles:
    """Irradiance / pi of the sky on a level plane, f8[3]."""
    count = 32
    cosine = np.sqrt((np.arange(count) + 0.5) / count)
    phi = (np.arange(2 * count) + 0.5) * (math.pi / count)
    c, p = (v.ravel() for v in np.meshgrid(cosine, phi))
    s = np.sqrt(1.0 - c * c)
    mean: Doubles = _preetham(np.stack([s * np.cos(p), c, s * np.sin(p)], -1), sun, turbidity).mean(0)
    return mean


def _preetham(d: Doubles, sun: Doubles, turbidity: float) -> Doubles:
    """Linear Rec.709 in kcd/m^2 for directions with y >= 0."""
    theta_sun = math.acos(min(1.0, max(0.0, float(sun[1]))))
    t = np.array([turbidity, 1.0])
    chi = (4.0 / 9.0 - turbidity / 120.0) * (math.pi - 2.0 * theta_sun)
    zenith_luminance = (4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192
    tt = np.array([turbidity * turbidity, turbidity, 1.0])
    power = np.array([theta_sun**3, theta_sun**2, theta_sun, 1.0])
    zenith = (zenith_luminance, float(tt @ _ZENITH_X @ power), float(tt @ _ZENITH_Y @ power))
    # The model has a pole at the horizon; 0.02 is about one degree above it.
    cos_theta = np.maximum(d[:, 1], 0.02)
    gamma = np.arccos(np.clip(d @ sun, -1.0, 1.0))

    def perez(table: Doubles) -> Doubles:
        a, b, c, e, f = table @ t

        def value(cos_t: Doubles, g: Doubles) -> Doubles:
            return np.asarray((1.0 + a * np.exp(b / cos_t)) * (1.0 + c * np.exp(e * g) + f * np.square(np.cos(g))))

        relative: Doubles = value(cos_theta, gamma) / value(np.array(1.0), np.array(theta_sun))
        return relative

    luminance = np.maximum(zenith[0] * perez(_PEREZ_Y), 1e-4)
    x = zenith[1] * perez(_PEREZ_X)
    y = np.maximum(zenith[2] * perez(_PEREZ_YY), 1e-3)
    xyz = np.stack([luminance * x / y, luminance, luminance * (1.0 - x - y) / y], -1)
    rgb: Doubles = np.maximum(xyz @ _RGB_FROM_XYZ.T, 1e-5)
    return rgb
