"""Sheets of pictures by render path, to be looked at.

python -m tests.tools.path_sheet --out FOLDER --size 320x180 --lights 1024

    atrium.png, poles.png   each path, what differs from forward (amplified: black is right), lights per tile
    glass.png               each path, a reference blended by hand from back to front, what differs (amplified)
    samples.png             Forward+ with 1, 2, 4 and 8 samples a pixel, a part enlarged
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from engine.app.headless import with_legend
from engine.assets.primitives import card, cube
from engine.assets.samples import SAMPLES
from engine.assets.scene import LightAsset
from engine.core.errors import LucarnaError
from engine.gpu import open_device
from engine.gpu.types import Device
from engine.math.color import linear_to_srgb
from engine.render.camera import Camera
from engine.render.lighting import PATHS
from engine.render.renderer import Renderer
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.image import save_png
from engine.resources.residency import Residency
from engine.resources.samples import sample_scene
from importers.cli.render import parse_size
from tests.support.stage import Stage, front_camera, surface

F4 = NDArray[np.float32]
U1 = NDArray[np.uint8]
OTHERS = PATHS[1:]
#: what differences are multiplied by: half an ulp of a half float at 1 would be 50/255
AMPLIFIED = 400.0
TITLE = 14
PANES = [((1.0, 0.2, 0.2, 0.4), -0.2), ((0.2, 1.0, 0.2, 0.6), 0.1), ((0.3, 0.3, 1.0, 0.3), 0.4)]


def sheet(rows: Sequence[Sequence[tuple[str, U1]]]) -> U1:
    """Pictures of one size in rows, each under its title."""
    height, width = rows[0][0][1].shape[:2]
    across, down = max(len(row) for row in rows) * (width + 4), len(rows) * (height + TITLE + 4)
    page = Image.new("RGB", (across, down), (40, 40, 40))
    draw = ImageDraw.Draw(page)
    for j, row in enumerate(rows):
        for i, (title, picture) in enumerate(row):
            x, y = i * (width + 4) + 2, j * (height + TITLE + 4) + 2
            draw.text((x + 2, y), title, fill=(230, 230, 230))
            page.paste(Image.fromarray(np.ascontiguousarray(picture[..., :3])), (x, y + TITLE))
    return np.asarray(page, np.uint8)


def difference(a: F4, b: F4) -> tuple[str, U1]:
    """Where light is brighter than 1, as a part of it: so are the steps of half floats."""
    apart = np.abs(a[..., :3].astype(np.float64) - b[..., :3]) / np.maximum(np.abs(b[..., :3]), 1.0)
    return f"difference x {AMPLIFIED:g}, most {apart.max():.2g}", _bytes(apart * AMPLIFIED)


def _bytes(linear: NDArray[Any]) -> U1:
    return np.asarray(np.rint(np.clip(linear, 0.0, 1.0) * 255.0), np.uint8)


def _shown(linear: NDArray[Any]) -> U1:
    return _bytes(linear_to_srgb(np.clip(linear[..., :3], 0.0, 1.0)))


def paths_sheet(device: Device, sample: str, lights: int, size: tuple[int, int]) -> U1:
    residency = Residency(device)
    scene = sample_scene(importlib.import_module(SAMPLES[sample][0]).build(lights), residency)
    renderer = Renderer(device, residency, profile=False)
    camera = Camera.from_asset(scene.cameras.asset(0), scene.nodes.world_matrix(int(scene.cameras.node[0])))

    def take(**settings: Any) -> tuple[U1, F4]:
        frame = renderer.render(scene, View(camera, *size, RenderSettings(samples=1, **settings)), hdr=True)
        assert frame.hdr is not None, "asked for"
        return with_legend(np.array(frame.color.read()), frame)[..., :3], np.array(frame.hdr.read(), np.float32)

    try:
        truth = take(path="forward")
        found = {path: take(path=path) for path in OTHERS}
        return sheet([
            [("forward, every light in every pixel", truth[0]), *((path, found[path][0]) for path in OTHERS)],
            [("lights per tile", take(path="forward-plus", view="light_tiles")[0]),
             *(difference(found[path][1], truth[1]) for path in OTHERS)],
            [(f"lights per tile, {way}", take(path="forward-plus", view="light_tiles", **how)[0]) for way, how in WAYS],
        ])  # fmt: skip
    finally:
        renderer.release()
        residency.effects.release()
        residency.release()


#: of culling, beside the default
WAYS: tuple[tuple[str, dict[str, str]], ...] = (
    ("tiles of 16", {"light_tile": "16"}), ("tiles of 32", {"light_tile": "32"}),
    ("planes and range", {"light_test": "planes", "light_depth": "range"}), ("clusters", {"light_depth": "clusters"}),
)  # fmt: skip


def glass_scene(stage: Stage, solid: bool, panes: Sequence[int]) -> None:
    stage.dark()
    if solid:
        dull = surface(metallic=0.0, roughness=0.7, base_color=(0.8, 0.7, 0.5, 1))
        stage.add(cube(1.2), dull, (0, 0, -1.5), rotation=(0.2, 0.3, 0.1, 0.92))
    for i in panes:
        color, z = PANES[i]
        lean = 0.1 * (i + 1)
        glass = surface("transparent", base_color=color, metallic=0.0)
        stage.add(card(0.9), glass, (0.2 * i - 0.2, 0.15 * i - 0.1, z), rotation=(0, 0, lean, (1.0 - lean**2) ** 0.5))
    rng = np.random.default_rng(3)
    for _ in range(10):
        r, g, b = rng.uniform(0.4, 1.0, 3).tolist()
        stage.lamp(LightAsset("point", (r, g, b), 0.5, 4.0), rng.uniform((-1.0, -1.0, 0.8), (1.0, 1.0, 1.8)))


def sorted_by_hand(picture: Callable[[bool, Sequence[int]], F4]) -> NDArray[np.float64]:
    """Each pane alone over black, blended from back to front over what is solid, in float64."""
    want = picture(True, ()).astype(np.float64)[..., :3]
    for i, (color, _) in enumerate(PANES):
        alone = picture(False, (i,)).astype(np.float64)[..., :3]
        covered = (alone.sum(axis=-1) > 0.0)[..., None]
        want = np.where(covered, alone + (1.0 - color[3]) * want, want)
    return want


def glass_sheet(device: Device, size: tuple[int, int]) -> U1:
    stage = Stage(device)
    camera = front_camera(0.5, size[0] / size[1])
    try:
        rows: list[list[tuple[str, U1]]] = [[], [], []]
        for path in PATHS:

            def picture(solid: bool, panes: Sequence[int], path: str = path) -> F4:
                glass_scene(stage, solid, panes)
                return stage.hdr(size, camera, path=path).copy()

            want, got = sorted_by_hand(picture), picture(True, (2, 0, 1))
            rows[0].append((path, _shown(got)))
            rows[1].append(("sorted by hand", _shown(want)))
            rows[2].append(difference(got, want.astype(np.float32)))
        return sheet(rows)
    finally:
        stage.close()


def samples_sheet(device: Device, size: tuple[int, int], enlarged: int = 4) -> U1:
    stage = Stage(device)
    camera = front_camera(0.5, size[0] / size[1])
    try:
        rows: list[list[tuple[str, U1]]] = [[], []]
        for samples in (1, 2, 4, 8):
            for j, path in enumerate(("forward", "forward-plus")):
                glass_scene(stage, True, (0, 1, 2))
                picture = stage.hdr(size, camera, path=path, samples=samples)
                h, w = size[1] // enlarged, size[0] // enlarged
                part = _shown(picture)[size[1] // 4 : size[1] // 4 + h, size[0] // 4 : size[0] // 4 + w]
                taken = device.caps.samples_for(samples)
                title = f"{path}, {samples} samples" + (f" (the device takes {taken})" if taken != samples else "")
                rows[j].append((title, part.repeat(enlarged, axis=0).repeat(enlarged, axis=1)))
        return sheet(rows)
    finally:
        stage.close()


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="tests.tools.path_sheet", description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--lights", type=int, default=1024)
    args = parser.parse_args(arguments)
    size = parse_size(args.size)
    try:
        device = open_device("gl")
        args.out.mkdir(parents=True, exist_ok=True)
        for name in SAMPLES:
            save_png(args.out / f"{name}.png", paths_sheet(device, name, args.lights, size))
        save_png(args.out / "glass.png", glass_sheet(device, (240, 180)))
        save_png(args.out / "samples.png", samples_sheet(device, (240, 180)))
        device.release()
    except LucarnaError as error:
        print(f"path_sheet: error: {error}", file=sys.stderr)
        return error.exit_code
    print(f"{args.out}: {', '.join((*SAMPLES, 'glass', 'samples'))}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
