"""`lucarna render`: a scene or a source file becomes a picture, without a window."""

from __future__ import annotations

import argparse
import json
import sys
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.core.errors import UsageError
from importers.cli.object_settings import PREFIX, set_objects
from importers.cli.render_camera import add_camera_arguments, free_camera
from importers.cli.render_quality import (
    add_quality_arguments,
    auto_quality,
    check_quality,
    print_idle,
    with_quality,
    with_samples,
)
from importers.cli.render_sequence import (
    add_sequence_arguments,
    check_arguments,
    play_animation,
    play_clips,
    sequence,
    write_sequence,
)

if TYPE_CHECKING:
    from engine.app.runtime import Runtime
    from engine.render.camera import Camera
    from engine.render.frame import Frame
    from engine.render.settings import RenderSettings

SUMMARY = "render a scene or a model to .png or .exr, headless"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", type=Path, help="*.scene.json, a project folder, or a source file (.glb, .gltf, …)")
    parser.add_argument(
        "--out", type=Path, required=True, help="picture to write: .png (display), .exr (linear HDR); .mp4, .webm"
    )
    parser.add_argument("--size", default="1280x720", help="WIDTHxHEIGHT in pixels (default 1280x720)")
    parser.add_argument("--time", type=float, default=0.0, help="seconds into the animation")
    add_sequence_arguments(parser)
    parser.add_argument("--camera", default="", help="name of the scene's camera to use; 'auto' frames everything")
    parser.add_argument("--orbit", default="", help="AZIMUTH,ELEVATION in degrees of a camera that frames everything")
    add_camera_arguments(parser)
    parser.add_argument("--exposure", type=float, help="EV, added to the scene's")
    parser.add_argument("--tone-map", dest="tone_map", help="agx | aces | neutral | none (default: the scene's)")
    parser.add_argument(
        "--environment", help="studio | sky | uniform | none | an .hdr or .exr file, instead of the scene's"
    )
    parser.add_argument(
        "--view", help="debug view: base_color, normal, roughness, metallic, emission, lighting, depth, overdraw, …"
    )
    parser.add_argument("--no-legend", action="store_true", help="of a debug view in numbers: without what they mean")
    parser.add_argument(
        "--path", choices=("auto", "forward", "deferred", "tiled-deferred", "forward-plus"),
        help="how local lights reach surfaces, all with one picture (default auto: the cheapest; --explain says why)",
    )  # fmt: skip
    add_quality_arguments(parser)
    parser.add_argument(
        "--set", dest="settings", action="append", default=[], metavar="NAME=VALUE",
        help="set any render setting, or objects.NODE.PARAMETER: of a material, on the objects of that name alone",
    )  # fmt: skip
    parser.add_argument("--force-all", action="store_true", help="leave nothing out (the picture must be the same)")
    parser.add_argument(
        "--check-numbers", action="store_true", help="say which pass made the first NaN or infinity, and where; exit 1"
    )
    parser.add_argument("--explain", action="store_true", help="say which passes and branches were left out, and why")
    parser.add_argument("--stats", type=Path, metavar="FILE.json", help="write per-pass times and counters")
    parser.add_argument("--preset", default="normal", help="texture quality where a source has to be converted")


def run(args: argparse.Namespace) -> int:
    width, height = parse_size(args.size)
    check_arguments(args)
    start = time.perf_counter()
    check_quality(args)
    named = named_settings(args)
    settings = with_quality(args, render_settings(args), named)

    from engine.app.runtime import Runtime
    from engine.gpu import open_device
    from engine.render.view import View
    from importers.opening import open_path
    from importers.settings import ImportSettings

    device = open_device("gl")
    runtime = Runtime(device, profile=args.stats is not None, pixels=width * height)
    try:
        findings = open_path(runtime, args.scene, settings=ImportSettings(quality=args.preset))
        _apply_environment(runtime, args.environment)
        set_objects(runtime, args.settings)
        play_clips(runtime, args.clip)
        play_animation(runtime, args)
        runtime.update(args.time)
        opened = time.perf_counter()
        plan = sequence(args, runtime.duration)
        write = partial(_write, legend=not args.no_legend)
        view = View(scene_camera(runtime, args, width / height), width, height, settings)
        view.settings = settings = auto_quality(args, runtime, view, named)
        print_idle(settings)
        if plan is None:
            frame = write(runtime, view, args.out)
        else:
            frame = write_sequence(
                runtime, args, plan, settings, (width, height), partial(scene_camera, runtime, args), write
            )
        renderer = runtime.renderer
        noted = (*findings, *renderer.environments.findings, *renderer.skin_findings, *renderer.light_findings)
        for finding in dict.fromkeys(noted):
            print(finding, file=sys.stderr)
        for variant, error in runtime.renderer.programs.errors.items():
            print(f"error: {variant}: {error} (drawn in magenta)", file=sys.stderr)
        if args.explain:
            _explain(runtime, frame)
        elif args.path and frame.path.path not in (args.path, "forward", "auto") and args.path != "auto":
            print(f"path {frame.path.path}: {frame.path.reason}", file=sys.stderr)
        if args.stats is not None:
            _write_stats(args, frame, opened - start, time.perf_counter() - start, runtime.renderer.path.reason)
        print(f"{args.out}: {width}x{height}, {time.perf_counter() - start:.2f} s")
        failed = findings.has_errors or bool(runtime.renderer.programs.errors)
        if args.check_numbers and frame.numbers is not None:
            picture, numbers = runtime.renderer.first_bad or (0, frame.numbers)
            if plan is not None and numbers.first is not None:
                print(f"picture {picture + 1} of {len(plan.times)}:")
            print("\n".join(numbers.lines()))
            failed = failed or numbers.first is not None
    finally:
        runtime.close()
    return 1 if failed else 0


