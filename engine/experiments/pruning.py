"""Leaving out what a scene does not need: the same picture, and what it saves, scene by scene."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.interval import ratio_interval
from engine.report.metrics import max_error, rmse
from engine.report.page.text import milliseconds
from engine.report.records import Point, Table

FRAMES = ("pruned", "all")
COUNTERS = ("api_calls", "draws", "bytes_uploaded", "transient_bytes")


@dataclass(slots=True)
class Measured:
    """What one way of rendering a scene gave besides times."""

    picture: NDArray[np.uint8]
    hdr: NDArray[np.float32]
    first_ms: float
    counters: dict[str, int | float]
    programs: int
    left_out: list[str] = field(default_factory=list)


#: made here; with the sample project's scene they are ten, whatever else is there
MADE_SCENES = [MADE + n for n in ("nothing", "flat", "ball", "textured", "glass", "leaves", "blocks", "room", "crowd")]
QUICK = 3


def scenes(ctx: Context) -> list[str]:
    lent = [str(path) for path in ctx.tools.sample_scenes()] if ctx.tools is not None and ctx.live is None else []
    made = [s for s in MADE_SCENES if not ctx.quick or s in MADE_SCENES[1 :: len(MADE_SCENES) // QUICK]]
    return own_or(ctx, (lent[:1] if ctx.quick else lent) + made)


def knobs(ctx: Context) -> list[dict[str, Any]]:
    if ctx.quick and not ctx.scenes and ctx.live is None:
        ctx.omit("the other sample scenes", "quick mode")
    return [{"frame": frame, "scene": name} for name in scenes(ctx) for frame in FRAMES]


def prepare(ctx: Context) -> Iterator[tuple[float, str]]:
    """Measure every scene before any is opened for timing: one that is open shares its programs with the next."""
    found: dict[str, dict[str, Measured] | LucarnaError] = {}
    ctx.scratch["measured"] = found
    names = scenes(ctx)
    for i, name in enumerate(names):
        yield i / len(names), f"first frames of {short(name)}"
        try:
            found[name] = measure(ctx, name)
        except LucarnaError as error:
            found[name] = error


def measure(ctx: Context, name: str) -> dict[str, Measured]:
    """Both ways of rendering a scene, each in a renderer of its own with nothing compiled.

    The first round of two fills the driver's cache on disk, which the way that comes second would else profit from;
    quick mode has one round and says so.
    """
    found: dict[str, Measured] = {}
    if ctx.quick:
        ctx.omit(
            "a second round of first frames", "quick mode: the full frame came first, with the driver's cache cold"
        )
    for _ in range(1 if ctx.quick else 2):
        for frame in reversed(FRAMES):
            scene = open_scene(ctx, name)
            try:
                found[frame] = _first_frames(ctx, scene, frame)
            finally:
                scene.close()
    return found


def _first_frames(ctx: Context, scene: OpenScene, frame_kind: str) -> Measured:
    device, view = _device(ctx), _view(ctx, scene, frame_kind)
    device.finish()
    start = time.perf_counter()
    frame = scene.render(view)
    device.finish()
    first_ms = (time.perf_counter() - start) * 1e3
    programs = int(frame.stats.counters["programs_compiled"])
    frame = scene.render(view)
    picture, counters, left_out = frame.color.read(), dict(frame.stats.counters), scene.explain(frame)
    hdr = scene.render(view, hdr=True).hdr
    assert hdr is not None, "asked for"
    return Measured(
        np.asarray(picture, np.uint8), np.asarray(hdr.read(), np.float32), first_ms, counters, programs, left_out
    )


def _view(ctx: Context, scene: OpenScene, frame: str) -> View:
    width, height = (320, 180) if ctx.quick else (640, 360)
    return View(scene.camera(width / height), width, height, RenderSettings(force_all=frame == "all"))


def _device(ctx: Context) -> Device:
    assert ctx.device is not None, "the experiment needs a device"
    return ctx.device


def run(ctx: Context, chosen: Knobs) -> Trial:
    name, device = str(chosen["scene"]), _device(ctx)
    found: dict[str, Measured] | LucarnaError = ctx.scratch["measured"][name]
    if isinstance(found, LucarnaError):
        raise found
    both = found
    scene = open_scene(ctx, name)
    view = _view(ctx, scene, chosen["frame"])

    def work() -> None:
        scene.render(view)
        device.finish()

    return Trial(work, lambda _: _judge(ctx, both, chosen), whole=True, close=scene.close)


def _judge(ctx: Context, both: dict[str, Measured], chosen: Knobs) -> Outcome:
    mine, full = both[chosen["frame"]], both["all"]
    extra: dict[str, Any] = {name.replace("_", " "): int(mine.counters.get(name, 0)) for name in COUNTERS}
    extra |= {"programs": mine.programs, "first frame ms": mine.first_ms}
    error = {"max_difference": max_error(mine.hdr, full.hdr), "rmse_8_bit": rmse(mine.picture, full.picture)}
    pictures = []
    if chosen["frame"] == "pruned":
        name = short(chosen["scene"])
        a, b = (m.picture[..., :3] for m in (mine, full))
        pictures = beside_truth(ctx, f"{name}, pruned", a, "nothing left out", b)
    return Outcome(error, extra=extra, pictures=pictures)


def tables(ctx: Context, points: Sequence[Point]) -> list[Table]:
    """The saving per scene with its 95 % interval, and what was left out and why."""
    rows, reasons = [], []
    for name in scenes(ctx):
        found = {p.knobs["frame"]: p for p in points if p.knobs["scene"] == name}
        if len(found) < 2 or found["pruned"].ms is None or found["all"].ms is None:
            continue
        both: dict[str, Measured] = ctx.scratch["measured"][name]
        a, b = both["pruned"], both["all"]
        ratio = ratio_interval(found["pruned"].samples, found["all"].samples)
        sure = ratio.high < 1.0 or ratio.low > 1.0
        same = bool((a.hdr.view(np.uint32) == b.hdr.view(np.uint32)).all())
        rows.append([
            short(name), f"{milliseconds(found['pruned'].ms.median)} / {milliseconds(found['all'].ms.median)}",
            f"{ratio.value:.3f} [{ratio.low:.3f}, {ratio.high:.3f}]{'' if sure else ' below noise'}",
            *(f"{int(a.counters.get(n, 0)):,} / {int(b.counters.get(n, 0)):,}" for n in COUNTERS),
            f"{a.programs} / {b.programs}", f"{a.first_ms:.0f} / {b.first_ms:.0f}",
            "bit-equal" if same else f"differs by {max_error(a.hdr, b.hdr):.2g}",
        ])  # fmt: skip
        reasons += [[short(name), line] for line in a.left_out]
    reasons = _by_reason(reasons)
    head = ["scene", "ms", "ratio, 95 % interval", "API calls", "draws", "bytes uploaded", "transient bytes",
            "programs", "first frame, ms", "picture"]  # fmt: skip
    return [
        Table(
            "Pruned / everything, per scene",
            head,
            rows,
            "A ratio below 1 is a saving. Frames are timed in turns."
            " First frames compile everything anew, with the driver's own cache on disk warm.",
        ),
        Table("What was left out, and why", ["left out", "why", "scenes"], reasons),
    ]


def _by_reason(told: list[list[str]]) -> list[list[str]]:
    """[scene, "what: why"] rows as [what, why, scenes], what is most often left out first."""
    found: dict[str, list[str]] = {}
    for scene, line in told:
        found.setdefault(line, []).append(scene)
    ordered = sorted(found.items(), key=lambda item: (-len(item[1]), item[0]))
    return [[*line.split(": ", 1), ", ".join(scenes)] for line, scenes in ordered]


EXPERIMENT = Experiment(
    title="Leaving out what a scene does not need",
    method="the frame as the scene's facts prune it, and with every pass and branch forced in",
    truth="the frame with nothing left out; scene-linear float pictures must be bit-equal",
    metric="max_difference",
    unit="scene-linear",
    knobs=knobs,
    default={"frame": "pruned"},
    curve="frame",
    problem="scene",
    run=run,
    prepare=prepare,
    needs=frozenset({"gpu"}),
    own_scene=True,
    patience=3.0,
    timed="gpu",
    tables=tables,
    time_label="median frame time",
    note="No order is expected: the error must be zero. Give your own scenes by --scene FILE.",
)
