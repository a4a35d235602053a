"""Many lights: the time of each render path and each way of culling against the number of lights, in two scenes.

The truth is the forward path, in which every pixel adds every light: all others must give its picture to the bit. Up
to 1,024 lights the samples' own; beyond, each light reaches less far, so that a pixel goes on needing about as many and
the slope is that of the method and not of the scene's brightness.

After a full run the costs are fitted and kept for this device: `--path auto` chooses by them.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.samples import SAMPLES
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.gpu.types import Device
from engine.render.camera import Camera
from engine.render.gbuffer import bytes_per_pixel
from engine.render.lighting import PATHS
from engine.render.paths.cost import fit, save
from engine.render.renderer import Renderer
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.crossover import crossover
from engine.report.metrics import max_error, rmse
from engine.report.records import Chart, ChartLine, ChartMark, ChartPoint, Point, Table
from engine.resources.residency import Residency
from engine.resources.samples import sample_scene
from engine.scene.scene import Scene

COUNTS = (1, 8, 32, 64, 100, 128, 256, 512, 1024, 4096, 16384, 65536, 100_000)
QUICK_COUNTS = (8, 256)
#: each pixel adds every light: no more than so many are waited for
MOST_FORWARD = 128
#: the classic path, on a software rasteriser
MOST_VOLUMES = 16384
#: auto chooses by a model of numbers of lights and pixels alone: a choice that costs so much more than the best is held
HELD_WITHIN = 0.10
#: beside the default: tile, test, depth
WAYS = {
    "tiles of 16": {"light_tile": "16"}, "tiles of 32": {"light_tile": "32"},
    "planes only": {"light_test": "planes", "light_depth": "range"}, "boxes": {"light_depth": "range"},
    "cones": {"light_test": "cone"}, "clusters": {"light_depth": "clusters"},
    "clusters of 16": {"light_tile": "16", "light_depth": "clusters"},
}  # fmt: skip
#: of these, the ones that come near the default, by the other path with lists, too
NEAR_WAYS = ("tiles of 16", "clusters", "clusters of 16")
WAYS_AT = 1024
#: pairs whose lines cross: N* is where the second becomes the cheaper one
CROSSING = (("forward", "deferred"), ("deferred", "tiled-deferred"), ("deferred", "forward-plus"))
#: the thesis's form of deferred lighting, an approximation: its error is not 0
THREE_PASS = "deferred, three passes"


@dataclass(slots=True)
class Lit:
    """A sample on the device."""

    residency: Residency
    scene: Scene
    renderer: Renderer
    camera: Camera

    def close(self) -> None:
        self.renderer.release()
        self.residency.effects.release()
        self.residency.release()


def knobs(ctx: Context) -> list[dict[str, Any]]:
    counts = QUICK_COUNTS if ctx.quick else COUNTS
    found: list[dict[str, Any]] = []
    for scene in SAMPLES:
        for count in counts:
            for path in ("auto", *PATHS):
                if (path == "forward" and count > MOST_FORWARD) or (path == "deferred" and count > MOST_VOLUMES):
                    continue
                found.append({"method": path, "scene": scene, "lights": count, "problem": f"{scene} {count}"})
        if not ctx.quick:
            same = {"scene": scene, "lights": WAYS_AT, "problem": f"{scene} {WAYS_AT}"}
            found += [{"method": f"forward-plus, {way}", **same} for way in WAYS]
            found += [{"method": f"tiled-deferred, {way}", **same} for way in NEAR_WAYS]
            found.append({"method": THREE_PASS, **same})
    ctx.omit(f"forward above {MOST_FORWARD} lights, deferred above {MOST_VOLUMES}", "seconds a frame on two cores")
    return found


def size(ctx: Context) -> tuple[int, int]:
    return (160, 90) if ctx.quick else (640, 360)


def lit(ctx: Context, scene: str, lights: int) -> Lit:
    """The sample with a renderer of its own, kept for the run: going from scene to scene would be timed, too."""
    held: dict[tuple[str, int], Lit] = ctx.scratch.setdefault("lit", {})
    key = (scene, lights)
    if key not in held:
        device = _device(ctx)
        build = importlib.import_module(SAMPLES[scene][0]).build
        reach = min(1.0, (1024 / max(lights, 1)) ** (1.0 / 3.0))
        residency = Residency(device)
        made = sample_scene(build(lights, 1, reach), residency)
        cameras = made.cameras
        camera = Camera.from_asset(cameras.asset(0), made.nodes.world_matrix(int(cameras.node[0])))
        held[key] = Lit(residency, made, Renderer(device, residency, profile=False), camera)
        ctx.closing.append(held[key].close)
    return held[key]


def view(ctx: Context, at: Lit, method: str, **more: Any) -> View:
    path, _, way = method.partition(", ")
    form = "three-pass" if method == THREE_PASS else "exact"
    settings = RenderSettings(samples=1, path=path, light_form=form, **WAYS.get(way, {}), **more)
    return View(at.camera, *size(ctx), settings)


def run(ctx: Context, chosen: Knobs) -> Trial:
    at = lit(ctx, chosen["scene"], int(chosen["lights"]))
    device, seen = _device(ctx), view(ctx, at, str(chosen["method"]))

    def work() -> None:
        at.renderer.render(at.scene, seen)
        device.finish()

    return Trial(work, lambda _: _judge(ctx, at, chosen), gpu=True)


def _judge(ctx: Context, at: Lit, chosen: Knobs) -> Outcome:
    method, key = str(chosen["method"]), (chosen["scene"], int(chosen["lights"]))
    truths: dict[Any, NDArray[np.float32]] = ctx.scratch.setdefault("truths", {})
    # where the forward path is too slow to wait for, the deferred one, in which no list can miss a light, stands for it
    if key not in truths:
        truth = "forward" if key[1] <= MOST_FORWARD else "deferred" if key[1] <= MOST_VOLUMES else "tiled-deferred"
        truths[key] = _picture(at, view(ctx, at, truth))
    picture = _picture(at, view(ctx, at, method))
    frame = at.renderer.render(at.scene, view(ctx, at, method, light_stats=True))
    counters = frame.stats.counters
    stats = at.renderer.light_lists.read(wait=True) if frame.facts.lighting.path != "forward" else None
    extra: dict[str, Any] = {"light list bytes": int(counters.get("light_list_bytes", 0))}
    if stats is not None and stats.needed >= 0:
        extra |= {
            "tested per tile": stats.tested / stats.tiles, "kept per tile": stats.kept / stats.tiles,
            "needed per tile": stats.needed / stats.tiles, "lists without room": stats.overflow,
            "needed per pixel": stats.in_pixels / (frame.color.desc.width * frame.color.desc.height),
        }  # fmt: skip
    if frame.facts.lighting.deferred:
        extra["G-buffer bytes per pixel"] = bytes_per_pixel(frame.facts.lighting.gbuffer) + 4
    pictures = []
    if method == "forward-plus" and key[1] in (QUICK_COUNTS[-1], 1024):
        shown = np.asarray(frame.color.read(), np.uint8)[..., :3].copy()
        heat = at.renderer.render(at.scene, view(ctx, at, method, view="light_tiles"))
        tiles = np.asarray(heat.color.read(), np.uint8)[..., :3].copy()
        pictures = beside_truth(ctx, f"{key[0]}, {key[1]} lights", shown, "lights per tile", tiles)
    extra["path"] = frame.facts.lighting.path
    error = {"max_difference": max_error(picture, truths[key]), "rmse": rmse(picture, truths[key])}
    return Outcome(error, extra=extra, pictures=pictures)


def _picture(at: Lit, seen: View) -> NDArray[np.float32]:
    frame = at.renderer.render(at.scene, seen, hdr=True)
    assert frame.hdr is not None, "asked for"
    return np.asarray(frame.hdr.read(), np.float32).copy()


def _device(ctx: Context) -> Device:
    assert ctx.device is not None, "the experiment needs a device"
    return ctx.device


def tables(ctx: Context, points: Sequence[Point]) -> Iterator[Table]:
    """Time against count per path, the slopes and crossovers, and what each way of culling keeps."""
    width, height = size(ctx)
    times = {
        (p.knobs["scene"], p.knobs["method"], int(p.knobs["lights"])): p.ms.median for p in points if p.ms is not None
    }
    counts = sorted({key[2] for key in times})
    by_key = {(p.knobs["scene"], p.knobs["method"], int(p.knobs["lights"])): p.extra for p in points}
    yield _volumes_table(ctx, counts)
    for scene in SAMPLES:
        rows = [[f"{n:,}", *(_ms(times.get((scene, path, n))) for path in ("auto", *PATHS))] for n in counts]
        head, found = ["lights", "auto", *PATHS], _findings(times, scene, counts) + _needs(by_key, scene)
        yield Table(f"{scene}: ms a frame at {width}x{height}", head, rows, found)
        kept = [
            [
                p.knobs["method"], f"{int(p.knobs['lights']):,}", *(f"{p.extra[name]:.2f}" for name in KEPT),
                f"{p.extra['kept per tile'] / max(p.extra['needed per tile'], 1e-9):.2f}",
                _ms(p.ms.median if p.ms is not None else None),
            ]
            for p in points if p.knobs["scene"] == scene and KEPT[0] in p.extra
        ]  # fmt: skip
        yield Table(
            f"{scene}: lights per tile", ["method", "lights", *KEPT, "kept / needed", "ms"], kept,
            "Needed: reaches at least one pixel of the tile with its range and cone.",
        )  # fmt: skip
    if not ctx.quick and ctx.device is not None:
        measured = [(method, n, width * height, ms) for (_, method, n), ms in times.items() if n <= 4096]
        small = _small_times(ctx)
        model = fit([*measured, *small], f"fit of {len(measured) + len(small)} measurements on this device")
        ctx.notes.append(f"The fitted costs are kept in {save(model, ctx.device.caps).name} for --path auto.")


KEPT = ("tested per tile", "kept per tile", "needed per tile", "needed per pixel")


def _volumes_table(ctx: Context, counts: list[int]) -> Table:
    """Of light volumes: the pixels that the depth test alone shades, against those that a stencil would."""
    rows = []
    for scene in SAMPLES:
        n = WAYS_AT if WAYS_AT in counts else counts[-1]
        behind, inside = volume_pixels(lit(ctx, scene, n))
        rows.append([scene, f"{n:,}", f"{behind / n:.0f}", f"{inside / n:.0f}", f"{1.0 - inside / max(behind, 1):.0%}"])
    return Table(
        f"Light volumes at {VOLUME_SIZE[0]}x{VOLUME_SIZE[1]}: pixels shaded by a light",
        ["scene", "lights", "behind the surface (depth test)", "around it (stencil)", "a stencil would save"], rows,
        "What it saves leaves the shader after one depth fetch and one compare, before the light is looked up. It takes"
        " two more draws and a state change a light, where one draw of all lights is made now: no stencil is used.",
    )  # fmt: skip


VOLUME_SIZE = (160, 90)


def volume_pixels(at: Lit) -> tuple[int, int]:
    """Over all lights, the pixels whose surface lies before the far side of the light's sphere, and those where it lies
    between its near and its far side. In float64, along each pixel's ray; lights without end count as both."""
    width, height = VOLUME_SIZE
    frame = at.renderer.render(at.scene, View(at.camera, width, height, RenderSettings(samples=1, path="forward")))
    depth = np.asarray(frame.graph.texture("depth").read(), np.float64).reshape(height, width)
    half = np.tan(at.camera.yfov / 2)
    x = (np.arange(width) + 0.5) * (2.0 / width) - 1.0
    y = 1.0 - (np.arange(height) + 0.5) * (2.0 / height)
    rays = np.stack([*np.meshgrid(x * half * width / height, y * half), np.full((height, width), -1.0)], axis=-1)
    solid = depth > 0.0
    rays, far = rays[solid], at.camera.znear / depth[solid]
    length = np.linalg.norm(rays, axis=1)
    rays, far = rays / length[:, None], far * length
    world = at.scene.lights.world()
    pose = at.camera.world_from_camera
    centers = (world["position"] - pose[:3, 3]) @ pose[:3, :3]
    behind = inside = 0
    for center, reach in zip(centers, world["range"], strict=True):
        along = rays @ center
        root = reach * reach - center @ center + along * along if reach > 0.0 else np.full(len(rays), np.inf)
        hit = root > 0.0
        chord = np.sqrt(root[hit])
        kept = far[hit] <= along[hit] + chord
        behind += int(kept.sum())
        inside += int((kept & (far[hit] >= along[hit] - chord)).sum())
    return behind, inside