def parse_size(text: str) -> tuple[int, int]:
    """`640x360` -> (640, 360). Raises UsageError."""
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(p.isdigit() and 1 <= int(p) <= 16384 for p in parts):
        raise UsageError(f"--size {text!r} is no size", hint="write WIDTHxHEIGHT with 1 to 16384 pixels, as 1280x720")
    return int(parts[0]), int(parts[1])


def render_settings(args: argparse.Namespace) -> RenderSettings:
    """The settings that the arguments give. Raises UsageError."""
    from engine.render.settings import RenderSettings

    return RenderSettings(**named_settings(args))


def named_settings(args: argparse.Namespace) -> dict[str, Any]:
    """The settings that the arguments name, by name. Raises UsageError."""
    values: dict[str, Any] = {}
    for item in args.settings:
        name, separator, value = item.partition("=")
        if not separator:
            raise UsageError(f"--set {item!r}: expected NAME=VALUE")
        if name.strip().startswith(PREFIX):
            continue  # of the scene, which is not open yet
        values[name.strip()] = value.strip()
    for name in ("exposure", "tone_map", "view", "path"):
        if getattr(args, name) is not None:
            values[name] = getattr(args, name)
    if args.force_all:
        values["force_all"] = True
    if args.check_numbers:
        values["check_numbers"] = True
    return with_samples(values)


def scene_camera(runtime: Runtime, args: argparse.Namespace, aspect: float) -> Camera:
    """The camera that the arguments ask for. Raises UsageError."""
    from engine.render.camera import Camera

    free = free_camera(args)
    if free is not None:
        return free
    if args.orbit:
        try:
            azimuth, elevation = (float(v) for v in args.orbit.split(","))
        except ValueError as error:
            raise UsageError(f"--orbit {args.orbit!r}: expected AZIMUTH,ELEVATION in degrees") from error
        return runtime.framing_camera(aspect, azimuth, elevation)
    if args.camera == "auto":
        return runtime.framing_camera(aspect)
    if args.camera:
        names = {n.name: i for i, n in enumerate(runtime.asset.nodes) if n.camera is not None}
        if args.camera not in names:
            raise UsageError(f"there is no camera {args.camera!r}", hint=f"cameras: {', '.join(names) or 'none'}")
        index = names[args.camera]
        camera = runtime.asset.nodes[index].camera
        assert camera is not None
        return Camera.from_asset(camera, runtime.scene.nodes.world_matrix(int(runtime.node_rows[index])))
    return runtime.default_camera(aspect)


def _apply_environment(runtime: Runtime, choice: str | None) -> None:
    if choice is None:
        return
    environment = runtime.scene.environment
    if choice in ("studio", "sky", "uniform", "none"):
        environment.kind = choice
        return
    path = Path(choice).resolve()
    if not path.is_file():
        raise UsageError(
            f"--environment {choice!r}: no such file", hint="studio, sky, uniform, none, or an .hdr or .exr file"
        )
    environment.kind, environment.path, environment.sun_illuminance = "image", str(path), 0.0


def _write(runtime: Runtime, view: Any, out: Path, *, legend: bool = True) -> Frame:
    from engine.app.headless import render_hdr, render_image, with_legend
    from engine.report.image import save_exr, save_png

    if out.suffix.lower() == ".exr":
        hdr, frame = render_hdr(runtime, view)
        save_exr(out, hdr[:, :, :3])
        return frame
    image, frame = render_image(runtime, view)
    if legend:
        image = with_legend(image, frame)
    look = {f"lucarna.{name}": str(value) for name, value in view.settings.values().items()}
    save_png(out, image[:, :, :3], look)
    return frame


def _explain(runtime: Runtime, frame: Frame) -> None:
    from engine.framegraph.explain import explain
    from engine.materials.explain import level_lines, role_lines

    for line in explain(frame.graph, runtime.residency.effects.variants()):
        print(line)
    library = runtime.residency.effects
    used = {record.effect.name: record.effect for record in runtime.residency.materials.records}
    for line in (*level_lines(library.variants()), *role_lines(used.values())):
        print(line)
    choice = runtime.renderer.path
    print(f"path {choice.path}: {choice.reason}")
    for macro, value in frame.facts.variant_defines().items():
        if not value and macro != "DEBUG_VIEW":
            print(f"branch {macro}: left out of every surface shader, the scene has none of it")
    if runtime.deck.playing:
        print(f"animations: {_asleep(runtime)}")


def _asleep(runtime: Runtime) -> str:
    """How many animations were not sampled, and why, or why none."""
    playing, asleep = runtime.deck.playing, runtime.deck.asleep
    if not runtime.sleepy:
        return f"all {playing} sampled, seen or not: only windows leave out what nobody sees"
    return f"{asleep} of {playing} asleep: nothing that they move was in the last picture"


def _write_stats(args: argparse.Namespace, frame: Frame, open_s: float, total_s: float, reason: str) -> None:
    from engine.core.atomic import write_text

    data = frame.stats.to_json()
    data["seconds"] = {"open": round(open_s, 4), "total": round(total_s, 4)}
    data["path"] = {"name": frame.facts.lighting.path, "reason": reason}
    data["left_out"] = [
        {"pass": item.name, "reason": item.reason, "bytes": item.saved} for item in frame.graph.left_out
    ]
    if frame.numbers is not None:
        data["numbers"] = frame.numbers.to_json()
    write_text(args.stats, json.dumps(data, indent=2, sort_keys=True) + "\n")
