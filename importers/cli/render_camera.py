"""A camera given on the command line by where it stands and looks."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING

from engine.core.errors import UsageError

if TYPE_CHECKING:
    from engine.render.camera import Camera


def add_camera_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--eye", default="", metavar="X,Y,Z", help="where a free camera stands, metres")
    parser.add_argument("--target", default="0,0,0", metavar="X,Y,Z", help="what it looks at (default 0,0,0)")
    parser.add_argument("--up", default="0,1,0", metavar="X,Y,Z", help="what is up in its picture (default 0,1,0)")
    parser.add_argument("--fov", type=float, default=45.0, help="its vertical field of view, degrees (default 45)")
    parser.add_argument(
        "--ortho", type=float, default=0.0, metavar="M", help="make it orthographic: half height, metres"
    )


def free_camera(args: argparse.Namespace) -> Camera | None:
    """The camera of --eye, or None without it. Raises UsageError."""
    if not args.eye:
        return None
    from engine.math.transform import look_at
    from engine.render.camera import Camera

    eye, target, up = (_point(name, getattr(args, name)) for name in ("eye", "target", "up"))
    if eye == target:
        raise UsageError("--eye and --target are the same point", hint="a camera looks from one point at another")
    if not 0.0 < args.fov < 180.0 or not 0.0 <= args.ortho < math.inf:
        raise UsageError(f"--fov {args.fov:g} --ortho {args.ortho:g}", hint="fov is 0 to 180 degrees, ortho at least 0")
    distance = math.dist(eye, target)
    near = min(max(0.01 * distance, 1e-6), 0.05)
    return Camera(look_at(eye, target, up), math.radians(args.fov), near, 200.0 * distance, args.ortho)


def _point(name: str, text: str) -> tuple[float, ...]:
    try:
        values = tuple(float(v) for v in text.split(","))
    except ValueError:
        values = ()
    if len(values) != 3 or not all(math.isfinite(v) for v in values):
        raise UsageError(f"--{name} {text!r} is no point", hint="write X,Y,Z in metres, as 0,1.5,4")
    return values
