"""`lucarna edit [PROJECT|FILE]`: open the editor."""

from __future__ import annotations

import argparse
import os
import sys
from functools import partial
from pathlib import Path

from engine.core.errors import DeviceError, InputError, UsageError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("path", nargs="?", type=Path, help="a project, a folder, a scene or a model")
    parser.add_argument("--screenshot", type=Path, metavar="PNG", help="write a picture of the whole window and exit")
    parser.add_argument("--frames", type=int, default=12, metavar="N", help="frames to draw before it (default 12)")
    parser.add_argument("--size", default="1440x900", metavar="WxH", help="size of the window (default 1440x900)")
    parser.add_argument(
        "--fps", type=int, default=None, metavar="N", help="pictures a second at most (0: as the display shows)"
    )
    parser.add_argument("--no-plugins", action="store_true", help="start without plug-ins")
    parser.add_argument("--select", default="", metavar="NAME", help="select the node of this name once it is open")


def parse_size(text: str) -> tuple[int, int]:
    """`1280x720` -> (1280, 720). Raises UsageError."""
    width, _, height = text.lower().partition("x")
    if not (width.isdigit() and height.isdigit() and 320 <= int(width) <= 16384 and 200 <= int(height) <= 16384):
        raise UsageError(f"--size {text!r} is not a size", hint="give width x height in pixels, such as 1280x720")
    return int(width), int(height)


def run(args: argparse.Namespace) -> int:
    """Returns 0 when the window was closed in good order. Raises UsageError, InputError, DeviceError, OutputError; with
    --screenshot also what kept the file from being opened, after the picture that shows it is written."""
    size = parse_size(args.size)
    if args.frames < 1:
        raise UsageError(f"--frames {args.frames} is not a count", hint="give 1 or more")
    if args.fps is not None and args.fps != 0 and not 5 <= args.fps <= 1000:
        raise UsageError(f"--fps {args.fps} is not a limit", hint="give 5 to 1000, or 0 for the display's own")
    if args.path is not None and not args.path.exists():
        raise InputError("there is no such file or folder", where=args.path)
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise DeviceError(
            "there is no display to open a window on",
            hint="set DISPLAY, or run under xvfb-run; `lucarna render` needs none",
        )
    from editor import journal, preferences, welcome
    from editor.app import App
    from editor.builtin_operations import builtin_operations
    from editor.host import EngineHost
    from editor.session import Session
    from editor.viewport_image import PATIENCE

    picture = args.screenshot is not None
    session = Session(EngineHost(), preferences.Preferences() if picture else preferences.load())
    session.save_preferences = not picture
    session.select_on_open = args.select
    session.image.patience = None if picture else PATIENCE
    if not picture:
        session.recovery_folder = journal.recovery_dir()
        session.ui.recoveries = journal.pending()
    app = App(
        session,
        builtin_operations(),
        size=size,
        frames=args.frames if picture else 0,
        remember_layout=not picture,
        plugins=not args.no_plugins,
        fps=args.fps,
    )
    if args.path is not None:
        app.on_shown = partial(session.open, args.path)
    elif not picture and not session.preferences.welcome_seen:
        app.on_shown = partial(welcome.greet, session)
    app.run()
    if picture:
        from imgui_bundle import hello_imgui

        from editor.screenshot import save_window

        save_window(args.screenshot, hello_imgui.final_app_window_screenshot())
        if session.failure is not None:
            raise session.failure
    return 0
