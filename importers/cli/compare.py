"""`lucarna compare`: how two pictures differ, or a scene rendered in two ways: the numbers of the editor's panel.

lucarna compare before.png after.png --out where.png
lucarna compare helmet.glb --a path=forward --b path=deferred --size 640x360
"""

from __future__ import annotations

import argparse
import statistics
import sys
from pathlib import Path
from typing import Any

from engine.core.errors import UsageError
from importers.cli.output import print_json
from importers.cli.render import add_arguments as render_arguments

#: pictures of each before times count, and those that do
WARM_UP, TIMED = 2, 5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("a", type=Path, help="a picture (.png); or a scene or a model, with --a and --b")
    parser.add_argument("b", type=Path, nargs="?", help="the other picture")
    parser.add_argument("--a", dest="set_a", action="append", default=[], metavar="NAME=VALUE",
                        help="render setting of the first picture of a scene (again for more)")  # fmt: skip
    parser.add_argument("--b", dest="set_b", action="append", default=[], metavar="NAME=VALUE",
                        help="render setting of the second")  # fmt: skip
    parser.add_argument("--set", dest="both", action="append", default=[], metavar="NAME=VALUE", help="of both")
    parser.add_argument("--size", default="1280x720", help="of a scene's pictures (default 1280x720)")
    parser.add_argument("--time", type=float, default=0.0, help="seconds into the scene's animation")
    parser.add_argument("--camera", default="", help="as of `lucarna render`")
    parser.add_argument("--orbit", default="", help="as of `lucarna render`")
    parser.add_argument(
        "--out", type=Path, metavar="PNG", help="write where they differ: black nothing, yellow 8 levels"
    )
    parser.add_argument("--no-flip", action="store_true", help="without FLIP, which takes the longest")
    parser.add_argument("--max-flip", type=float, metavar="X", help="exit 1 where mean FLIP is larger")
    parser.add_argument("--max-difference", type=int, metavar="N", help="exit 1 where a pixel differs by more levels")
    parser.add_argument("--json", action="store_true", help="the numbers as JSON on stdout")


def run(args: argparse.Namespace) -> int:
    """Returns 1 where a limit was given and is passed. Raises UsageError, InputError, FormatError, OutputError."""
    if args.no_flip and args.max_flip is not None:
        raise UsageError("--max-flip needs FLIP", hint="leave out --no-flip")
    scene = args.b is None
    if not scene and (args.set_a or args.set_b or args.both):
        raise UsageError("--a, --b and --set are for a scene", hint="give one scene, or two pictures without them")
    if scene and not (args.set_a or args.set_b):
        raise UsageError("one thing to compare", hint="give two pictures, or a scene with --a or --b NAME=VALUE")
    from engine.report.image import load_png, save_png
    from engine.report.picture_difference import difference_map, picture_difference

    times: list[float] = []
    if scene:
        (a, b), times = _render_both(args)
    else:
        a, b = load_png(args.a), load_png(args.b)
    found = picture_difference(a, b, perceptual=not args.no_flip)
    if args.out is not None:
        save_png(args.out, difference_map(a, b))
    over = [
        text
        for limit, value, text in (
            (args.max_flip, found.flip, f"FLIP is more than {args.max_flip}"),
            (args.max_difference, found.largest, f"a pixel differs by more than {args.max_difference}"),
        )
        if limit is not None and value is not None and value > limit
    ]
    data: dict[str, Any] = {**found.to_json(), "over": over}
    if times:
        data["ms"] = times
    if args.json:
        print_json(data)
    else:
        print(found.line() + (f"   {times[0]:.2f} -> {times[1]:.2f} ms" if times else ""))
        if not found.equal:
            print(f"largest at {found.worst[0]}, {found.worst[1]} of {found.width}x{found.height}")
        for text in over:
            print(text)
    return 1 if over else 0


def _render_both(args: argparse.Namespace) -> tuple[list[Any], list[float]]:
    """Both pictures u1[h,w,4] of the scene, and the median milliseconds of each, rendered in turn after a warm-up."""
    from engine.app.headless import render_image
    from engine.app.runtime import Runtime
    from engine.gpu import open_device
    from engine.render.view import View
    from importers.cli.render import parse_size, render_settings, scene_camera
    from importers.opening import open_path
    from importers.settings import ImportSettings

    parser = argparse.ArgumentParser()
    render_arguments(parser)
    common = [str(args.a), "--out=none.png", f"--camera={args.camera}", f"--orbit={args.orbit}"]
    given = [
        parser.parse_args([*common, *(f"--set={item}" for item in (*args.both, *extra))])
        for extra in (args.set_a, args.set_b)
    ]
    settings = [render_settings(words) for words in given]
    width, height = parse_size(args.size)
    runtime = Runtime(open_device("gl"), pixels=width * height)
    try:
        for finding in open_path(runtime, args.a, settings=ImportSettings()):
            print(finding, file=sys.stderr)
        runtime.update(args.time)
        camera = scene_camera(runtime, given[0], width / height)
        views = [View(camera, width, height, s) for s in settings]
        times: list[list[float]] = [[], []]
        for number in range(WARM_UP + TIMED):
            for view, kept in zip(views, times, strict=True):
                frame = runtime.render(view)
                if number >= WARM_UP:
                    kept.append(float(frame.stats.total_ms))
        return [render_image(runtime, view)[0] for view in views], [statistics.median(kept) for kept in times]
    finally:
        runtime.close()
