"""A film strip of shadows: the camera goes by; the sun goes over; a lamp goes over. Nothing may crawl or jump.

python -m tests.tools.shadow_strip [--scene NAME] --out strip.png [--count 8] [--size 200x140] [--set shadow_filter=msm]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from engine.assets.scene import LightAsset
from engine.core.errors import LucarnaError
from engine.experiments.harness.samples import SAMPLES, build
from engine.experiments.harness.scenes import MadeScene
from engine.gpu import open_device
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.image import save_png
from importers.cli.render import parse_size


def picture(
    scene: MadeScene, size: tuple[int, int], aside: float, elevation: float, chosen: dict[str, str],
    lamp: float | None = None,
) -> np.ndarray:  # fmt: skip
    """u1[h,w,3]: with the camera `aside` metres to its right and the sun that high (radians), or a lamp 3 m high and
    `lamp` metres to the right of the scene's middle in its place."""
    camera = scene.camera(size[0] / size[1])
    pose = camera.world_from_camera.copy()
    pose[:3, 3] += aside * pose[:3, 0]
    camera.world_from_camera = pose
    lights, sun = scene.scene.lights, scene.scene.environment.sun_illuminance
    if lamp is not None:
        scene.scene.environment.sun_illuminance = 0.0
        if len(lights.shining()) == 0:
            scene.lamp(LightAsset("point", intensity=12.0))
        node = int(lights.node[lights.shining()[0]])
        scene.scene.nodes.set_translation([node], [[lamp, 3.0, 0.6]])
        scene.scene.update()
    scene.scene.environment.sun_elevation = elevation
    settings = RenderSettings(samples=4, local_shadows="all")
    for name, text in chosen.items():
        setattr(settings, name, text)
    frame = scene.render(View(camera, *size, settings))
    camera.world_from_camera[:3, 3] -= aside * pose[:3, 0]
    scene.scene.environment.sun_illuminance = sun
    return np.asarray(frame.color.read())[..., :3].copy()


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="tests.tools.shadow_strip", description=__doc__)
    parser.add_argument("--scene", choices=sorted(SAMPLES), default="blocks")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--count", type=int, default=8)
    parser.add_argument("--size", default="200x140")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", dest="chosen")
    args = parser.parse_args(arguments)
    scene = build(args.scene, open_device("gl"))
    try:
        size = parse_size(args.size)
        chosen = dict(item.split("=", 1) for item in args.chosen)
        high = scene.scene.environment.sun_elevation
        steps = np.linspace(0.0, 1.0, args.count)
        above = [picture(scene, size, 1.2 * float(t) - 0.6, high, chosen) for t in steps]
        below = [picture(scene, size, 0.0, 0.15 + 2.6 * float(t), chosen) for t in steps]
        lamp = [picture(scene, size, 0.0, high, chosen, 3.0 * float(t) - 1.5) for t in steps]
        save_png(args.out, np.concatenate([np.concatenate(row, axis=1) for row in (above, below, lamp)]))
        print(args.out)
    except LucarnaError as error:
        print(f"shadow_strip: error: {error}", file=sys.stderr)
        return error.exit_code
    finally:
        scene.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
