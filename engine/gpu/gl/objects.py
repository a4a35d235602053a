"""GL object names, their counts, and the queue of those that other threads or the garbage collector let go."""

from __future__ import annotations

import threading
from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice

#: our kind -> the plural in glCreate… / glDelete…
PLURALS = {
    "buffer": "Buffers", "texture": "Textures", "sampler": "Samplers", "framebuffer": "Framebuffers",
    "vertex_array": "VertexArrays", "query": "Queries", "program": "",
}  # fmt: skip


class Objects:
    """Creates and deletes GL objects. GL may only be called on the thread of the context, so `let_go` queues."""

    def __init__(self, device: GlDevice) -> None:
        self._device = device
        self._thread = threading.get_ident()
        self._queue: deque[tuple[str, int]] = deque()
        self.live = dict.fromkeys(PLURALS, 0)
        self.open = True

    def create(self, kind: str, *before: int) -> int:
        name = self._device.gl.create(PLURALS[kind], *before)
        self.live[kind] += 1
        return name

    def let_go(self, kind: str, name: int) -> None:
        """Delete now on the device's thread, else at the next end_frame. Safe after the device is gone."""
        if not self.open:
            return
        if threading.get_ident() == self._thread:
            self._delete(kind, name)
        else:
            self._queue.append((kind, name))

    def defer(self, kind: str, name: int) -> None:
        """From `__del__`, which may run anywhere, even amid a pass: delete at the next end_frame."""
        if self.open:
            self._queue.append((kind, name))

    def drain(self) -> None:
        while self._queue:
            self._delete(*self._queue.popleft())

    def _delete(self, kind: str, name: int) -> None:
        device = self._device
        device.make_current()
        device.forget(kind, name)
        if kind == "program":
            device.gl.DeleteProgram(name)
        else:
            device.gl.delete(PLURALS[kind], name)
        self.live[kind] -= 1


class GlObject:
    """Base of what owns one GL object."""

    KIND = ""
    __slots__ = ("_objects", "id")

    def __init__(self, objects: Objects, name: int) -> None:
        self._objects = objects
        self.id = name

    def release(self) -> None:
        """Free it; a second call does nothing."""
        name, self.id = self.id, 0
        if name:
            self._objects.let_go(self.KIND, name)

    def __del__(self) -> None:
        name = getattr(self, "id", 0)
        if name:
            self._objects.defer(self.KIND, name)
