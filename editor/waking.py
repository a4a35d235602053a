"""Waking the window from another thread: it sleeps while nothing happens, and only an event ends that.

thread: a job's step or end, a file that changed, Ctrl+C ──► wake() ──► an empty event ──► one frame, and a few more
"""

from __future__ import annotations

import ctypes
import threading
import time
from collections.abc import Callable

from editor.file_drop import glfw_library

#: seconds between two words of the same work: a bar that grows needs no more pictures
WORD_EVERY = 0.1

_woken = threading.Event()
_post: Callable[[], None] | None = None


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

    def run() -> None:
        post()

    return run


def connect(post: Callable[[], None] | None) -> None:
    """From now on `wake` calls `post`; None: there is no window to wake."""
    global _post
    _post = post


def wake() -> None:
    """Make the window draw, whichever thread asks; without a window nothing happens."""
    _woken.set()
    post = _post
    if post is not None:
        post()


def take() -> bool:
    """Whether somebody called `wake` since the last `take`."""
    woken = _woken.is_set()
    _woken.clear()
    return woken


class Word:
    """`say()`: wake the window, but not more often than a user can read."""

    def __init__(self) -> None:
        self._said = -1e9

    def say(self) -> None:
        now = time.monotonic()
        if now - self._said >= WORD_EVERY:
            self._said = now
            wake()
