"""Turntable: the camera goes round what it looks at, in the window or into pictures or a video. No imgui."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from editor import work
from editor.camera_controls import OrbitCamera
from editor.operations import Operation, Operations
from editor.screenshot import new_picture
from engine.core.errors import LucarnaError

if TYPE_CHECKING:
    from editor.session import Session

#: seconds of one turn in the window; pictures of one that is saved, and how many a second
TURN, PICTURES, FPS = 12.0, 96, 24.0


def turned(camera: OrbitCamera, share: float) -> OrbitCamera:
    """The camera after `share` of a turn about its target."""
    return replace(camera, yaw=math.remainder(camera.yaw + share * math.tau, math.tau))


def step(session: Session, seconds: float) -> None:
    """Once a frame while it turns."""
    if session.tools.turning and session.document is not None:
        session.camera = turned(session.camera, min(seconds, 0.25) / TURN)


@dataclass(slots=True)
class SaveTurntable:
    """See editor.work.Work: a picture a step, into an .mp4 where the encoder is installed, else into numbered PNGs."""

    title: str = "Saving a turntable"
    progress: float = 0.0
    text: str = ""
    count: int = PICTURES
    video: bool = field(default_factory=lambda: importlib.util.find_spec("imageio_ffmpeg") is not None)
    out: Path | None = None
    _pictures: Iterator[None] | None = None

    def step(self, session: Session) -> bool:
        if session.document is None or session.image.frame is None:
            return False
        if self._pictures is None:
            self._pictures = self._made(session)
        if next(self._pictures, self) is not self:
            return True
        assert self.out is not None
        session.ui.notice = f"Saved {self.out.name}"
        session.messages.info("Saved a turntable", where=str(self.out))
        return False

    def close(self) -> None:
        if self._pictures is not None:
            self._pictures.close()  # type: ignore[attr-defined]  # a generator: ends the encoder too
            self._pictures = None

    def _made(self, session: Session) -> Iterator[None]:
        from engine.report.image import save_png
        from importers.cli.render_sequence import Video

        start = session.camera
        width, height = (max(n // 2 * 2, 2) for n in (session.image.width, session.image.height))
        self.out = new_picture(session, "-turntable.mp4" if self.video else "-turntable_0001.png")
        with ExitStack() as stack:
            video = stack.enter_context(Video(self.out, FPS, (width, height))) if self.video else None
            for i in range(self.count):
                pixels = self._picture(session, turned(start, i / self.count), width, height)
                if video is not None:
                    video.add(pixels)
                else:
                    save_png(self.out.with_name(self.out.name.replace("_0001.png", f"_{i + 1:04d}.png")), pixels)
                self.progress, self.text = (i + 1) / self.count, f"Picture {i + 1} of {self.count}"
                yield
        session.image.invalidate()

    def _picture(self, session: Session, camera: OrbitCamera, width: int, height: int) -> Any:
        document = session.document
        if document is None:
            raise LucarnaError("the document was closed")
        with session.device_frame():
            frame = document.runtime.render(session.host.view(camera, width, height, session.settings))
            return np.ascontiguousarray(np.asarray(frame.color.read(), np.uint8)[:, :, :3])


def add_turntable_operations(ops: Operations) -> None:
    ops.add(
        Operation(
            "view.turntable", "Turntable", _toggle, "View", (), _has_document, lambda s: s.tools.turning,
            doc="The camera goes round what it looks at, once in 12 seconds",
        )
    )  # fmt: skip
    ops.add(
        Operation(
            "file.save-turntable", "Save turntable", lambda s: _start(s), "File", (), _has_document,
            doc="One turn as it is seen now: an .mp4 where imageio-ffmpeg is installed, else numbered pictures",
        )
    )  # fmt: skip


def _start(session: Session) -> None:
    work.start(session, SaveTurntable())


def _toggle(session: Session) -> None:
    session.tools.turning = not session.tools.turning


def _has_document(session: Session) -> bool:
    return session.document is not None
