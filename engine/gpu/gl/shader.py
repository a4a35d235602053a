"""Compiling and linking GLSL; programs are shared by all pipelines of equal text."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from engine.gpu.compile_log import compile_error, link_error
from engine.gpu.gl import enums as e
from engine.gpu.gl.objects import GlObject
from engine.gpu.types import ShaderSource

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice

#: enabled in every stage where the driver has them: gl_Layer in vertex shaders, gl_BaseInstanceARB
WANTED_EXTENSIONS = ("GL_ARB_shader_viewport_layer_array", "GL_ARB_shader_draw_parameters")


def version_prelude(version: tuple[int, int], extensions: frozenset[str]) -> str:
    """What goes before the flattened text; its last line makes the driver count from 1 again."""
    lines = ["#version 450 core" if version >= (4, 5) else "#version 430 core"]
    lines += [f"#extension {name} : enable" for name in WANTED_EXTENSIONS if name in extensions]
    return "\n".join([*lines, "#line 1", ""])


class GlProgram(GlObject):
    KIND = "program"
    __slots__ = ("references",)

    def __init__(self, device: GlDevice, label: str, sources: tuple[ShaderSource, ...]) -> None:
        self.references = 0
        gl = device.gl
        shaders: list[int] = []
        try:
            for source in sources:
                shaders.append(_compile(device, label, source))
            name = gl.CreateProgram()
            for shader in shaders:
                gl.AttachShader(name, shader)
            gl.LinkProgram(name)
            status = ctypes.c_int()
            gl.GetProgramiv(name, e.LINK_STATUS, ctypes.byref(status))
            if not status.value:
                log = _log(gl.GetProgramiv, gl.GetProgramInfoLog, name)
                gl.DeleteProgram(name)
                raise link_error(label, sources, log)
            for shader in shaders:
                gl.DetachShader(name, shader)
        finally:
            for shader in shaders:
                gl.DeleteShader(shader)
        device.objects.live["program"] += 1
        super().__init__(device.objects, name)
        device.counters.programs_compiled += 1
        device.label(self.KIND, name, label)

    def block_size(self, device: GlDevice, name: str) -> int:
        gl = device.gl
        for interface in (e.UNIFORM_BLOCK, e.SHADER_STORAGE_BLOCK):
            index = gl.GetProgramResourceIndex(self.id, interface, name.encode())
            if index != e.INVALID_INDEX:
                what, value = ctypes.c_uint(e.BUFFER_DATA_SIZE), ctypes.c_int()
                gl.GetProgramResourceiv(self.id, interface, index, 1, ctypes.byref(what), 1, None, ctypes.byref(value))
                return value.value
        return -1


def _compile(device: GlDevice, label: str, source: ShaderSource) -> int:
    gl = device.gl
    shader: int = gl.CreateShader(e.STAGES[source.stage])
    text = (device.shader_prelude + source.text).encode()
    gl.ShaderSource(shader, 1, ctypes.byref(ctypes.c_char_p(text)), None)
    gl.CompileShader(shader)
    status = ctypes.c_int()
    gl.GetShaderiv(shader, e.COMPILE_STATUS, ctypes.byref(status))
    if not status.value:
        log = _log(gl.GetShaderiv, gl.GetShaderInfoLog, shader)
        gl.DeleteShader(shader)
        raise compile_error(source, log, label)
    return shader


def _log(get: Callable[..., Any], get_log: Callable[..., Any], name: int) -> str:
    length = ctypes.c_int()
    get(name, e.INFO_LOG_LENGTH, ctypes.byref(length))
    text = ctypes.create_string_buffer(max(1, length.value))
    get_log(name, len(text), None, text)
    return text.value.decode(errors="replace")
