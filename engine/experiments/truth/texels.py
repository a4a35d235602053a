"""Textures as arrays: decoded by the device, scene-linear, looked up bilinearly at their finest useful size."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.assets.dds import read_dds
from engine.assets.material import TextureRef
from engine.assets.texture import TextureAsset, mip_extent
from engine.gpu.types import Device
from engine.materials.table import uv_rows
from engine.math.color import srgb_to_linear
from engine.resources.unpack import DECODED_FORMATS, unpacked

F8 = NDArray[np.float64]

#: a mip no larger than this is taken: a truth of some hundred pixels sees no more
LARGEST = 1024
_TYPES = {"8": np.uint8, "16f": np.float16, "32f": np.float32}


def decode(device: Device, asset: TextureAsset) -> NDArray[np.float32]:
    """f4[h,w,4], scene-linear; channels that the format lacks are 0, alpha 1, as on a device."""
    if asset.format in DECODED_FORMATS:
        level = next((i for i in range(asset.mip_count) if _extent(asset, i) <= LARGEST), asset.mip_count - 1)
        one = TextureAsset(
            asset.format, mip_extent(asset.width, level), mip_extent(asset.height, level), [[asset.levels[0][level]]]
        )
        asset = unpacked(device, one)
    level = next((i for i in range(asset.mip_count) if _extent(asset, i) <= LARGEST), asset.mip_count - 1)
    width, height = mip_extent(asset.width, level), mip_extent(asset.height, level)
    base, _, space = asset.format.partition("-")
    channels = base.rstrip("0123456789f")
    raw = np.frombuffer(asset.levels[0][level], _TYPES[base.removeprefix(channels)])
    values = raw.reshape(height, width, len(channels)).astype(np.float32)
    if raw.dtype == np.uint8:
        values /= 255.0
    out = np.zeros((height, width, 4), np.float32)
    out[..., 3] = 1.0
    out[..., : len(channels)] = values
    if space == "srgb":
        out[..., :3] = srgb_to_linear(out[..., :3])
    return out


def _extent(asset: TextureAsset, level: int) -> int:
    return max(mip_extent(asset.width, level), mip_extent(asset.height, level))


class Lookup:
    """One texture slot of one material."""

    def __init__(self, pixels: NDArray[np.float32], ref: TextureRef) -> None:
        self.pixels, self.uv_set = pixels, ref.uv_set
        self._rows = np.array(uv_rows(ref), np.float64)[:, :3]
        self._wraps = (ref.wrap_u, ref.wrap_v)
        self._nearest = ref.mag_filter == "nearest"
        #: all that changes what is found, besides the pixels
        self.said = f"{self._rows.tolist()} {self._wraps} {self._nearest} {self.uv_set}"

    def __call__(self, uv: F8) -> F8:
        """f8[n,4] at `uv` f8[n,2] of its uv set."""
        height, width = self.pixels.shape[:2]
        at = uv @ self._rows[:, :2].T + self._rows[:, 2]
        at = np.nan_to_num(np.clip(at, -1e6, 1e6))
        x, y = at[:, 0] * width, at[:, 1] * height
        if self._nearest:
            return self._texel(np.floor(x), np.floor(y))
        x, y = x - 0.5, y - 0.5
        i, j = np.floor(x), np.floor(y)
        a, b = (x - i)[:, None], (y - j)[:, None]
        top = self._texel(i, j) * (1.0 - a) + self._texel(i + 1, j) * a
        bottom = self._texel(i, j + 1) * (1.0 - a) + self._texel(i + 1, j + 1) * a
        result: F8 = top * (1.0 - b) + bottom * b
        return result

    def _texel(self, x: F8, y: F8) -> F8:
        height, width = self.pixels.shape[:2]
        picked = self.pixels[_wrap(y, height, self._wraps[1]), _wrap(x, width, self._wraps[0])]
        return picked.astype(np.float64)


def _wrap(index: F8, size: int, how: str) -> NDArray[np.int64]:
    i = index.astype(np.int64)
    if how == "clamp":
        return np.clip(i, 0, size - 1)
    if how == "mirror":
        i = i % (2 * size)
        return np.where(i < size, i, 2 * size - 1 - i)
    return i % size


class TextureFiles:
    """Files decoded once each."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._found: dict[Path, NDArray[np.float32]] = {}

    def lookup(self, ref: TextureRef, folder: Path) -> Lookup:
        """Raises InputError for a file that cannot be read."""
        path = (folder / ref.path).resolve()
        if path not in self._found:
            self._found[path] = decode(self._device, read_dds(path))
        return Lookup(self._found[path], ref)
