"""Making or finding the OpenGL context, and checking that it has what this backend needs.

A context without a window comes from glcontext. A window's context is already current: only its loader is looked up.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from ctypes.util import find_library
from dataclasses import dataclass
from functools import partial
from typing import Any

import glcontext

from engine.core.errors import DeviceError
from engine.gpu.gl import enums as e
from engine.gpu.gl.functions import Functions

#: what GL 4.5 brought that this backend needs where the version is lower
EXTENSIONS_BELOW_4_5 = ("GL_ARB_direct_state_access", "GL_ARB_clip_control", "GL_ARB_get_texture_sub_image")
HINT = (
    "update the graphics driver; on Linux without a GPU install Mesa's software renderer "
    "(Debian/Ubuntu: libegl1 libgl1-mesa-dri); `lucarna doctor` shows what is found"
)
#: what is asked of a new context; drivers give the newest that is compatible
ASKED_VERSIONS = (450, 430)
#: per platform: library, its usual file name, the call that tells the current context, the call that finds functions
_LIBRARIES = {
    "linux": (
        ("EGL", "libEGL.so.1", "eglGetCurrentContext", "eglGetProcAddress"),
        ("GL", "libGL.so.1", "glXGetCurrentContext", "glXGetProcAddressARB"),
    ),
    "win32": (("opengl32", "opengl32.dll", "wglGetCurrentContext", "wglGetProcAddress"),),
}
_NOT_FOUND = (None, 0, 1, 2, 3, ctypes.c_void_p(-1).value)  # wglGetProcAddress says no in all these ways


@dataclass(slots=True)
class Context:
    """A current OpenGL context. `handle`: glcontext's object where the context was made here; None for a window's."""

    handle: Any
    gl: Functions
    version: tuple[int, int]
    extensions: frozenset[str]

    def make_current(self) -> None:
        if self.handle is not None:  # a window makes its context current itself
            self.handle.__enter__()

    def release(self) -> None:
        if self.handle is not None:
            self.handle.release()
            self.handle = None


def open_context(*, attach: bool) -> Context:
    """The window's current context (`attach`) or a new one: EGL where there is one, else the platform's own way."""
    if attach:
        return _checked(None, _current_loader())
    failures: list[str] = []
    for backend in ("egl", "") if sys.platform.startswith("linux") else ("",):
        for version in ASKED_VERSIONS:
            try:
                make = glcontext.get_backend_by_name(backend) if backend else glcontext.default_backend()
                handle = make(mode="standalone", glversion=version)
            except Exception as error:  # the loaders raise Exception itself, besides OSError and ImportError
                failures.append(f"{backend or 'the window system'}: {error}")
                continue
            return _checked(handle, handle.load)
    raise DeviceError(f"no OpenGL context could be made ({'; '.join(dict.fromkeys(failures))})", hint=HINT)


def _current_loader() -> Callable[[str], int]:
    """name -> address of an OpenGL function in the context that is current on this thread."""
    for name, usual, current, find in _LIBRARIES.get(sys.platform, ()):
        try:
            library = ctypes.CDLL(find_library(name) or usual)
            tell, look_up = getattr(library, current), getattr(library, find)
        except (OSError, AttributeError):
            continue
        tell.restype = look_up.restype = ctypes.c_void_p
        look_up.argtypes = [ctypes.c_char_p]
        if tell():
            return partial(_address, library, look_up)
    raise DeviceError(
        "no OpenGL context is current on this thread", hint="open the window first, and the device on the same thread"
    )


def _address(library: ctypes.CDLL, look_up: Callable[[bytes], int | None], function: str) -> int:
    address = look_up(function.encode())
    if address in _NOT_FOUND:  # on Windows the functions of OpenGL 1.1 are plain exports
        export = getattr(library, function, None)
        address = ctypes.cast(export, ctypes.c_void_p).value if export is not None else 0
    return address or 0


def _checked(handle: Any, load: Callable[[str], int]) -> Context:
    functions = Functions(load)
    version = (functions.integer(e.MAJOR_VERSION), functions.integer(e.MINOR_VERSION))
    count = functions.integer(e.NUM_EXTENSIONS)
    extensions = frozenset(functions.GetStringi(e.EXTENSIONS, i).decode() for i in range(count))
    lacks = lacking(version, extensions) + [f"gl{name}" for name in functions.missing]
    if lacks:
        found = f"OpenGL {version[0]}.{version[1]} by {functions.text(e.RENDERER)} ({functions.text(e.VERSION)})"
        if handle is not None:
            handle.release()
        shown = ", ".join(lacks[:6]) + (" …" if len(lacks) > 6 else "")
        raise DeviceError(f"{found} lacks {shown}; OpenGL 4.5 has it all", hint=HINT)
    return Context(handle, functions, version, extensions)


def lacking(version: tuple[int, int], extensions: frozenset[str]) -> list[str]:
    """What this backend needs and a driver with `version` and `extensions` does not have."""
    if version >= (4, 5):
        return []
    lacks = ["OpenGL 4.3"] if version < (4, 3) else []
    return lacks + [name for name in EXTENSIONS_BELOW_4_5 if name not in extensions]
