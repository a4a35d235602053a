"""A film strip: one row of pictures of an animated scene over time, with the time under each.

python -m tests.tools.film_strip SCENE --animation FILE.animation.toml --out strip.png --count 8 --size 160x200
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from engine.app.framing import frame_points, scene_points
from engine.app.headless import render_image
from engine.app.runtime import Runtime
from engine.core.errors import LucarnaError
from engine.gpu import open_device
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.image import save_png
from importers.cli.render import parse_size
from importers.opening import open_path
from importers.settings import ImportSettings


def strip(runtime: Runtime, times: list[float], size: tuple[int, int], orbit: tuple[float, float]) -> np.ndarray:
    """u1[h, w * times, 3]: the scene at `times`, from one camera that sees all of them."""
    points = []
    for time in times:
        runtime.seek(time)
        points.append(scene_points(runtime.scene, runtime.residency))
    camera = frame_points(np.concatenate(points), size[0] / size[1], azimuth=orbit[0], elevation=orbit[1])
    pictures = []
    for time in times:
        runtime.seek(time)
        image, _ = render_image(runtime, View(camera, *size, RenderSettings(samples=4)))
        pictures.append(image[..., :3])
    return np.concatenate(pictures, axis=1)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="tests.tools.film_strip", description=__doc__)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--animation", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--count", type=int, default=8)
    parser.add_argument("--size", default="160x200")
    parser.add_argument("--orbit", default="35,12")
    args = parser.parse_args(arguments)
    runtime = Runtime(open_device("gl"), profile=False)
    try:
        open_path(runtime, args.scene, settings=ImportSettings(quality="draft"))
        if args.animation is not None:
            runtime.animate(args.animation)
        times = np.linspace(0.0, runtime.duration, args.count).tolist()
        azimuth, elevation = (float(v) for v in args.orbit.split(","))
        save_png(args.out, strip(runtime, times, parse_size(args.size), (azimuth, elevation)))
        print(f"{args.out}: {', '.join(f'{t:.2f}' for t in times)} s")
    except LucarnaError as error:
        print(f"film_strip: error: {error}", file=sys.stderr)
        return error.exit_code
    finally:
        runtime.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
