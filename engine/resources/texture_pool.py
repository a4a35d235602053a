"""TexturePool: textures of one format, size and mip count share one array texture, so that batches do not split."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from engine.assets.texture import TextureAsset
from engine.gpu.formats import texture_bytes
from engine.gpu.types import Device, Texture, TextureDesc
from engine.resources.unpack import DECODED_FORMATS, unpacked_once

#: A software rasteriser unpacks a texel once in about 55 ns; a pixel that samples blocks costs it about 5 us more than
#: one that does not (both measured on llvmpipe). So this many texels per drawn pixel are worth unpacking, half of the
#: break-even, since not every pixel is covered.
TEXELS_PER_PIXEL = 45

#: (format, width, height, mips)
ArrayKey = tuple[str, int, int, int]


@dataclass(frozen=True, slots=True)
class PooledTexture:
    """A layer of an array. `array` indexes TexturePool.arrays; arrays may be reallocated, their index stays."""

    array: int
    layer: int


@dataclass(slots=True)
class _Array:
    key: ArrayKey
    texture: Texture
    used: int
    free: list[int] = field(default_factory=list)

    @property
    def texture_bytes(self) -> int:
        """Of one layer with its mips."""
        return texture_bytes(replace(self.texture.desc, layers=1))


def array_key(asset: TextureAsset) -> ArrayKey:
    return (asset.format, asset.width, asset.height, asset.mip_count)


class TexturePool:
    """Arrays grow by doubling (a copy on the GPU); `reserve` avoids that where the need is known.

    `pixels`: how many pixels will be drawn with it, about; on a software rasteriser it decides whether compressed
    textures are kept decoded (see unpack.py).
    """

    def __init__(self, device: Device, *, pixels: int = 0) -> None:
        self._device = device
        self._pixels = pixels if device.caps.software else 0
        self._unpack = False
        self._arrays: list[_Array] = []
        self._open: dict[ArrayKey, int] = {}

    def texture(self, array: int) -> Texture:
        return self._arrays[array].texture

    @property
    def byte_size(self) -> int:
        return self._bytes

    _bytes = 0

    def reserve(self, assets: Sequence[TextureAsset]) -> None:
        """Make room for these at once, so that each array is allocated one time."""
        texels = sum(asset.width * asset.height for asset in assets if asset.format in DECODED_FORMATS) * 4 // 3
        self._unpack = 0 < texels <= self._pixels * TEXELS_PER_PIXEL
        wanted: dict[ArrayKey, int] = {}
        for asset in assets:
            key = self._key(asset)
            wanted[key] = wanted.get(key, 0) + asset.layers
        for key, count in wanted.items():
            self._room(key, count)

    def add(self, asset: TextureAsset) -> PooledTexture:
        """Upload the first layer of a 2D texture with all its mips."""
        key = self._key(asset)
        if key[0] != asset.format:
            asset = unpacked_once(self._device, asset)
        index = next((i for i, entry in enumerate(self._arrays) if entry.key == key and entry.free), -1)
        if index < 0:
            index = self._room(key, 1)
            entry = self._arrays[index]
            layer, entry.used = entry.used, entry.used + 1
        else:
            layer = self._arrays[index].free.pop()
        self._bytes += self._write(index, layer, asset)
        return PooledTexture(index, layer)

    def replace(self, old: PooledTexture, asset: TextureAsset) -> PooledTexture:
        """Put other pixels in the place of a texture: in its layer where format, size and mips are the same, else in
        another one; then the old layer is free for the next."""
        key, entry = self._key(asset), self._arrays[old.array]
        if key != entry.key:
            self._bytes -= entry.texture_bytes
            entry.free.append(old.layer)
            return self.add(asset)
        self._write(old.array, old.layer, unpacked_once(self._device, asset) if key[0] != asset.format else asset)
        return old

    def own(self, texture: Texture) -> int:
        """The index of an array that nobody else gets layers of; the pool releases it."""
        desc = texture.desc
        self._arrays.append(_Array((desc.format, desc.width, desc.height, desc.mips), texture, desc.layers))
        self._bytes += texture_bytes(desc)
        return len(self._arrays) - 1

    def exchange(self, array: int, texture: Texture) -> None:
        """Another texture in the place of one that was given to `own`."""
        entry = self._arrays[array]
        self._bytes += texture_bytes(texture.desc) - texture_bytes(entry.texture.desc)
        entry.texture.release()
        entry.texture, entry.used = texture, texture.desc.layers

    def _write(self, index: int, layer: int, asset: TextureAsset) -> int:
        texture = self._arrays[index].texture
        for level, data in enumerate(asset.levels[0]):
            texture.write(data, level=level, layer=layer)
        return sum(map(len, asset.levels[0]))

    def release(self) -> None:
        for entry in self._arrays:
            entry.texture.release()
        self._arrays.clear()
        self._open.clear()

    def _key(self, asset: TextureAsset) -> ArrayKey:
        format, width, height, mips = array_key(asset)
        return (DECODED_FORMATS.get(format, format) if self._unpack else format, width, height, mips)

    def _room(self, key: ArrayKey, count: int) -> int:
        """The index of an array of this key with room for `count` more layers (or as many as the device allows)."""
        limit = self._device.caps.max_array_layers
        index = self._open.get(key)
        if index is not None:
            entry = self._arrays[index]
            capacity = entry.texture.desc.layers
            if entry.used + count <= capacity:
                return index
            if entry.used + count <= limit:
                bigger = self._allocate(key, min(limit, max(entry.used + count, 2 * capacity)))
                self._device.copy_texture(entry.texture, bigger, entry.used)
                entry.texture.release()
                entry.texture = bigger
                return index
        self._arrays.append(_Array(key, self._allocate(key, min(limit, max(1, count))), 0))
        self._open[key] = len(self._arrays) - 1
        return len(self._arrays) - 1

    def _allocate(self, key: ArrayKey, layers: int) -> Texture:
        format, width, height, mips = key
        return self._device.texture(
            TextureDesc(format, width, height, "2d-array", layers=layers, mips=mips, label=f"pool {format} {width}")
        )