def _small_times(ctx: Context) -> list[tuple[str, int, int, float]]:
    """A few frames of another size, so that the fit can tell pixels from lights."""
    import time

    device, found = _device(ctx), []
    at = lit(ctx, "atrium", 64)
    for path in PATHS:
        seen = View(at.camera, 160, 90, RenderSettings(samples=1, path=path))
        taken = []
        for _ in range(6):
            start = time.perf_counter()
            at.renderer.render(at.scene, seen)
            device.finish()
            taken.append((time.perf_counter() - start) * 1e3)
        found.append((path, 64, 160 * 90, float(np.median(taken[1:]))))
    return found


def _findings(times: dict[tuple[str, str, int], float], scene: str, counts: list[int]) -> str:
    """What the thesis claims of the paths, as it came out here."""
    lines = []
    for first, second in CROSSING:
        at = _crossing(times, scene, first, second, counts)
        lines.append(f"{second} beats {first} from N* = {at:.3g} lights on" if at else f"{second} never beats {first}")
    both = [n for n in counts if _both(times, scene, "forward-plus", "tiled-deferred", n)]
    wins = [n for n in both if times[scene, "forward-plus", n] < times[scene, "tiled-deferred", n]]
    lines.append(f"forward-plus is faster than tiled-deferred at {len(wins)} of {len(both)} counts")
    slopes = {path: _slope(times, scene, path, counts) for path in PATHS[1:]}
    told = ", ".join(f"{path} {slope * 1e3:.3g}" for path, slope in slopes.items() if slope is not None)
    text = "; ".join(lines) + f". Microseconds per light added past 1,024: {told or 'not measured'}."
    classic = slopes["deferred"]
    for path in ("tiled-deferred", "forward-plus"):
        for most in (MOST_VOLUMES, counts[-1]):
            slope = _slope(times, scene, path, [n for n in counts if n <= most])
            if classic and slope and slope > 0.0:
                text += f" Up to {most:,}, deferred's slope is {classic / slope:.1f} times that of {path}."
    return text


