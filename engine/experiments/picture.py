"""The settings of a picture on one scene: what each costs, what it gives, which are not worth their time here.

Every setting is changed by itself, the others stay as the view has them. The truth is the best that the same renderer
can do: four times the pixels each way, the largest shadow maps with the most lookups, the sharpest textures. So the
error is what settings can change; what the lighting itself leaves out is another question (picture_lights).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.experiments.picture_lights import has_samples
from engine.math.color import srgb_to_linear, to_u1
from engine.render.facts import SceneFacts
from engine.render.lighting import PATH_CHOICES, TILE_SIZES
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.advice import Advice, against
from engine.report.metrics import rmse
from engine.report.page.text import milliseconds, plain
from engine.report.perceptual import flip
from engine.report.records import Floor, Point, Table

Bytes = NDArray[np.uint8]

AS_IT_IS = {"setting": "as it is", "value": ""}
#: pixels of the truth for each pixel, each way
FINER = 4
BEST = {"shadow_filter": "vogel16", "shadow_size": 4096, "shadow_cascades": 4, "anisotropy": 16.0}
#: what has no place in a picture that is judged
PLAIN = {"view": "lit", "check_numbers": False, "light_stats": False}
#: setting -> (values, whether a picture with these facts could change)
VARIED: dict[str, tuple[tuple[Any, ...], Any]] = {
    "samples": ((1, 2, 4, 8), lambda f: True),
    "shadows": ((False,), lambda f: f.sun_shadows),
    "shadow_filter": (("none", "pcf", "vogel8", "vogel16", "pcss"), lambda f: f.sun_shadows),
    "shadow_size": ((512, 1024, 2048), lambda f: f.sun_shadows),
    "shadow_cascades": ((1, 2, 3, 4), lambda f: f.sun_shadows),
    "path": (tuple(p for p in PATH_CHOICES if p != "auto"), lambda f: f.local_lights),
    "light_tile": (tuple(map(str, TILE_SIZES)), lambda f: f.local_lights and f.lighting.path != "forward"),
    "depth_first": ((True,), lambda f: f.opaque and not f.depth_first),
    "alpha_to_coverage": ((False,), lambda f: f.alpha_to_coverage),
    "anisotropy": ((1.0, 4.0, 16.0), lambda f: True),
    "force_all": ((True,), lambda f: True),
}
SCENES = [MADE + name for name in ("blocks", "room", "leaves")]


@dataclass(slots=True)
class Seen:
    """A scene as it is looked at: its own settings, what is in it, and the best picture of it."""

    settings: RenderSettings
    facts: SceneFacts
    best: Bytes
    width: int
    height: int


def scenes(ctx: Context) -> list[str]:
    return own_or(ctx, SCENES[:1] if ctx.quick else SCENES)


def size(ctx: Context) -> tuple[int, int]:
    """The open view's shape, no larger than is needed to judge it."""
    width, height = (256, 171) if ctx.quick else (384, 256)
    if ctx.live is not None:
        height = min(2 * width, max(16, round(width / ctx.live.view.aspect)))
    return width, height


def prepare(ctx: Context) -> Iterable[tuple[float, str]]:
    named = scenes(ctx)
    if ctx.quick and ctx.live is None and not ctx.scenes:
        ctx.omit("the scenes " + ", ".join(short(s) for s in SCENES[1:]), "quick mode")
    for i, name in enumerate(named):
        yield i / len(named), f"the best picture of {short(name)}"
        try:
            scene = open_scene(ctx, name)
            try:
                ctx.scratch[name] = look(ctx, scene)
            finally:
                scene.close()
        except LucarnaError as error:
            ctx.scratch[name] = error


def look(ctx: Context, scene: OpenScene) -> Seen:
    width, height = size(ctx)
    own = ctx.live.view.settings if ctx.live is not None else RenderSettings()
    camera = scene.camera(width / height)
    facts = scene.render(View(camera, width, height, changed(own, **PLAIN))).facts
    best = View(camera, width * FINER, height * FINER, changed(own, samples=1, **PLAIN, **BEST))
    fine = np.asarray(scene.render(best).color.read(), np.uint8)[..., :3]
    # averaged after the display's curve, as samples are: what eyes would do with a finer display
    mean = srgb_to_linear(fine.reshape(height, FINER, width, FINER, 3) / 255.0).mean(axis=(1, 3))
    return Seen(changed(own, **PLAIN), facts, to_u1(mean), width, height)


