"""Mirrors against a path tracer: how many pieces of the picture a mirrored ray goes through, and how far it goes.

Both pictures have light of two surfaces: what a mirror shows is lit by lamps and suns, what is matt is lit by one
surface more (`gi` is one). Off, mirrors see the surroundings, of which there are none in the made scene. All of the
picture counts; what stands outside of it, or shows it its back, no number of pieces finds.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from typing import Any

from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.mirror_answers import Mirrored, bars
from engine.experiments.harness.pixel_truth import radiance, redrawn
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.experiments.harness.shown_light import judge_picture, shown_floor, traced_pictures
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.records import Extreme, Point, Table

SCENES = (MADE + "mirrors",)
STEPS = (16, 32, 64, 128, 256)
#: of the scene's size: as far as there is anything, and a fifth of it
REACH = {"whole": 1.0, "a fifth": 0.2}
STEPS_BY_DEFAULT = 128
DEFAULT = {"reach": "whole", "steps": STEPS_BY_DEFAULT}
#: pieces for which the known answer is asked
KNOWN = (16, 32, 64, 128)


def size(ctx: Context) -> tuple[int, int, int]:
    """Width, height, paths for each pixel."""
    return (72, 72, 96) if ctx.quick else (160, 160, 256)


def knobs(ctx: Context) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for name in own_or(ctx, SCENES):
        found.append({"scene": name, "reach": "off", "steps": 0})
        for reach in ("whole",) if ctx.quick else REACH:
            found += [
                {"scene": name, "reach": reach, "steps": n} for n in ((STEPS_BY_DEFAULT,) if ctx.quick else STEPS)
            ]
    return found


def settings(scene: OpenScene, chosen: Knobs) -> RenderSettings:
    """Scene-linear light alone."""
    how: dict[str, Any] = {"gi": "one", "gi_half": False, "local_shadows": "all"}
    if chosen["steps"]:
        low, high = scene.scene.bounds()
        far = REACH[str(chosen["reach"])] * float(((high - low) ** 2).sum() ** 0.5)
        how |= {"reflections": True, "reflection_steps": int(chosen["steps"]), "reflection_distance": far}
    return RenderSettings(samples=1, background="color", tone_map="none", **how)


def view(ctx: Context, scene: OpenScene, chosen: Knobs) -> View:
    width, height, _ = size(ctx)
    return View(scene.camera(width / height), width, height, settings(scene, chosen))


def prepare(ctx: Context) -> Generator[tuple[float, str], None, None]:
    """Path trace every scene."""
    names = dict.fromkeys(str(k["scene"]) for k in knobs(ctx))
    wanted = {name: (name, f"reflections-{short(name)}", 2) for name in names}
    yield from traced_pictures(ctx, wanted, size(ctx), lambda scene, _: settings(scene, {"reach": "off", "steps": 0}))


def run(ctx: Context, chosen: Knobs) -> Trial:
    film = ctx.scratch[chosen["scene"]]
    if isinstance(film, LucarnaError):
        raise film
    scene = open_scene(ctx, str(chosen["scene"]))
    seen = view(ctx, scene, chosen)
    label = f"{short(str(chosen['scene']))}: {chosen['reach']}, {chosen['steps']}"
    shown = chosen["steps"] in (0, DEFAULT["steps"])

    def judge() -> Outcome:
        return judge_picture(ctx, radiance(scene, seen), film.mean, label if shown else "")

    return redrawn(ctx, scene, seen, judge)


def tables(ctx: Context, points: Sequence[Point]) -> list[Table]:
    rows = []
    for scene in dict.fromkeys(str(p.knobs["scene"]) for p in points):
        of = [p for p in points if p.knobs["scene"] == scene and p.ms is not None]
        off = next((p for p in of if p.knobs["reach"] == "off"), None)
        for p in of:
            if p is not off and (p.knobs["reach"], p.knobs["steps"]) != tuple(DEFAULT.values()):
                continue
            if p.ms is None:
                continue
            more = f"{p.ms.median - off.ms.median:+.3g}" if off is not None and off.ms is not None else ""
            rows.append([
                short(scene), "off" if p is off else "default", f"{p.ms.median:.3g}", "" if p is off else more,
                *(f"{p.error[name]:.3g}" for name in ("shown_rmse", "flip", "energy")),
            ])  # fmt: skip
    bars = [[str(n), f"{100 * m.missed:.2f} %", f"{100 * m.false:.2f} %"] for n, m in known(ctx).items()]
    heads = ["scene", "what", "ms", "costs ms", "display rmse", "FLIP", "energy"]
    return [
        Table("On and off", heads, rows, "Whole frames; energy: all light of the picture over that of the truth."),
        Table(
            "A floor that mirrors thin bars: pixels that are wrong", ["pieces", "a bar is missed", "a bar is too many"],
            bars, "By formula, of pixels that show nothing's edge; bars are two pixels wide.",
        ),
    ]  # fmt: skip


def known(ctx: Context) -> dict[int, Mirrored]:
    """Made once for the table and the extreme case."""
    device = ctx.device
    if device is None:
        return {}
    return ctx.once("reflections: bars", lambda: {n: bars(device, reflection_steps=n) for n in KNOWN})


def extremes(ctx: Context) -> Iterator[Extreme]:
    """What is known without a path tracer, at the default."""
    found = known(ctx).get(STEPS_BY_DEFAULT)
    if found is not None:
        text = f"{100 * found.missed:.2f} % missed, {100 * found.false:.2f} % too many"
        yield Extreme("thin bars in a mirror floor", text, found.missed == 0.0 and found.false == 0.0)


EXPERIMENT = Experiment(
    title="Mirrors against a path tracer",
    method="marched through both layers of what the camera sees, over whole pieces where nothing is; whole frame",
    truth="path tracing on embree with the same surfaces and lights, of two surfaces",
    metric="shown_rmse",
    unit="display value",
    knobs=knobs,
    default=DEFAULT,
    curve="reach",
    problem="scene",
    run=run,
    prepare=prepare,
    tables=tables,
    extremes=extremes,
    needs=frozenset({"gpu", "rays"}),
    own_scene=True,
    timed="gpu",
    noise_floor=shown_floor,
    time_label="median frame time",
    note="No order is expected: what is outside of the picture is not known however far a ray goes.",
)
