"""Thumbnails of the files in the assets panel: asked for by path, made elsewhere, shown when they are there. No imgui.

    panel: get(path) ──► WAITING, and a place in the queue          (the panel draws an icon)
    thread: the one asked for last ──► maker in a worker process ──► PNG in the cache ──► pixels
    window, once a frame: pump() uploads a few ──► READY with a texture, or BROKEN with the reason

What was not looked at for a while leaves the queue; textures over LIMIT go, the least recently seen first. A file that
changes is asked for again; so are materials and effects after a hot reload.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from editor.thumbnail_maker import EFFECTS, MATERIALS, has_picture, sort_of
from engine.core.errors import LucarnaError
from engine.report.image import load_png

if TYPE_CHECKING:
    from editor.session import Session

WAITING, READY, BROKEN, NONE = "waiting", "ready", "broken", "none"
#: textures kept, and how many are uploaded in a frame
LIMIT, UPLOADS = 400, 3
#: frames after which what nobody looks at leaves the queue
PATIENCE = 30
#: seconds after which an idle worker process is let go
REST = 60.0
#: (path, modification time in ns, size, shader generation)
Key = tuple[Path, int, int, int]
#: (file, project root) -> the PNG; runs in the thread, raises LucarnaError
Maker = Callable[[Path, Path], Path]


@dataclass(slots=True)
class Thumbnail:
    """`state`: WAITING, READY (`native` is the texture's id), BROKEN (`error` says why) or NONE (files without one)."""

    state: str = WAITING
    native: int = 0
    error: str = ""
    seen: int = 0
    texture: Any = None


class WorkerMaker:
    """The usual maker: one worker process, replaced when it crashes, hangs or grows."""

    def __init__(self) -> None:
        from importers.workers.pool import WorkerPool
        from importers.workers.process import WorkerLimits

        self._pool = WorkerPool(1)
        self._limits = WorkerLimits(seconds=90.0, memory_bytes=0)  # a software rasteriser reserves a lot it never uses

    def __call__(self, path: Path, root: Path) -> Path:
        request = {"path": str(path), "root": str(root)}
        made = self._pool.run("editor.thumbnail_maker:make", request, path, self._limits, "the thumbnail")
        return Path(made["file"])

    def close(self) -> None:
        self._pool.close()


class AssetThumbnails:
    """`make` is called in a thread of its own; `wake` makes a sleeping window draw."""

    def __init__(self, make: Maker | None = None) -> None:
        self.wake: Callable[[], None] = lambda: None
        self.frame = 0
        self._make = make
        self._known: OrderedDict[Key, Thumbnail] = OrderedDict()
        self._latest: dict[Path, Key] = {}
        self._queue: list[tuple[Key, Path]] = []
        self._done: list[tuple[Key, NDArray[np.uint8] | None, str]] = []
        self._lock = threading.Condition()
        self._thread: threading.Thread | None = None
        self._stopped = False

    def get(self, path: Path, stamp: tuple[int, int], root: Path, generation: int = 0) -> Thumbnail:
        """The thumbnail of a file as it is now (`stamp`: its modification time and size). `generation` counts hot
        reloads: materials and effects look different after one."""
        if not has_picture(path.name):
            return Thumbnail(NONE)
        sensitive = sort_of(path.name) in (MATERIALS, EFFECTS)
        key = (path, *stamp, generation if sensitive else 0)
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = self._successor(path)
            with self._lock:
                self._queue.append((key, root))
                self._lock.notify()
            self._start()
        self._known.move_to_end(key)
        self._latest[path] = key
        found.seen = self.frame
        return found

    def pump(self, session: Session) -> None:
        """Once a frame: take over what is done, a few at a time."""
        self.frame += 1
        with self._lock:
            taken, self._done = self._done[:UPLOADS], self._done[UPLOADS:]
            more = bool(self._done)
            stale = {key for key, _ in self._queue if self._unwanted(key)}
            self._queue = [item for item in self._queue if item[0] not in stale]
        for key in stale & self._known.keys():
            self._release(self._known.pop(key), session)
        if taken:
            with session.device_frame():
                for key, pixels, error in taken:
                    self._take(session, key, pixels, error)
        while len(self._known) > LIMIT:
            self._release(self._known.popitem(last=False)[1], session)
        if more:
            self.wake()

    @property
    def waiting(self) -> int:
        """How many are still to be made."""
        with self._lock:
            return len(self._queue)

    def forget(self, session: Session) -> None:
        """Let all textures go: the window closes."""
        for thumbnail in self._known.values():
            self._release(thumbnail, session)
        self._known.clear()
        self._latest.clear()
        with self._lock:
            self._queue.clear()
            self._done.clear()

    def stop(self) -> None:
        """End the thread and its worker."""
        with self._lock:
            self._stopped = True
            self._queue.clear()
            self._lock.notify()
        if isinstance(self._make, WorkerMaker):
            self._make.close()
        if self._thread is not None:
            self._thread.join(2.0)

    # --- inside ---

    def _unwanted(self, key: Key) -> bool:
        """Whether nobody looked at it for a while, or another has taken its place."""
        known = self._known.get(key)
        return known is None or self.frame - known.seen > PATIENCE

    def _successor(self, path: Path) -> Thumbnail:
        """A new entry; it shows what the file looked like before until it is made."""
        before = self._known.pop(self._latest[path], None) if path in self._latest else None
        if before is None or before.texture is None:
            return Thumbnail()
        return Thumbnail(READY, before.native, texture=before.texture)

    def _take(self, session: Session, key: Key, pixels: NDArray[np.uint8] | None, error: str) -> None:
        from engine.gpu.types import TextureDesc

        thumbnail = self._known.get(key)
        if thumbnail is None:
            return  # nobody wants it any more
        if thumbnail.texture is not None:
            thumbnail.texture.release()
            thumbnail.texture, thumbnail.native = None, 0
        if pixels is None:
            thumbnail.state, thumbnail.error = BROKEN, error
            return
        height, width = pixels.shape[:2]
        texture = session.device.texture(TextureDesc("rgba8", width, height, label="thumbnail"))
        texture.write(pixels)
        thumbnail.state, thumbnail.texture, thumbnail.native = READY, texture, int(texture.native)

    @staticmethod
    def _release(thumbnail: Thumbnail, session: Session) -> None:
        if thumbnail.texture is not None:
            with session.device_frame():
                thumbnail.texture.release()

    def _start(self) -> None:
        if self._thread is None and not self._stopped:
            self._thread = threading.Thread(target=self._run, name="thumbnails", daemon=True)
            self._thread.start()

    def _run(self) -> None:
        own = self._make is None
        while True:
            item = self._next()
            if self._stopped:
                return
            if item is None:
                if own and isinstance(self._make, WorkerMaker):
                    self._make.close()  # nothing to do for a while: its process need not wait
                    self._make = None
                continue
            if self._make is None:
                self._make = WorkerMaker()
            key, root = item
            pixels, error = self._one(key[0], root)
            with self._lock:
                self._done.append((key, pixels, error))
            self.wake()

    def _next(self) -> tuple[Key, Path] | None:
        """What was asked for last, which the user looks at now; None when there was nothing for REST seconds."""
        with self._lock:
            if not self._queue and not self._stopped:
                self._lock.wait(REST)
            return self._queue.pop() if self._queue else None

    def _one(self, path: Path, root: Path) -> tuple[NDArray[np.uint8] | None, str]:
        assert self._make is not None
        try:
            pixels = load_png(self._make(path, root))
        except LucarnaError as error:
            return None, str(error)
        if pixels.shape[2] == 3:
            pixels = np.concatenate([pixels, np.full((*pixels.shape[:2], 1), 255, np.uint8)], axis=2)
        return np.ascontiguousarray(pixels), ""
