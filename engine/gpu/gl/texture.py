"""GlTexture: images of one format, immutable in shape."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.texture import mip_extent
from engine.gpu import formats, validate
from engine.gpu.gl import enums as e
from engine.gpu.gl.memory import address_of
from engine.gpu.gl.objects import GlObject
from engine.gpu.gl.texel_formats import COMPRESSED, DECODED, TEXELS, internal_format
from engine.gpu.types import TextureDesc

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice


def target_of(desc: TextureDesc) -> int:
    if desc.samples > 1:
        return e.TEXTURE_2D_MULTISAMPLE
    if desc.kind == "cube":
        return e.TEXTURE_CUBE_MAP if desc.layers == 6 else e.TEXTURE_CUBE_MAP_ARRAY
    return {"2d": e.TEXTURE_2D, "2d-array": e.TEXTURE_2D_ARRAY, "3d": e.TEXTURE_3D}[desc.kind]


class GlTexture(GlObject):
    KIND = "texture"
    __slots__ = ("_device", "desc", "internal", "target")

    def __init__(self, device: GlDevice, desc: TextureDesc) -> None:
        validate.texture_desc(desc, device.caps)
        self.desc = desc
        self.target = target_of(desc)
        self.internal = internal_format(desc.format)
        self._device = device
        device.before_allocation(formats.texture_bytes(desc))
        super().__init__(device.objects, device.objects.create("texture", self.target))
        gl = device.gl
        if desc.samples > 1:
            gl.TextureStorage2DMultisample(self.id, desc.samples, self.internal, desc.width, desc.height, e.TRUE)
        elif self.target in (e.TEXTURE_2D, e.TEXTURE_CUBE_MAP):
            gl.TextureStorage2D(self.id, desc.mips, self.internal, desc.width, desc.height)
        else:
            depth = desc.depth if desc.kind == "3d" else desc.layers
            gl.TextureStorage3D(self.id, desc.mips, self.internal, desc.width, desc.height, depth)
        device.counters.api_calls += 2
        device.check_allocation(validate.named("texture", desc.label), formats.texture_bytes(desc))
        device.label(self.KIND, self.id, desc.label)

    @property
    def native(self) -> int:
        return self.id

    @property
    def layered(self) -> bool:
        return self.desc.kind != "2d"

    def write(self, data: bytes | memoryview | NDArray[Any], *, level: int = 0, layer: int = 0) -> None:
        address, size, keep = address_of(data)
        desc = self.desc
        validate.texture_write(desc, level, layer, size)
        width, height = formats.image_size(desc, level)
        device = self._device
        device.ensure_current()
        device.state.tight_pixels()
        gl = device.gl
        if desc.format in COMPRESSED:
            if self.layered:
                gl.CompressedTextureSubImage3D(
                    self.id, level, 0, 0, layer, width, height, 1, self.internal, size, address
                )
            else:
                gl.CompressedTextureSubImage2D(self.id, level, 0, 0, width, height, self.internal, size, address)
        else:
            texel = TEXELS[desc.format]
            if self.layered:
                gl.TextureSubImage3D(self.id, level, 0, 0, layer, width, height, 1, texel.layout, texel.number, address)
            else:
                gl.TextureSubImage2D(self.id, level, 0, 0, width, height, texel.layout, texel.number, address)
        del keep
        device.transfer_done()
        device.counters.api_calls += 1
        device.counters.bytes_uploaded += size

    def read(self, *, level: int = 0, layer: int = 0) -> NDArray[Any]:
        desc = self.desc
        validate.texture_read(desc, level, layer)
        width, height = formats.image_size(desc, level)
        dtype, shape = formats.read_shape(desc, level)
        out = np.empty(shape, dtype)
        texel = TEXELS[DECODED.get(desc.format, desc.format)]
        device = self._device
        device.ensure_current()
        device.state.tight_pixels()
        device.gl.GetTextureSubImage(
            self.id, level, 0, 0, layer, width, height, 1, texel.layout, texel.read_number, out.nbytes, out.ctypes.data
        )
        device.transfer_done()
        device.counters.api_calls += 1
        device.counters.bytes_read += out.nbytes
        return out

    def copy_to(self, target: GlTexture, layers: int) -> None:
        validate.texture_copy(self.desc, target.desc, layers)
        for level in range(self.desc.mips):
            width, height = formats.image_size(self.desc, level)
            depth = mip_extent(self.desc.depth, level) if self.desc.kind == "3d" else layers
            self._device.gl.CopyImageSubData(
                self.id, self.target, level, 0, 0, 0, target.id, target.target, level, 0, 0, 0, width, height, depth
            )
        self._device.counters.api_calls += self.desc.mips
