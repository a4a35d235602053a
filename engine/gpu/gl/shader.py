"""Compiling and linking GLSL; programs are shared by all pipelines of equal text.

A ProgramBuild asks the driver for nothing before `finish`: drivers with KHR_parallel_shader_compile then work in
threads of their own, and `done` says when they have.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from engine.gpu.compile_log import compile_error, link_error
from engine.gpu.gl import enums as e
from engine.gpu.gl.objects import GlObject
from engine.gpu.program_cache import Binary
from engine.gpu.types import ShaderSource

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice

#: enabled in every stage where the driver has them: gl_Layer in vertex shaders, gl_BaseInstanceARB
WANTED_EXTENSIONS = ("GL_ARB_shader_viewport_layer_array", "GL_ARB_shader_draw_parameters")
#: compiling goes on while the calls have returned
PARALLEL = frozenset({"GL_KHR_parallel_shader_compile", "GL_ARB_parallel_shader_compile"})


def version_prelude(version: tuple[int, int], extensions: frozenset[str]) -> str:
    """What goes before the flattened text; its last line makes the driver count from 1 again."""
    lines = ["#version 450 core" if version >= (4, 5) else "#version 430 core"]
    lines += [f"#extension {name} : enable" for name in WANTED_EXTENSIONS if name in extensions]
    return "\n".join([*lines, "#line 1", ""])


class GlProgram(GlObject):
    """A linked program. `loaded`: it came from the program cache."""

    KIND = "program"
    __slots__ = ("loaded", "references")

    def __init__(self, device: GlDevice, label: str, name: int, *, loaded: bool = False) -> None:
        self.references = 0
        self.loaded = loaded
        device.objects.live["program"] += 1
        super().__init__(device.objects, name)
        if loaded:
            device.counters.programs_loaded += 1
        else:
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


class ProgramBuild:
    """A program on its way. `key`: under which it is kept on the disk, or ''."""

    __slots__ = ("_device", "_label", "_name", "_shaders", "_sources", "key")

    def __init__(self, device: GlDevice, label: str, sources: tuple[ShaderSource, ...], key: str = "") -> None:
        self._device, self._label, self._sources, self.key = device, label, sources, key
        gl = device.gl
        self._name: int = gl.CreateProgram()
        if key:
            gl.ProgramParameteri(self._name, e.PROGRAM_BINARY_RETRIEVABLE_HINT, e.TRUE)
        self._shaders: list[int] = []
        for source in sources:
            shader: int = gl.CreateShader(e.STAGES[source.stage])
            self._shaders.append(shader)
            text = (device.shader_prelude + source.text).encode()
            gl.ShaderSource(shader, 1, ctypes.byref(ctypes.c_char_p(text)), None)
            gl.CompileShader(shader)
            gl.AttachShader(self._name, shader)
        gl.LinkProgram(self._name)

    def done(self) -> bool:
        """Whether `finish` will not wait."""
        if not self._device.caps.extensions & PARALLEL:
            return True
        return bool(_number(self._device.gl.GetProgramiv, self._name, e.COMPLETION_STATUS))

    def finish(self) -> GlProgram:
        """Raises ShaderError. The build is used up either way."""
        gl = self._device.gl
        try:
            for source, shader in zip(self._sources, self._shaders, strict=True):
                if not _number(gl.GetShaderiv, shader, e.COMPILE_STATUS):
                    raise compile_error(source, _log(gl.GetShaderiv, gl.GetShaderInfoLog, shader), self._label)
            if not _number(gl.GetProgramiv, self._name, e.LINK_STATUS):
                log = _log(gl.GetProgramiv, gl.GetProgramInfoLog, self._name)
                raise link_error(self._label, self._sources, log)
        except BaseException:  # an interrupt, too, leaves nothing behind
            self.release()
            raise
        self._drop_shaders()
        name, self._name = self._name, 0
        return GlProgram(self._device, self._label, name)

    def release(self) -> None:
        """Give it up."""
        self._drop_shaders()
        if self._name:
            self._device.gl.DeleteProgram(self._name)
            self._name = 0

    def _drop_shaders(self) -> None:
        for shader in self._shaders:
            self._device.gl.DetachShader(self._name, shader)
            self._device.gl.DeleteShader(shader)
        self._shaders.clear()


def load_binary(device: GlDevice, label: str, binary: Binary) -> GlProgram | None:
    """The program that the driver once gave out; None when it does not take it back (it was updated, or is another)."""
    gl = device.gl
    name: int = gl.CreateProgram()
    gl.ProgramBinary(name, binary.format, binary.data, len(binary.data))
    if not _number(gl.GetProgramiv, name, e.LINK_STATUS):
        gl.DeleteProgram(name)
        return None
    return GlProgram(device, label, name, loaded=True)


def read_binary(device: GlDevice, program: GlProgram) -> Binary | None:
    """What `load_binary` takes; None where the driver gives nothing out."""
    gl = device.gl
    length = _number(gl.GetProgramiv, program.id, e.PROGRAM_BINARY_LENGTH)
    if length < 1:
        return None
    data, written, format = ctypes.create_string_buffer(length), ctypes.c_int(), ctypes.c_uint()
    gl.GetProgramBinary(program.id, length, ctypes.byref(written), ctypes.byref(format), data)
    return Binary(format.value, data.raw[: written.value]) if written.value > 0 else None


def _number(get: Callable[..., Any], name: int, what: int) -> int:
    value = ctypes.c_int()
    get(name, what, ctypes.byref(value))
    return value.value


def _log(get: Callable[..., Any], get_log: Callable[..., Any], name: int) -> str:
    text = ctypes.create_string_buffer(max(1, _number(get, name, e.INFO_LOG_LENGTH)))
    get_log(name, len(text), None, text)
    return text.value.decode(errors="replace")
