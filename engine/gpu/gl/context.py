"""Making or finding the OpenGL context, by moderngl, and checking that it has what this backend needs."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

import moderngl

from engine.core.errors import DeviceError
from engine.gpu.gl import enums as e
from engine.gpu.gl.functions import Functions

#: what GL 4.5 brought that this backend needs where the version is lower
EXTENSIONS_BELOW_4_5 = ("GL_ARB_direct_state_access", "GL_ARB_clip_control", "GL_ARB_get_texture_sub_image")
HINT = (
    "update the graphics driver; on Linux without a GPU install Mesa's software renderer "
    "(Debian/Ubuntu: libegl1 libgl1-mesa-dri); `lucarna doctor` shows what is found"
)


@dataclass(slots=True)
class Context:
    """A current OpenGL context. `owned`: made here, so released here; else it belongs to a window."""

    moderngl: Any
    gl: Functions
    owned: bool
    version: tuple[int, int]
    extensions: frozenset[str]

    def make_current(self) -> None:
        if self.owned:  # a window makes its context current itself
            self.moderngl.__enter__()

    def release(self) -> None:
        self.moderngl.release()


def open_context(*, attach: bool) -> Context:
    """The current context (`attach`) or a new one without window: EGL where there is one, else the platform's own."""
    failures: list[str] = []
    context: Any = None
    if attach:
        attempts: list[dict[str, Any]] = [{}]
    elif sys.platform.startswith("linux"):
        attempts = [{"standalone": True, "backend": "egl"}, {"standalone": True}]
    else:
        attempts = [{"standalone": True}]
    for options in attempts:
        try:
            context = moderngl.create_context(require=None, **options)
            break
        except Exception as error:  # the loaders raise whatever they like: Exception, RuntimeError, OSError
            failures.append(f"{options.get('backend', 'the platform')}: {error}")
    if context is None:
        what = "no OpenGL context is current" if attach else "no OpenGL context could be made"
        raise DeviceError(f"{what} ({'; '.join(failures)})", hint=HINT)
    return _checked(context, owned=not attach)


def _checked(context: Any, *, owned: bool) -> Context:
    loader = context.mglo._context  # moderngl is pinned: the loader is a private attribute
    # a context of our own has glcontext's loader, one found in a window has moderngl's
    functions = Functions(loader.load if hasattr(loader, "load") else loader.load_opengl_function)
    version = (functions.integer(e.MAJOR_VERSION), functions.integer(e.MINOR_VERSION))
    count = functions.integer(e.NUM_EXTENSIONS)
    extensions = frozenset(functions.GetStringi(e.EXTENSIONS, i).decode() for i in range(count))
    lacks = lacking(version, extensions) + [f"gl{name}" for name in functions.missing]
    if lacks:
        found = f"OpenGL {version[0]}.{version[1]} by {functions.text(e.RENDERER)} ({functions.text(e.VERSION)})"
        if owned:
            context.release()
        shown = ", ".join(lacks[:6]) + (" …" if len(lacks) > 6 else "")
        raise DeviceError(f"{found} lacks {shown}; OpenGL 4.5 has it all", hint=HINT)
    return Context(context, functions, owned, version, extensions)


def lacking(version: tuple[int, int], extensions: frozenset[str]) -> list[str]:
    """What this backend needs and a driver with `version` and `extensions` does not have."""
    if version >= (4, 5):
        return []
    lacks = ["OpenGL 4.3"] if version < (4, 3) else []
    return lacks + [name for name in EXTENSIONS_BELOW_4_5 if name not in extensions]
