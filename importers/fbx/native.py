"""ufbx without crashes: every object that it hands out is kept alive for as long as the process lives.

The binding returns borrowed references from list indexing and from attributes; a `Handle` takes one reference more of
each, so nothing is ever freed. Only for a worker process, which ends by os._exit.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from typing import Any

import numpy as np
import ufbx
from numpy.typing import DTypeLike, NDArray

_KEPT: list[Any] = []
_PLAIN = (bool, int, float, str, bytes, tuple)
_METHOD = type(len)
_increase = ctypes.pythonapi.Py_IncRef
_increase.argtypes = [ctypes.py_object]
_increase.restype = None


class Handle:
    """A ufbx object. Attributes that are objects come as handles too; `raw` is the object itself."""

    __slots__ = ("raw",)

    def __init__(self, raw: Any) -> None:
        self.raw = raw

    def __getattr__(self, name: str) -> Any:
        return wrap(getattr(self.raw, name))

    def __len__(self) -> int:
        return len(self.raw)

    def __bool__(self) -> bool:
        return True  # an empty list is still there

    def __iter__(self) -> Iterator[Any]:
        for index in range(len(self.raw)):
            yield wrap(self.raw[index])


def wrap(value: Any) -> Any:
    """`value` itself where it is plain data, else a handle that keeps it alive."""
    if value is None or isinstance(value, _PLAIN):
        return value
    if isinstance(value, _METHOD):
        return lambda *arguments: wrap(value(*arguments))
    _increase(value)
    _KEPT.append(value)
    return Handle(value)


def array(values: Handle, dtype: DTypeLike, components: int = 1) -> NDArray[Any]:
    """A copy of a list of numbers or vectors: [n], or [n, components]."""
    shape = (-1,) if components == 1 else (-1, components)
    if not len(values):
        return np.zeros((0, components) if components > 1 else 0, dtype)
    return np.array(np.asarray(values.raw), dtype).reshape(shape)


def load(path: str, **options: Any) -> Handle:
    """ufbx.load_file, as a handle. Raises ufbx.UfbxError."""
    handle: Handle = wrap(ufbx.load_file(path, **options))
    return handle


def bake(scene: Handle, anim: Handle, **options: Any) -> Handle:
    """ufbx.bake_anim, as a handle. Raises ufbx.UfbxError."""
    handle: Handle = wrap(ufbx.bake_anim(scene.raw, anim.raw, **options))
    return handle
