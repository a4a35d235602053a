"""Waking the window from another thread: it sleeps while nothing happens, and only an event ends that."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

from editor.file_drop import glfw_library


def waker() -> Callable[[], None] | None:
    """A function that any thread may call to make the window draw; None where its library is not glfw's."""
    path = glfw_library()
    if path is None:
        return None
    try:
        post = ctypes.CDLL(str(path)).glfwPostEmptyEvent
    except (OSError, AttributeError):
        return None
    post.argtypes, post.restype = (), None

    def wake() -> None:
        post()

    return wake
