"""Raw OpenGL functions by ctypes, loaded through the context's own loader."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

_TYPES: dict[str, Any] = {
    "v": None, "i": ctypes.c_int, "u": ctypes.c_uint, "f": ctypes.c_float, "p": ctypes.c_void_p, "s": ctypes.c_char_p,
    "z": ctypes.c_ssize_t, "b": ctypes.c_ubyte,
}  # fmt: skip

#: name without `gl` -> result and argument types, one letter each as in _TYPES
SIGNATURES: dict[str, str] = {
    # queries of the context
    "GetError": "u", "GetString": "su", "GetStringi": "suu", "GetIntegerv": "vup", "GetInteger64v": "vup",
    "GetFloatv": "vup", "GetInternalformativ": "vuuuip", "IsEnabled": "bu", "Finish": "v", "Flush": "v",
    # state
    "Enable": "vu", "Disable": "vu", "Enablei": "vuu", "Disablei": "vuu", "ClipControl": "vuu", "Viewport": "viiii",
    "DepthMask": "vb", "DepthFunc": "vu", "DepthRangef": "vff", "CullFace": "vu", "FrontFace": "vu",
    "PolygonMode": "vuu", "PolygonOffset": "vff", "ColorMask": "vbbbb", "ColorMaski": "vubbbb", "BlendFunc": "vuu",
    "BlendEquation": "vu", "BlendFuncSeparatei": "vuuuuu", "BlendEquationSeparatei": "vuuu", "PixelStorei": "vui",
    "ActiveTexture": "vu", "MemoryBarrier": "vu", "StencilFuncSeparate": "vuuiu", "StencilOpSeparate": "vuuuu",
    "StencilMask": "vu", "BlendColor": "vffff", "SampleMaski": "vuu", "Scissor": "viiii", "PatchParameteri": "vui",
    # buffers
    "CreateBuffers": "vip", "DeleteBuffers": "vip", "NamedBufferData": "vuzpu",
    "ClearNamedBufferData": "vuuuup", "NamedBufferSubData": "vuzzp",
    "GetNamedBufferSubData": "vuzzp", "BindBuffer": "vuu", "BindBufferBase": "vuuu", "BindBufferRange": "vuuuzz",
    # textures and samplers
    "CreateTextures": "vuip", "DeleteTextures": "vip", "TextureStorage2D": "vuiuii", "TextureStorage3D": "vuiuiii",
    "TextureStorage2DMultisample": "vuiuiib", "TextureSubImage2D": "vuiiiiiuup", "TextureSubImage3D": "vuiiiiiiiuup",
    "CompressedTextureSubImage2D": "vuiiiiiuip", "CompressedTextureSubImage3D": "vuiiiiiiiuip",
    "GetTextureSubImage": "vuiiiiiiiuuip", "GenerateTextureMipmap": "vu", "TextureParameteri": "vuui",
    "CopyImageSubData": "vuuiiiiuuiiiiiii", "BindTextureUnit": "vuu", "BindImageTexture": "vuuibiuu",
    "CreateSamplers": "vip", "DeleteSamplers": "vip", "SamplerParameteri": "vuui", "SamplerParameterf": "vuuf",
    "BindSampler": "vuu", "SamplerParameterfv": "vuup",
    # framebuffers
    "CreateFramebuffers": "vip", "DeleteFramebuffers": "vip", "NamedFramebufferTexture": "vuuui",
    "NamedFramebufferTextureLayer": "vuuuii", "NamedFramebufferDrawBuffers": "vuip",
    "NamedFramebufferDrawBuffer": "vuu", "NamedFramebufferReadBuffer": "vuu", "CheckNamedFramebufferStatus": "uuu",
    "BindFramebuffer": "vuu", "ClearNamedFramebufferfv": "vuuip", "ClearNamedFramebufferuiv": "vuuip",
    "ClearNamedFramebufferfi": "vuuifi",
    "BlitNamedFramebuffer": "vuuiiiiiiiiuu",
    # vertex arrays
    "CreateVertexArrays": "vip", "DeleteVertexArrays": "vip", "BindVertexArray": "vu",
    "EnableVertexArrayAttrib": "vuu", "VertexArrayAttribFormat": "vuuiubu", "VertexArrayAttribIFormat": "vuuiuu",
    "VertexArrayAttribBinding": "vuuu", "VertexArrayVertexBuffer": "vuuuzi", "VertexArrayBindingDivisor": "vuuu",
    "VertexArrayElementBuffer": "vuu",
    # shaders
    "CreateShader": "uu", "DeleteShader": "vu", "ShaderSource": "vuipp", "CompileShader": "vu",
    "GetShaderiv": "vuup", "GetShaderInfoLog": "vuipp", "CreateProgram": "u", "DeleteProgram": "vu",
    "AttachShader": "vuu", "DetachShader": "vuu", "LinkProgram": "vu", "GetProgramiv": "vuup",
    "GetProgramInfoLog": "vuipp", "UseProgram": "vu", "GetProgramResourceIndex": "uuus",
    "GetProgramResourceiv": "vuuuipipp", "ProgramParameteri": "vuui", "GetProgramBinary": "vuippp",
    "ProgramBinary": "vuupi",
    # draws and dispatches
    "DrawArraysInstancedBaseInstance": "vuiiiu", "DrawElementsInstancedBaseVertexBaseInstance": "vuiupiiu",
    "MultiDrawElementsIndirect": "vuupii", "DispatchCompute": "vuuu",
    # queries of time
    "CreateQueries": "vuip", "DeleteQueries": "vip", "QueryCounter": "vuu", "GetQueryObjectui64v": "vuup",
    # debug
    "DebugMessageCallback": "vpp", "ObjectLabel": "vuuis", "PushDebugGroup": "vuuis", "PopDebugGroup": "v",
}  # fmt: skip


class Functions:
    """`gl.Viewport(…)`: every function of SIGNATURES as an attribute, without checks of its own."""

    def __init__(self, load: Callable[[str], int]) -> None:
        """`load` gives a function's address or 0; missing ones are listed in `missing`."""
        self.missing: list[str] = []
        for name, signature in SIGNATURES.items():
            address = load("gl" + name)
            if not address:
                self.missing.append(name)
                continue
            prototype = ctypes.CFUNCTYPE(*(_TYPES[letter] for letter in signature))
            setattr(self, name, prototype(address))

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Callable[..., Any]: ...

    def create(self, kind: str, *before: int) -> int:
        """One object of glCreate<kind>."""
        name = ctypes.c_uint()
        getattr(self, "Create" + kind)(*before, 1, ctypes.byref(name))
        return name.value

    def delete(self, kind: str, name: int) -> None:
        """One object by glDelete<kind>."""
        getattr(self, "Delete" + kind)(1, ctypes.byref(ctypes.c_uint(name)))

    def integer(self, what: int) -> int:
        value = ctypes.c_int64()
        self.GetInteger64v(what, ctypes.byref(value))
        return value.value

    def number(self, what: int) -> float:
        value = ctypes.c_float()
        self.GetFloatv(what, ctypes.byref(value))
        return value.value

    def text(self, what: int) -> str:
        return (self.GetString(what) or b"?").decode(errors="replace")
