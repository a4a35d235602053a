"""Framebuffers: one GL object per set of attachments, made at the first pass that needs it."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import c_uint
from typing import TYPE_CHECKING

from engine.core.errors import DeviceError
from engine.gpu import formats
from engine.gpu.gl import enums as e
from engine.gpu.gl.texture import GlTexture
from engine.gpu.types import ColorAttachment, DepthAttachment

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice

Key = tuple[tuple[int, int, int], ...]


class Framebuffers:
    """The cache. Entries go when a texture in them goes."""

    def __init__(self, device: GlDevice) -> None:
        self._device = device
        self._cache: dict[Key, int] = {}

    def get(self, label: str, colors: Sequence[ColorAttachment], depth: DepthAttachment | None) -> int:
        """The framebuffer of these attachments (validated before)."""
        key: Key = tuple([(c.texture.native, c.level, c.layer) for c in colors])
        if depth is not None:
            key = (*key, (depth.texture.native, -1, depth.layer))
        name = self._cache.get(key)
        if name is None:
            name = self._create(label, colors, depth)
            self._cache[key] = name
        return name

    def _create(self, label: str, colors: Sequence[ColorAttachment], depth: DepthAttachment | None) -> int:
        device = self._device
        gl = device.gl
        name = device.objects.create("framebuffer")
        for index, color in enumerate(colors):
            self._attach(name, e.COLOR_ATTACHMENT0 + index, color.texture, color.level, color.layer)
        if depth is not None:
            stencil = depth.texture.desc.format in formats.STENCIL
            point = e.DEPTH_STENCIL_ATTACHMENT if stencil else e.DEPTH_ATTACHMENT
            self._attach(name, point, depth.texture, 0, depth.layer)
        if colors:
            points = (c_uint * len(colors))(*(e.COLOR_ATTACHMENT0 + i for i in range(len(colors))))
            gl.NamedFramebufferDrawBuffers(name, len(colors), points)
        else:
            gl.NamedFramebufferDrawBuffer(name, e.NONE)
            gl.NamedFramebufferReadBuffer(name, e.NONE)
        status = gl.CheckNamedFramebufferStatus(name, e.FRAMEBUFFER)
        device.counters.api_calls += 4 + len(colors)
        if status != e.FRAMEBUFFER_COMPLETE:
            device.objects.let_go("framebuffer", name)
            kinds = ", ".join(c.texture.desc.format for c in colors) or "none"
            raise DeviceError(
                f"render pass {label!r}: this device cannot draw into these attachments together (status {status:#x}; "
                f"colours: {kinds}; depth: {depth.texture.desc.format if depth else 'none'})"
            )
        device.label("framebuffer", name, label)
        return name

    def _attach(self, name: int, point: int, texture: object, level: int, layer: int) -> None:
        assert isinstance(texture, GlTexture), f"not a texture of this device: {texture!r}"
        if texture.layered and layer >= 0:
            self._device.gl.NamedFramebufferTextureLayer(name, point, texture.id, level, layer)
        else:
            self._device.gl.NamedFramebufferTexture(name, point, texture.id, level)

    def forget_texture(self, texture: int) -> None:
        """A texture is deleted: drop the framebuffers that hold it."""
        for key in [k for k in self._cache if any(part[0] == texture for part in k)]:
            self._device.objects.let_go("framebuffer", self._cache.pop(key))

    def clear(self) -> None:
        while self._cache:
            self._device.objects.let_go("framebuffer", self._cache.popitem()[1])
