"""What the viewport shows as a command line, so that a picture found by hand can be made by a script."""

from __future__ import annotations

import math
import shlex

from editor.session import Session


def render_command(session: Session) -> str:
    """`lucarna render …` for the open document: camera, size, time and every setting that is not its default.

    Unsaved edits are not in the file, and so not in its picture."""
    document = session.document
    assert document is not None
    path = document.saved_to or document.source
    camera = session.camera
    words = ["lucarna", "render", str(path), "--out", "picture.png", "--size", f"{session.width}x{session.height}"]
    eye = ",".join(f"{float(v):.9g}" for v in camera.eye())
    target = ",".join(f"{v:.9g}" for v in camera.target)
    words += [f"--eye={eye}", f"--target={target}", f"--fov={_degrees(camera.yfov)}"]
    if abs(camera.roll) > 1e-6:
        words.append(f"--up={','.join(f'{float(v):.9g}' for v in camera.rotation()[:, 1])}")
    if camera.orthographic:
        words.append(f"--ortho={camera.ymag:.9g}")
    if session.playback.available and session.playback.time:
        words.append(f"--time={session.playback.time:.9g}")
    settings = session.settings
    for param in settings.PARAMS:
        value = getattr(settings, param.name)
        if value != param.default:
            text = ",".join(f"{v:.9g}" for v in value) if isinstance(value, tuple) else str(value)
            words += ["--set", f"{param.name}={text}"]
    return shlex.join(words)


def _degrees(radians: float) -> str:
    return f"{math.degrees(radians):.9g}"
