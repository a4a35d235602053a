"""`lucarna render` of many pictures: a range of frames, or a turn about the scene; as numbered pictures or a video."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.core.atomic import atomic_path
from engine.core.errors import OutputError, UsageError

if TYPE_CHECKING:
    from engine.app.runtime import Runtime
    from engine.render.camera import Camera
    from engine.render.frame import Frame
    from engine.render.settings import RenderSettings
    from engine.render.view import View

PICTURES = (".png", ".exr")
VIDEOS = {".mp4": "libx264", ".webm": "libvpx-vp9"}
#: moments at which a moving scene is looked at to find a camera that sees all of it
_LOOKS = 12
_NUMBER = re.compile(r"%0?(\d*)d")
MOST_FRAMES = 100_000


@dataclass(frozen=True, slots=True)
class Sequence:
    """`numbers` name the pictures, `times` in seconds; `turns`: degrees that the camera has gone round at each."""

    numbers: list[int]
    times: list[float]
    turns: list[float] | None
    fps: float


def add_sequence_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--clip", action="append", default=[], metavar="NAME", help="play this clip (name or number; again: over it)"
    )
    parser.add_argument(
        "--frames",
        default="",
        metavar="A:B",
        help="pictures A to B - 1 at --fps, or 'all' of the clip, as out_%%04d.png",
    )
    parser.add_argument("--fps", type=float, default=24.0, help="frames per second (default 24)")
    parser.add_argument(
        "--turntable",
        type=int,
        default=0,
        metavar="N",
        help="N pictures once round the scene, standing still at --time",
    )


def check_arguments(args: argparse.Namespace) -> None:
    """Raise UsageError for what cannot go together, before anything is opened."""
    suffix = args.out.suffix.lower()
    many = bool(args.frames or args.turntable)
    if suffix in VIDEOS and not many:
        raise UsageError("a video needs --frames or --turntable", hint="--frames all --fps 24")
    if suffix not in PICTURES and suffix not in VIDEOS:
        raise UsageError(
            f"cannot write {args.out.suffix or 'a file without extension'}", hint="use .png, .exr, .mp4 or .webm"
        )
    if args.frames and args.turntable:
        raise UsageError("--frames and --turntable are two ways to make many pictures", hint="use one of them")
    if not (math.isfinite(args.fps) and args.fps > 0.0):
        raise UsageError(f"--fps {args.fps:g}", hint="frames per second, more than 0")
    if args.turntable < 0 or args.turntable > MOST_FRAMES:
        raise UsageError(f"--turntable {args.turntable}", hint=f"1 to {MOST_FRAMES} pictures")
    if args.turntable and (args.camera not in ("", "auto") or args.eye):
        raise UsageError("--turntable has its own camera", hint="choose its direction with --orbit")
    if args.frames and args.frames != "all":
        _range(args.frames)
    if many and suffix in PICTURES:
        pattern = _NUMBER.sub("", args.out.name)
        if "%" in pattern or len(_NUMBER.findall(args.out.name)) > 1:
            raise UsageError(f"--out {args.out.name!r}: one number, written %04d", hint="as walk_%04d.png")


def play_clips(runtime: Runtime, names: list[str]) -> None:
    """Play the clips of --clip: names, or numbers where no clip has that name. Raises InputError."""
    if names:
        known = {clip.name for clip in runtime.clips}
        runtime.play(*(int(n) if n.isdecimal() and n not in known else n for n in names))


def sequence(args: argparse.Namespace, duration: float) -> Sequence | None:
    """What to render, or None for one picture. `duration`: seconds of the clip, for `--frames all`."""
    if args.turntable:
        count = args.turntable
        return Sequence(list(range(count)), [args.time] * count, [360.0 * i / count for i in range(count)], args.fps)
    if not args.frames:
        return None
    first, end = (0, max(1, round(duration * args.fps))) if args.frames == "all" else _range(args.frames)
    if end - first > MOST_FRAMES:
        raise UsageError(f"{end - first} frames", hint=f"at most {MOST_FRAMES} at a time")
    numbers = list(range(first, end))
    return Sequence(numbers, [args.time + n / args.fps for n in numbers], None, args.fps)


def picture_name(out: Path, number: int) -> Path:
    """`walk_%04d.png` -> `walk_0007.png`; without a place for the number, `_%04d` is added to the name."""
    name = out.name if _NUMBER.search(out.name) else f"{out.stem}_%04d{out.suffix}"
    return out.with_name(_NUMBER.sub(lambda found: f"{number:0{int(found.group(1) or 0)}d}", name))


def write_sequence(
    runtime: Runtime,
    args: argparse.Namespace,
    plan: Sequence,
    settings: RenderSettings,
    size: tuple[int, int],
    camera: Callable[[float], Camera],
    write: Callable[[Runtime, View, Path], Frame],
) -> Frame:
    """Render `plan` to pictures by `write`, or into one video; progress on stderr. Returns the last frame."""
    from engine.app.headless import render_image
    from engine.render.view import View

    cameras = _cameras(runtime, args, plan, size[0] / size[1], camera)

    def views() -> Iterator[View]:
        for i, time in enumerate(plan.times):
            runtime.update(time)
            yield View(cameras(i), size[0], size[1], settings)

    frame: Frame | None = None
    if args.out.suffix.lower() in VIDEOS:
        with _Video(args.out, plan.fps, size) as video:
            for done, view in enumerate(views(), 1):
                image, frame = render_image(runtime, view)
                video.add(image[:, :, :3])
                _progress(done, len(plan.times))
    else:
        for done, (number, view) in enumerate(zip(plan.numbers, views(), strict=True), 1):
            frame = write(runtime, view, picture_name(args.out, number))
            _progress(done, len(plan.times))
    assert frame is not None
    return frame


def _range(text: str) -> tuple[int, int]:
    first, separator, end = text.partition(":")
    try:
        a, b = int(first or "0"), int(end)
    except ValueError:
        a, b = 0, 0
    if not separator or not 0 <= a < b:
        raise UsageError(f"--frames {text!r} is no range", hint="write A:B with 0 <= A < B, as 0:48, or 'all'")
    return a, b


def _cameras(
    runtime: Runtime, args: argparse.Namespace, plan: Sequence, aspect: float, camera: Callable[[float], Camera]
) -> Callable[[int], Camera]:
    """The camera of each picture: the chosen one, or one that stands still and sees everything at all times."""
    from engine.app.framing import AZIMUTH, ELEVATION, frame_points, scene_points

    node = runtime.asset.active_camera
    has_own = 0 <= node < len(runtime.asset.nodes) and runtime.asset.nodes[node].camera is not None
    explicit = args.camera not in ("", "auto") or bool(args.eye)
    chosen = explicit or (has_own and not args.orbit and not args.camera)
    if plan.turns is None and chosen:
        return lambda _: camera(aspect)  # it may be animated itself
    if plan.turns is None and args.orbit:
        camera(aspect)  # complains about a bad --orbit
    azimuth, elevation = _orbit(args.orbit) if args.orbit else (AZIMUTH, ELEVATION)
    looks = sorted({plan.times[round(i * (len(plan.times) - 1) / _LOOKS)] for i in range(_LOOKS + 1)})
    parts = []
    for time in looks:
        runtime.update(time)
        points = scene_points(runtime.scene, runtime.residency)
        parts.append(points[:: max(1, len(points) // 20_000)])
        if len(points):
            parts.append(np.stack([points.min(axis=0), points.max(axis=0)]))
    points = np.concatenate(parts)
    if plan.turns is None:
        still = frame_points(points, aspect, azimuth=azimuth, elevation=elevation)
        return lambda _: still
    turns, around = plan.turns, _solid_of_revolution(points)
    return lambda i: frame_points(around, aspect, azimuth=azimuth + turns[i], elevation=elevation)


def _solid_of_revolution(points: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """The circles that the points run through about the vertical axis of their box: the same from every side."""
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        return points
    center = (points.min(axis=0) + points.max(axis=0)) / 2
    away = np.hypot(points[:, 0] - center[0], points[:, 2] - center[2])
    height = points[:, 1]
    # the outline is enough: the farthest point in each of 64 slices
    low, high = float(height.min()), float(height.max())
    slot = np.minimum(((height - low) / max(high - low, 1e-12) * 64).astype(int), 63)
    farthest = [int(np.flatnonzero(slot == s)[np.argmax(away[slot == s])]) for s in np.unique(slot)]
    angle = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    rings = [
        np.stack([center[0] + away[i] * np.sin(angle), np.full(64, height[i]), center[2] + away[i] * np.cos(angle)], 1)
        for i in (*farthest, int(np.argmin(height)), int(np.argmax(height)))
    ]
    return np.concatenate(rings)


def _orbit(text: str) -> tuple[float, float]:
    try:
        azimuth, elevation = (float(v) for v in text.split(","))
    except ValueError as error:
        raise UsageError(f"--orbit {text!r}: expected AZIMUTH,ELEVATION in degrees") from error
    return azimuth, elevation


def _progress(done: int, count: int) -> None:
    if sys.stderr.isatty():
        print(f"\r{done}/{count}", end="\n" if done == count else "", file=sys.stderr, flush=True)


class _Video:
    """An .mp4 or .webm that appears when it is whole. Raises UsageError where the encoder is not installed."""

    def __init__(self, path: Path, fps: float, size: tuple[int, int]) -> None:
        try:
            import imageio_ffmpeg
        except ImportError as error:
            raise UsageError("videos need imageio-ffmpeg", hint="pip install lucarna[video], or write .png") from error
        if size[0] % 2 or size[1] % 2:
            raise UsageError(f"a video of {size[0]}x{size[1]}", hint="width and height must be even")
        self._ffmpeg, self._path, self._fps, self._size = imageio_ffmpeg, path, fps, size

    def __enter__(self) -> _Video:
        self._context = atomic_path(self._path)
        self._temporary = self._context.__enter__()
        kind = self._path.suffix.lower()
        self._writer = self._ffmpeg.write_frames(
            str(self._temporary), self._size, fps=self._fps, codec=VIDEOS[kind], macro_block_size=2, quality=8,
            ffmpeg_log_level="error", output_params=["-f", kind[1:]],
        )  # fmt: skip
        self._writer.send(None)
        return self

    def add(self, image: np.ndarray[Any, Any]) -> None:
        try:
            self._writer.send(np.ascontiguousarray(image))
        except OSError as error:
            raise OutputError(f"the video encoder gave up: {error}", where=self._path) from error

    def __exit__(self, *error: Any) -> None:
        self._writer.close()
        self._context.__exit__(*error)
