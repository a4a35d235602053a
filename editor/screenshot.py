"""Pictures of the viewport and of the whole window, as PNG."""

from __future__ import annotations

import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from editor.session import Session
from engine.core.errors import LucarnaError


def picture_folder(session: Session) -> Path:
    """Where F12 writes: `pictures/` of the project, else beside the opened file."""
    document = session.document
    assert document is not None
    if document.project_root is not None:
        return document.project_root / "pictures"
    return document.source if document.source.is_dir() else document.source.parent


def new_picture(session: Session, ending: str = ".png") -> Path:
    """A name for a picture of the open document that tells when it was made."""
    document = session.document
    assert document is not None
    stem = Path(document.name).stem or "viewport"
    return picture_folder(session) / f"{stem}-{time.strftime('%Y%m%d-%H%M%S')}{ending}"


def stamp(session: Session) -> dict[str, str]:
    """How the picture is seen, for its metadata: every render setting, what lights the scene and how, the curve, the
    camera, and the command line that makes the picture again."""
    from editor.as_command import render_command

    document = session.document
    assert document is not None
    scene = document.runtime.scene
    found = {"source": document.source.name, "command": render_command(session)}
    found |= {name: str(value) for name, value in session.settings.values().items()}
    found |= {f"environment.{name}": str(value) for name, value in asdict(scene.environment).items()}
    found |= {f"look.{name}": str(value) for name, value in asdict(scene.look).items()}
    camera = session.camera
    for name, value in (("eye", camera.eye()), ("target", camera.target)):
        found[f"camera.{name}"] = ",".join(f"{float(v):.9g}" for v in value)
    found["camera.yfov"] = f"{camera.yfov:.9g}"
    found["time"] = f"{session.playback.time:.9g}"
    return {f"lucarna.{name}": value for name, value in found.items()}


def save_viewport(session: Session) -> Path | None:
    """Write what the viewport shows to a new PNG, with how it was seen in its metadata; None when it failed."""
    from engine.report.image import save_png

    pixels, frame = session.image.pixels(), session.image.frame
    if pixels is not None and getattr(frame, "legend", None) is not None:
        from engine.app.headless import with_legend

        pixels = with_legend(np.asarray(pixels, np.uint8), frame)
    if pixels is None or session.document is None:
        return None
    path = new_picture(session)
    try:
        save_png(path, pixels, stamp(session))
    except LucarnaError as error:
        session.fail(error)
        return None
    session.ui.notice = f"Saved {path.name}"
    session.messages.info("Saved the viewport's picture", where=str(path))
    return path


def save_window(path: Path, pixels: Any) -> None:
    """Write a window screenshot u1[h,w,3|4]. Raises OutputError, or LucarnaError when there is nothing in it."""
    from engine.report.image import save_png

    array = np.ascontiguousarray(pixels)
    if array.size == 0 or array.ndim != 3:
        raise LucarnaError("the window gave no picture", where=path, hint="is there a display?")
    save_png(path, np.ascontiguousarray(array[:, :, :3]), {"software": "Lucarna"})