def _crossing(
    times: dict[tuple[str, str, int], float], scene: str, first: str, second: str, counts: list[int]
) -> float | None:
    """N*: from so many lights on, `second` is the cheaper path."""
    both = [n for n in counts if _both(times, scene, first, second, n)]
    return crossover(both, [times[scene, first, n] for n in both], [times[scene, second, n] for n in both])


def charts(ctx: Context, points: Sequence[Point]) -> Iterator[Chart]:
    """For each scene the time of each path against the number of lights, and where they cross."""
    width, height = size(ctx)
    for scene in SAMPLES:
        mine = [p for p in points if p.knobs["scene"] == scene and p.ms is not None]
        lines = [
            ChartLine(path, [
                ChartPoint(float(p.knobs["lights"]), p.ms.median, p.ms.low, p.ms.high)
                for p in sorted(mine, key=lambda p: int(p.knobs["lights"])) if p.knobs["method"] == path and p.ms
            ])
            for path in PATHS
        ]  # fmt: skip
        times = {(scene, line.name, int(p.x)): p.y for line in lines for p in line.points}
        counts = sorted({key[2] for key in times})
        marks = []
        for first, second in CROSSING:
            at = _crossing(times, scene, first, second, counts)
            if at is not None and at > counts[0]:
                shared = [n for n in counts if _both(times, scene, first, second, n)]
                level = np.interp(np.log(at), np.log(shared), [np.log(times[scene, second, n]) for n in shared])
                marks.append(ChartMark(at, float(np.exp(level)), f"{second} below {first}"))
        yield Chart(
            f"{scene}: a frame at {width}x{height} by the number of lights", "local lights", "median frame time (ms)",
            lines, marks, "N*: from there on the second path stays the cheaper one. Down is better.",
        )  # fmt: skip


