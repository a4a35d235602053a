"""Whether anybody looks at the window: asked of the library that made it."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Literal

from editor.file_drop import glfw_library

#: front: it has the keyboard; behind: another window has; away: minimised or hidden
Sight = Literal["front", "behind", "away"]
#: GLFW's names for what a window is
_FOCUSED, _ICONIFIED, _VISIBLE = 0x00020001, 0x00020002, 0x00020004


def sight(window_address: int) -> Callable[[], Sight]:
    """A function that says how the window stands now. Where it cannot be asked, or nobody gives windows the keyboard (a
    display without a window manager), it is in front. On the window's thread."""
    library = glfw_library()
    if not window_address or library is None:
        return lambda: "front"
    try:
        attribute = ctypes.CDLL(str(library)).glfwGetWindowAttrib
    except (OSError, AttributeError):
        return lambda: "front"
    attribute.argtypes, attribute.restype = (ctypes.c_void_p, ctypes.c_int), ctypes.c_int
    was_front = False

    def look() -> Sight:
        nonlocal was_front
        if attribute(window_address, _ICONIFIED) or (was_front and not attribute(window_address, _VISIBLE)):
            return "away"
        if attribute(window_address, _FOCUSED):
            was_front = True
        return "behind" if was_front and not attribute(window_address, _FOCUSED) else "front"

    return look
