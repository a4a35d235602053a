"""`lucarna render` of many pictures: a range of frames, or a turn about the scene; as numbered pictures or a video."""

from __future__ import annotations

import argparse
import contextlib
import math
import re
import subprocess
import sys
import tempfile
import time
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
        "--animation", type=Path, metavar="FILE", help="let this *.animation.toml pose the scene, instead of clips"
    )
    parser.add_argument("--drive", choices=("timeline", "states"), default="", help="which part of the animation")
    parser.add_argument(
        "--param", action="append", default=[], metavar="NAME=VALUE", help="set a parameter of the animation's states"
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


def play_animation(runtime: Runtime, args: argparse.Namespace) -> None:
    """Play --animation with its --param. Raises InputError, UsageError."""
    if args.animation is not None:
        runtime.animate(args.animation, args.drive)
    elif args.drive:
        runtime.set_drive(args.drive)
    for item in args.param:
        name, separator, value = item.partition("=")
        try:
            number = float({"true": "1", "false": "0"}.get(value.strip().lower(), value))
        except ValueError:
            separator = ""
        if not separator:
            raise UsageError(f"--param {item!r}: expected NAME=VALUE with a number, true or false")
        animator = runtime.deck.animator
        if animator is None:
            raise UsageError("--param needs an animation whose states drive", hint="--animation FILE --drive states")
        animator.set(name.strip(), number)


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
        for i, at in enumerate(plan.times):
            runtime.update(at)
            yield View(cameras(i), size[0], size[1], settings)

    frame: Frame | None = None
    progress = Progress(len(plan.times))
    if args.out.suffix.lower() in VIDEOS:
        with Video(args.out, plan.fps, size) as video:
            for view in views():
                image, frame = render_image(runtime, view)
                video.add(image[:, :, :3])
                progress.step()
    else:
        try:
            for number, view in zip(plan.numbers, views(), strict=True):
                frame = write(runtime, view, picture_name(args.out, number))
                progress.step()
        except KeyboardInterrupt:
            progress.stopped("pictures were written and are whole")
            raise
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
    for at in looks:
        runtime.update(at)
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


class Progress:
    """How many of `count` pictures are done, on stderr: one line that is written over on a terminal, elsewhere a line
    each tenth of the way. With the time that is left once some are done."""

    def __init__(self, count: int) -> None:
        self.count, self.done = count, 0
        self._start = time.monotonic()
        self._told = 0
        self._terminal = sys.stderr.isatty()

    def step(self) -> None:
        self.done += 1
        tenths = 10 * self.done // self.count
        if self._terminal:
            end = "\n" if self.done == self.count else ""
            print(f"\r\033[K{self._line()}", end=end, file=sys.stderr, flush=True)
        elif tenths > self._told and self.count > 1:
            self._told = tenths
            print(self._line(), file=sys.stderr, flush=True)

    def stopped(self, what: str) -> None:
        print(f"{chr(10) if self._terminal else ''}{self.done} of {self.count} {what}", file=sys.stderr, flush=True)

    def _line(self) -> str:
        spent = time.monotonic() - self._start
        left = spent / self.done * (self.count - self.done)
        rest = f"  {math.ceil(left)} s left" if left else ""
        return f"{self.done}/{self.count}  {100 * self.done // self.count} %{rest}"


class Video:
    """An .mp4 or .webm that appears when it is whole. Raises UsageError where the encoder is not installed."""

    def __init__(self, path: Path, fps: float, size: tuple[int, int]) -> None:
        try:
            from imageio_ffmpeg import get_ffmpeg_exe
        except ImportError as error:
            raise UsageError("videos need imageio-ffmpeg", hint="pip install lucarna[video], or write .png") from error
        if size[0] % 2 or size[1] % 2:
            raise UsageError(f"a video of {size[0]}x{size[1]}", hint="width and height must be even")
        try:
            program = str(get_ffmpeg_exe())
        except RuntimeError as error:
            raise UsageError("imageio-ffmpeg has no encoder for this system", hint="write .png instead") from error
        self._path = path
        kind = path.suffix.lower()
        self._command = [
            program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}",
            "-r", f"{fps:g}", "-i", "-", "-an", "-c:v", VIDEOS[kind], "-pix_fmt", "yuv420p", "-crf", "20", "-b:v", "0",
            "-f", kind[1:],
        ]  # fmt: skip

    def __enter__(self) -> Video:
        self._stack = contextlib.ExitStack()
        temporary = self._stack.enter_context(atomic_path(self._path))
        self._errors = self._stack.enter_context(tempfile.TemporaryFile())
        self._process = subprocess.Popen(
            [*self._command, str(temporary)], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=self._errors
        )
        return self

    def add(self, image: np.ndarray[Any, Any]) -> None:
        """One more frame, u1[h,w,3]."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(np.ascontiguousarray(image).tobytes())
        except OSError as error:
            raise self._failed() from error

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: Any) -> None:
        with self._stack:
            # whatever ends the frames early ends the encoder too, and the unfinished file goes
            if error is not None:
                self._process.kill()
            with contextlib.suppress(OSError):
                self._process.communicate()
            if error is not None:
                raise error
            if self._process.returncode != 0:
                raise self._failed()

    def _failed(self) -> OutputError:
        self._errors.seek(0)
        words = self._errors.read().decode(errors="replace").strip().splitlines()
        return OutputError(f"the video encoder gave up: {words[-1] if words else 'no reason given'}", where=self._path)
