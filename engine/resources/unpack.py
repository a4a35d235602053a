"""Block-compressed textures unpacked once.

A software rasteriser decodes a block at every fetch, which can cost it more than all the rest of a shader.
"""

from __future__ import annotations

from collections.abc import Sequence

from engine.assets.texture import TextureAsset
from engine.gpu.types import Device, TextureDesc

#: compressed format -> what it is unpacked to
DECODED_FORMATS = {
    "bc1": "rgba8", "bc1-srgb": "rgba8-srgb", "bc3": "rgba8", "bc3-srgb": "rgba8-srgb", "bc4": "r8", "bc5": "rg8",
    "bc6h": "rgba16f", "bc7": "rgba8", "bc7-srgb": "rgba8-srgb",
}  # fmt: skip


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
