"""Programs of a device by their text: compiled once, begun ahead of time, or taken from the disk."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

from engine.gpu.gl import enums as e
from engine.gpu.gl.shader import GlProgram, ProgramBuild, load_binary, read_binary
from engine.gpu.pipeline_keys import program_key, sources_of
from engine.gpu.program_cache import ProgramCache, open_cache
from engine.gpu.types import ComputePipelineDesc, RenderPipelineDesc

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice

Desc = RenderPipelineDesc | ComputePipelineDesc


class ProgramStore:
    """`cache`: None where it is off or the driver gives no binaries out."""

    def __init__(self, device: GlDevice) -> None:
        self._device = device
        self._programs: dict[tuple[object, ...], GlProgram] = {}
        self._begun: dict[tuple[object, ...], ProgramBuild | GlProgram] = {}
        self._formats = _binary_formats(device)
        self.cache: ProgramCache | None = None
        if self._formats:
            gl = device.gl
            self.cache = open_cache((gl.text(e.VENDOR), gl.text(e.RENDERER), gl.text(e.VERSION)))

    def get(self, desc: Desc) -> GlProgram:
        """Raises ShaderError with file:line:column when it does not compile or link."""
        key = program_key(desc)
        program = self._programs.get(key)
        if program is None:
            self._device.ensure_current()
            begun = self._begun.pop(key, None) or self._start(desc)
            program = self._programs[key] = begun if isinstance(begun, GlProgram) else self._finish(begun)
        return program

    def begin(self, desc: Desc) -> bool:
        """Start it; True once `get` will not wait."""
        key = program_key(desc)
        if key in self._programs:
            return True
        self._device.ensure_current()
        if key not in self._begun:
            self._begun[key] = self._start(desc)
        begun = self._begun[key]
        return isinstance(begun, GlProgram) or begun.done()

    def drop(self, program: GlProgram) -> None:
        """A user let it go; the last one frees it."""
        program.references -= 1
        if program.references == 0:
            for key in [k for k, p in self._programs.items() if p is program]:
                del self._programs[key]
            program.release()

    def abandon(self) -> None:
        """Let go what was begun and nobody came for."""
        for begun in self._begun.values():
            begun.release()
        self._begun.clear()

    def _start(self, desc: Desc) -> ProgramBuild | GlProgram:
        sources = sources_of(desc)
        key = ""
        if self.cache is not None:
            key = self.cache.key((s.stage, self._device.shader_prelude + s.text) for s in sources)
            binary = self.cache.get(key)
            if binary is not None and binary.format in self._formats:
                program = load_binary(self._device, desc.label, binary)
                if program is not None:
                    return program
            if binary is not None:
                self.cache.forget(key)
        return ProgramBuild(self._device, desc.label, sources, key)

    def _finish(self, build: ProgramBuild) -> GlProgram:
        program = build.finish()
        if self.cache is not None and build.key:
            binary = read_binary(self._device, program)
            if binary is not None:
                self.cache.put(build.key, binary)
        return program


def _binary_formats(device: GlDevice) -> frozenset[int]:
    """The formats in which the driver gives programs out; none on some, where there is nothing to keep."""
    count = device.gl.integer(e.NUM_PROGRAM_BINARY_FORMATS)
    if count < 1:
        return frozenset()
    formats = (ctypes.c_int * count)()
    device.gl.GetIntegerv(e.PROGRAM_BINARY_FORMATS, formats)
    return frozenset(value & 0xFFFFFFFF for value in formats)
