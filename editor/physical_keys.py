"""Keys by their place on the keyboard, whatever letters a layout puts there: what is W on an American keyboard is Z on
a French one, and flies forward on both. Asked of the window's library; where it is another, letters stay as they are.
"""

from __future__ import annotations

import ctypes
import time
from functools import cache
from typing import Any

from editor.file_drop import glfw_library

#: seconds between two looks at the layout, which may be switched at any time
LOOK_EVERY = 1.0
_known: tuple[float, dict[str, str]] = (-1e9, {})


def letter_at(place: str) -> str:
    """The letter that the present layout has where an American keyboard has `place` (a..z)."""
    return _layout().get(place.lower(), place.lower())


def _layout() -> dict[str, str]:
    global _known
    now = time.monotonic()
    if now - _known[0] > LOOK_EVERY:
        _known = (now, read_layout())
    return _known[1]


def read_layout() -> dict[str, str]:
    """Place -> letter, for the places that have another letter than on an American keyboard."""
    name = _key_name()
    if name is None:
        return {}
    found = {}
    for place in "abcdefghijklmnopqrstuvwxyz":
        said = name(ord(place.upper()), 0)  # GLFW's names for places are capitals in ASCII
        letter = said.decode("utf-8", "replace").lower() if said else place
        found[place] = letter if len(letter) == 1 and "a" <= letter <= "z" else place
    # a layout that moves letters moves them among themselves; anything else would run two operations with one key
    return found if sorted(found.values()) == sorted(found) else {}


@cache
def _key_name() -> Any:
    path = glfw_library()
    if path is None:
        return None
    try:
        name = ctypes.CDLL(str(path)).glfwGetKeyName
    except (OSError, AttributeError):
        return None
    name.argtypes, name.restype = (ctypes.c_int, ctypes.c_int), ctypes.c_char_p
    return name