def changed(settings: RenderSettings, **values: Any) -> RenderSettings:
    """A copy with some values set."""
    return RenderSettings(**{**settings.values(), **values})


def knobs(ctx: Context) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for name in scenes(ctx):
        found.append({"scene": name, **AS_IT_IS})
        seen = ctx.scratch[name]
        if isinstance(seen, LucarnaError):
            continue
        for setting, (values, matters) in VARIED.items():
            if not matters(seen.facts):
                ctx.omit(f"{short(name)}: {setting}", "it changes nothing in that scene")
                continue
            for value in values:
                if setting == "samples" and not has_samples(ctx, value):
                    continue
                if value != getattr(seen.settings, setting):
                    found.append({"scene": name, "setting": setting, "value": value})
    return found


def run(ctx: Context, chosen: Knobs) -> Trial:
    name = str(chosen["scene"])
    seen = ctx.scratch[name]
    if isinstance(seen, LucarnaError):
        raise seen
    assert ctx.device is not None, "the experiment needs a device"
    device, scene = ctx.device, open_scene(ctx, name)
    values = {} if chosen["setting"] == AS_IT_IS["setting"] else {str(chosen["setting"]): chosen["value"]}
    view = View(scene.camera(seen.width / seen.height), seen.width, seen.height, changed(seen.settings, **values))

    def work() -> None:
        scene.render(view)
        device.finish()

    def judge(_: object) -> Outcome:
        frame = scene.render(view)
        got = np.asarray(frame.color.read(), np.uint8)[..., :3]
        error = {"flip": flip(got, seen.best)[0], "rmse_8_bit": rmse(got, seen.best)}
        counters = frame.stats.counters
        extra = {"api calls": int(counters.get("api_calls", 0)),
                 "transient bytes": int(counters.get("transient_bytes", 0))}  # fmt: skip
        shown = not values or values in ({"shadows": False}, {"samples": 1})
        label = f"{short(name)}, {chosen['setting']} {plain(chosen['value'])}".rstrip()
        return Outcome(error, extra=extra, pictures=beside_truth(ctx, label, got, "best", seen.best) if shown else [])

    return Trial(work, judge, gpu=True, close=scene.close)


def tables(ctx: Context, points: Sequence[Point]) -> list[Table]:
    """What each change would do, the worthwhile first."""
    rows: list[list[str]] = []
    for name in scenes(ctx):
        timed = [p for p in points if p.knobs["scene"] == name and p.ms is not None]
        own = next((p for p in timed if p.knobs["setting"] == AS_IT_IS["setting"]), None)
        if own is None:
            continue
        found = sorted((against(p, own, "flip", "FLIP") for p in timed if p is not own), key=Advice.rank)
        for advice in found:
            rows.append([
                short(name), f"{advice.knobs['setting']} {plain(advice.knobs['value'])}", advice.text,
                f"{advice.ratio.value:.2f} [{advice.ratio.low:.2f}, {advice.ratio.high:.2f}]",
                milliseconds(advice.ms_saved) if advice.sure else "below noise", f"{-advice.error_removed:+.4f}",
                f"{advice.per_ms:.3g}" if advice.per_ms else "",
            ])  # fmt: skip
    return [
        Table(
            "What each change would do",
            ["scene", "change", "verdict", "time against now, 95 %", "ms saved", "FLIP", "FLIP per ms"], rows,
            "FLIP per ms: the error that a millisecond removes or a saved one costs. Each change by itself; together"
            " they need not add up.",
        )
    ]  # fmt: skip


EXPERIMENT = Experiment(
    title="Settings of a picture",
    method="one setting changed at a time, the others as the view has them",
    truth="the best of the same renderer: 16 pixels for each, shadow maps of 4096 texels with 16 lookups, sharpest"
    " textures",
    metric="flip",
    unit="FLIP",
    knobs=knobs,
    default=AS_IT_IS,
    curve="setting",
    problem="scene",
    run=run,
    prepare=prepare,
    needs=frozenset({"gpu"}),
    own_scene=True,
    advisory=True,
    patience=3.0,
    timed="gpu",
    format_floor=Floor(1.0 / 255.0, "one step of 8 bits"),
    tables=tables,
    time_label="median frame time",
    note="No order is expected: these are choices. Give your own scene by --scene FILE; in an editor it is the open"
    " one.",
)
