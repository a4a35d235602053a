"""Files dropped on the window: glfw's drop callback, reached through the library that the window itself uses.

Where the library or the window is not glfw's, dropping is not available and everything else works."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

_LIBRARIES = {"linux": "libglfw.so.3", "darwin": "libglfw.3.dylib", "win32": "glfw3.dll"}
_CALLBACK = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.POINTER(ctypes.c_char_p))


def glfw_library() -> Path | None:
    """The file of the library that makes the window, or None."""
    import imgui_bundle

    name = _LIBRARIES.get(sys.platform)
    library = Path(imgui_bundle.__file__).parent / name if name else None
    return library if library is not None and library.is_file() else None


def install(window_address: int, on_drop: Callable[[list[Path]], None]) -> Any:
    """Call `on_drop` with the paths of every drop. Returns what must be kept alive as long as the window, or None."""
    library = glfw_library()
    if not window_address or library is None:
        return None

    def receive(_window: int, count: int, paths: Any) -> None:
        on_drop([Path(paths[i].decode("utf-8", "surrogateescape")) for i in range(count)])

    callback = _CALLBACK(receive)
    try:
        glfw = ctypes.CDLL(str(library))
        glfw.glfwSetDropCallback.argtypes = (ctypes.c_void_p, _CALLBACK)
        glfw.glfwSetDropCallback.restype = ctypes.c_void_p
        glfw.glfwSetDropCallback(window_address, callback)
    except (OSError, AttributeError):
        return None
    return callback
