"""Baked environments (`*.env.dds`): a cube map whose mips are prefiltered for specular light, with SH9 for diffuse.

The cube: faces +x -x +y -y +z -z as OpenGL orients them (row 0 is the top row of the texture, t = 0), world +Y up.
Mip m of `mips` holds the radiance seen in a GGX mirror of perceptual roughness m / (mips - 1), viewed head-on
(the split sum of Karis 2013). `extras`:

    {"environment": "lucarna.env/1", "sh9": [[r, g, b] * 9], …}

The nine coefficients give irradiance / pi, the radiance of a white Lambert surface facing n:
sum_i sh9[i] * Y_i(n), with the real orthonormal basis in the order 1, y, z, x, xy, yz, 3z^2-1, xz, x^2-y^2
(Ramamoorthi, Hanrahan 2001; cosine factors 1, 2/3, 1/4 are already in).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.assets.dds import read_dds, write_dds
from engine.assets.scene import EnvironmentAsset
from engine.assets.texture import TextureAsset
from engine.core.errors import FormatError, Place

SCHEMA = "lucarna.env/1"


def read_environment(path: Path) -> tuple[TextureAsset, NDArray[np.float32]]:
    """The cube and its SH9 as f4[9,3]. Raises InputError, FormatError."""
    texture = read_dds(path)
    place = Place(str(path), path="extras.sh9")
    if not texture.cube or texture.extras.get("environment") != SCHEMA:
        raise FormatError(
            "is a texture, but no baked environment", where=path, hint="bake it first, from .hdr, .exr or a cube"
        )
    try:
        wide = np.array(texture.extras.get("sh9"), np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise FormatError(f"is not nine colours: {error}", where=place) from error
    if wide.shape != (9, 3) or not (np.abs(wide) < 3e38).all():
        raise FormatError("is not nine finite colours", where=place)
    return texture, wide.astype(np.float32)


def write_environment(path: Path, texture: TextureAsset, sh9: NDArray[np.float32]) -> None:
    """Write a baked environment. Raises FormatError, OutputError."""
    write_dds(path, with_sh9(texture, sh9))


def with_sh9(texture: TextureAsset, sh9: NDArray[np.float32]) -> TextureAsset:
    """The cube as a baked environment: its SH9 f4[9,3] in the extras."""
    extras = {**texture.extras, "environment": SCHEMA, "sh9": np.asarray(sh9, np.float32).tolist()}
    return TextureAsset(
        texture.format, texture.width, texture.height, texture.levels, cube=True, name=texture.name, extras=extras
    )


def sun_direction(environment: EnvironmentAsset) -> NDArray[np.float64]:
    """Unit vector from the scene towards the sun, before `environment.rotation`: azimuth 0 is +Z, pi/2 is +X."""
    elevation, azimuth = environment.sun_elevation, environment.sun_azimuth
    return np.array(
        [np.cos(elevation) * np.sin(azimuth), np.sin(elevation), np.cos(elevation) * np.cos(azimuth)], np.float64
    )
