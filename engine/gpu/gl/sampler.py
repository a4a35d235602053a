"""GlSampler: how a texture is filtered and wrapped."""

from __future__ import annotations

from ctypes import byref, c_float
from typing import TYPE_CHECKING

from engine.gpu import validate
from engine.gpu.gl import enums as e
from engine.gpu.gl.objects import GlObject
from engine.gpu.types import SamplerDesc

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice

_FLOAT4 = c_float * 4


class GlSampler(GlObject):
    KIND = "sampler"
    __slots__ = ("desc",)

    def __init__(self, device: GlDevice, desc: SamplerDesc) -> None:
        validate.sampler_desc(desc)
        self.desc = desc
        super().__init__(device.objects, device.objects.create("sampler"))
        parameter = device.gl.SamplerParameteri
        parameter(self.id, e.TEXTURE_WRAP_S, e.WRAP[desc.wrap_u])
        parameter(self.id, e.TEXTURE_WRAP_T, e.WRAP[desc.wrap_v])
        parameter(self.id, e.TEXTURE_WRAP_R, e.WRAP[desc.wrap_w])
        parameter(self.id, e.TEXTURE_MIN_FILTER, e.FILTER[desc.min_filter])
        parameter(self.id, e.TEXTURE_MAG_FILTER, e.FILTER[desc.mag_filter])
        anisotropy = min(desc.anisotropy, device.caps.max_anisotropy)
        if anisotropy > 1.0:
            device.gl.SamplerParameterf(self.id, e.TEXTURE_MAX_ANISOTROPY, anisotropy)
        if desc.compare:
            parameter(self.id, e.TEXTURE_COMPARE_MODE, e.COMPARE_REF_TO_TEXTURE)
            parameter(self.id, e.TEXTURE_COMPARE_FUNC, e.COMPARE[desc.compare])
        if desc.lod_bias:
            device.gl.SamplerParameterf(self.id, e.TEXTURE_LOD_BIAS, desc.lod_bias)
        device.gl.SamplerParameterf(self.id, e.TEXTURE_MIN_LOD, desc.lod_min)
        device.gl.SamplerParameterf(self.id, e.TEXTURE_MAX_LOD, desc.lod_max)
        device.gl.SamplerParameterfv(self.id, e.TEXTURE_BORDER_COLOR, byref(_FLOAT4(*desc.border)))
        device.counters.api_calls += 11

    def release(self) -> None:
        """Nothing: samplers are shared by all who ask for an equal one, and live as long as the device."""

    def destroy(self) -> None:
        super().release()
