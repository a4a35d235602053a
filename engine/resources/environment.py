"""EnvironmentMap: a prefiltered cube on the GPU, its irradiance as nine SH coefficients, and the DFG table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.assets.dds import read_dds
from engine.assets.environment_dds import read_environment
from engine.assets.texture import TextureAsset
from engine.core.paths import shaders_dir
from engine.gpu.types import Device, Sampler, SamplerDesc, Texture, TextureDesc
from engine.resources.unpack import DECODED_FORMATS, unpacked_once

#: Y_00, the constant spherical harmonic: a constant c projects to c / Y_00
Y00 = 0.28209479177387814


class EnvironmentMap:
    """`cube`: GGX-prefiltered radiance, mip = perceptual roughness x (mips - 1). `sh9`: f4[9,3], irradiance / pi, as
    engine.assets.environment_dds says; here as `irradiance_sh` f4[9,4]."""

    def __init__(self, device: Device, cube: TextureAsset, sh9: NDArray[np.floating]) -> None:
        if device.caps.software and cube.format in DECODED_FORMATS:
            cube = unpacked_once(device, cube)
        self.mips = cube.mip_count
        self.irradiance_sh = np.zeros((9, 4), np.float32)
        self.irradiance_sh[:, :3] = sh9
        self.texture = device.texture(
            TextureDesc(
                cube.format, cube.width, cube.height, "cube", layers=6, mips=cube.mip_count, label="environment"
            )
        )
        for face, levels in enumerate(cube.levels):
            for level, data in enumerate(levels):
                self.texture.write(data, level=level, layer=face)
        self.sampler: Sampler = device.sampler(SamplerDesc("clamp", "clamp", "clamp"))

    @classmethod
    def from_file(cls, device: Device, path: Path) -> EnvironmentMap:
        """Read a baked environment (.dds). Raises FormatError."""
        return cls(device, *read_environment(path))

    @classmethod
    def uniform(cls, device: Device, color: tuple[float, float, float]) -> EnvironmentMap:
        """The same radiance from everywhere: one texel a face, one SH coefficient."""
        texel = np.array([*color, 1.0], np.float32).tobytes()
        sh = np.zeros((9, 3))
        sh[0] = np.array(color) / Y00
        return cls(device, TextureAsset("rgba32f", 1, 1, [[texel] for _ in range(6)], cube=True), sh)

    def release(self) -> None:
        self.texture.release()


class DfgTable:
    """The split-sum table: x = n.v, y = perceptual roughness -> scale and bias of f0."""

    def __init__(self, device: Device) -> None:
        asset = read_dds(shaders_dir() / "data" / "dfg_lut.dds")
        self.texture: Texture = device.texture(TextureDesc(asset.format, asset.width, asset.height, label="dfg table"))
        self.texture.write(asset.levels[0][0])
        self.sampler = device.sampler(SamplerDesc("clamp", "clamp", "clamp", "linear", "linear"))

    def release(self) -> None:
        self.texture.release()
