"""Block-compressed textures unpacked once.

A software rasteriser decodes a block at every fetch, which can cost it more than all the rest of a shader. What it
decoded is kept in <user cache>/unpacked from one start to the next: BC7 takes it about 75 ns a texel, the disk 5.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace

from engine.assets.texture import TextureAsset
from engine.core.paths import user_cache_dir
from engine.gpu.program_cache import Binary, ProgramCache
from engine.gpu.types import Device, TextureDesc

FOLDER = "unpacked"
#: compressed format -> what it is unpacked to
DECODED_FORMATS = {
    "bc1": "rgba8", "bc1-srgb": "rgba8-srgb", "bc3": "rgba8", "bc3-srgb": "rgba8-srgb", "bc4": "r8", "bc5": "rg8",
    "bc6h": "rgba16f", "bc7": "rgba8", "bc7-srgb": "rgba8-srgb",
}  # fmt: skip


#: textures of fewer bytes than this, compressed, are decoded faster than found
WORTH_KEEPING = 16 << 10
#: bytes of all that is kept; the least recently used goes first
LIMIT = 512 << 20


def unpacked_once(device: Device, asset: TextureAsset) -> TextureAsset:
    """As `unpacked`, from the user's cache where it was done before."""
    sizes = [len(memoryview(data).cast("B")) for images in asset.levels for data in images]
    if sum(sizes) < WORTH_KEEPING:
        return unpacked(device, asset)
    cache = ProgramCache((device.caps.device, device.caps.version), folder=user_cache_dir() / FOLDER, limit=LIMIT)
    content = hashlib.sha256()
    for images in asset.levels:
        for data in images:
            content.update(data)
    shape = f"{asset.format} {asset.width} {asset.height} {asset.cube} {sizes}"
    key = cache.key([("texture", shape), ("content", content.hexdigest())])
    kept = cache.get(key)
    # of each level: its texels times the bytes of one, which follow from how many there are in all
    texels = [max(asset.width >> i, 1) * max(asset.height >> i, 1) for i in range(asset.mip_count)]
    total = sum(texels) * asset.layers
    if kept is None or not kept.data or len(kept.data) % total:
        made = unpacked(device, asset)
        cache.put(key, Binary(0, b"".join(bytes(data) for images in made.levels for data in images)))
        return made
    wide, view, at = len(kept.data) // total, memoryview(kept.data), 0
    levels: list[Sequence[bytes | memoryview]] = []
    for _ in range(asset.layers):
        layer: list[bytes | memoryview] = []
        for count in texels:
            layer.append(view[at : at + count * wide])
            at += count * wide
        levels.append(layer)
    return replace(asset, format=DECODED_FORMATS[asset.format], levels=levels)


def unpacked(device: Device, asset: TextureAsset) -> TextureAsset:
    """The same texture in an uncompressed format, decoded by the driver; all layers and mips."""
    kind = "cube" if asset.cube else "2d-array"
    packed = device.texture(
        TextureDesc(asset.format, asset.width, asset.height, kind, layers=asset.layers, mips=asset.mip_count)
    )
    levels: list[Sequence[bytes | memoryview]] = []
    for layer, images in enumerate(asset.levels):
        decoded: list[bytes | memoryview] = []
        for level, data in enumerate(images):
            packed.write(data, level=level, layer=layer)
            decoded.append(packed.read(level=level, layer=layer).data.cast("B"))
        levels.append(decoded)
    packed.release()
    return TextureAsset(
        DECODED_FORMATS[asset.format],
        asset.width,
        asset.height,
        levels,
        asset.depth,
        asset.cube,
        asset.name,
        asset.extras,
    )