def _needs(found: dict[tuple[str, str, int], dict[str, Any]], scene: str) -> str:
    """What the exact need alone imposes: the lights a pixel goes through against those of perfect lists."""
    counts = [n for (name, path, n), extra in found.items()
              if (name, path) == (scene, "tiled-deferred") and KEPT[0] in extra and n >= 1024]  # fmt: skip
    if not counts:
        return ""
    parts = []
    for n in (min(counts), max(counts)):
        kept, tile, pixel = (found[scene, "tiled-deferred", n][name] for name in KEPT[1:])
        parts.append(f"at {n:,} lights through {kept:.1f} (exact lists of its tile {tile:.1f}, own {pixel:.1f})")
    return f" A pixel of tiled-deferred goes {'; '.join(parts)}."


def _both(times: dict[tuple[str, str, int], float], scene: str, a: str, b: str, n: int) -> bool:
    return (scene, a, n) in times and (scene, b, n) in times


def _slope(times: dict[tuple[str, str, int], float], scene: str, path: str, counts: list[int]) -> float | None:
    """ms per light between 1,024 and the most that was measured."""
    past = [n for n in counts if n > 1024 and (scene, path, n) in times]
    if not past or (scene, path, 1024) not in times:
        return None
    return (times[scene, path, past[-1]] - times[scene, path, 1024]) / (past[-1] - 1024)


def _ms(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"


EXPERIMENT = Experiment(
    title="Many lights: render paths and culling",
    method="a frame by each path, by the one that auto chooses, and by forward-plus with each way of culling",
    truth="the forward path, every light in every pixel; where it is too slow to wait for, deferred light volumes,"
    " which have no lists that could miss a light",
    metric="max_difference",
    unit="scene-linear",
    knobs=knobs,
    default={"method": "auto"},
    curve="method",
    problem="problem",
    run=run,
    needs=frozenset({"gpu"}),
    timed="gpu",
    patience=2.0,
    held_within=HELD_WITHIN,
    tables=tables,
    charts=charts,
    time_label="median frame time",
    note="The error must be zero: only time differs. Forward is omitted where a frame takes seconds. The three-pass"
    " form gathers light apart from surfaces and is an approximation.",
)
