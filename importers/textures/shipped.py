"""The baked data that ships in shaders/data, and how it was made: `python -m importers.textures.shipped`.

studio.env.dds   the default environment, BC6H, 256 texels, mips down to 8, SH9 in its extras
dfg_lut.dds      the GGX albedo table, rg16f
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.assets.environment_dds import write_environment
from engine.assets.scene import EnvironmentAsset
from engine.assets.texture import TextureAsset, mip_extent
from engine.core.paths import shaders_dir
from importers.textures.blocks import encode_blocks
from importers.textures.environment import bake_environment
from importers.textures.ggx_tables import write_dfg

STUDIO_SIZE = 256
#: below this one block of BC6H spans too much of the sphere to hold it
STUDIO_SMALLEST = 8


def write_studio(path: Path) -> None:
    """Bake the default studio and write it as BC6H."""
    cube, sh9 = bake_environment(EnvironmentAsset(kind="studio"), STUDIO_SIZE, smallest=STUDIO_SMALLEST)
    levels = [[encode_blocks(half_image(cube, f, m), "bc6h", "slow") for m in range(cube.mip_count)] for f in range(6)]
    packed = TextureAsset("bc6h", cube.width, cube.height, list(levels), cube=True, name="studio")
    write_environment(path, packed, sh9)


def half_image(cube: TextureAsset, face: int, mip: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float16]]:
    """One image of an rgba16f texture as f2[n,n,4]."""
    n = mip_extent(cube.width, mip)
    return np.frombuffer(cube.levels[face][mip], "<f2").reshape(n, n, 4)


if __name__ == "__main__":
    write_studio(shaders_dir() / "data" / "studio.env.dds")
    write_dfg(shaders_dir() / "data" / "dfg_lut.dds")
