"""Light between surfaces against a path tracer: how it is gathered, from how many places, at which size; bounces.

Two problems for each scene: light that was reflected once (the truth's paths end at the second surface), and five
times. All of the picture counts: what shadows, highlights and the environment's light are wrong by is in every row,
also in the one that is off. It is judged as shown, exposed for the truth: one highlight would be all of a linear
error. The spiral is the gather of the thesis (50 places on 19 turns, in its right form).
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.gi_answers import Answer, answers, lag
from engine.experiments.harness.pixel_truth import radiance, redrawn
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.experiments.harness.shown_light import judge_picture, shown_floor, traced_pictures
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.records import Extreme, Point, Table

F8 = NDArray[np.float64]

SCENES = [MADE + name for name in ("box", "atrium")]
#: name -> (surfaces that the truth's paths may meet, our settings)
BOUNCES: dict[str, tuple[int, dict[str, Any]]] = {
    "one": (2, {"gi": "one"}), "many": (6, {"gi": "many", "gi_bounces": 5}),
}  # fmt: skip
THESIS = {"method": "spiral, thesis", "steps": 50}
#: method -> settings
METHODS: dict[str, dict[str, Any]] = {
    "off": {"gi": "off"},
    "slices": {"gi_half": False},
    "slices, half size": {"gi_half": True},
    "slices, one layer": {"gi_half": True, "gi_layers": 1},
    "slices, unseen as seen": {"gi_half": True, "gi_unseen": "seen"},
    "spiral, thesis": {"gi_half": False, "gi_method": "spiral"},
    "spiral, half size": {"gi_half": True, "gi_method": "spiral"},
}
STEPS: dict[str, tuple[int, ...]] = {
    "off": (0,), "slices": (8, 16, 32), "slices, half size": (4, 8, 16, 32), "slices, one layer": (16,),
    "slices, unseen as seen": (16,), "spiral, thesis": (12, 25, 50), "spiral, half size": (50,),
}  # fmt: skip
DEFAULT = {"method": "slices, half size", "steps": 16}
#: frames that light may stay after its lamp went out
LONGEST_LAG = 16


def size(ctx: Context) -> tuple[int, int, int]:
    """Width, height, paths for each pixel."""
    return (72, 72, 96) if ctx.quick else (144, 96, 128)


def scenes(ctx: Context) -> list[str]:
    return own_or(ctx, SCENES[:1] if ctx.quick else SCENES)


def knobs(ctx: Context) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for name in scenes(ctx):
        for bounces in ("one",) if ctx.quick else BOUNCES:
            problem = {"scene": name, "bounces": bounces, "problem": f"{short(name)}, {bounces}"}
            for method, steps in STEPS.items():
                few = [s for s in steps if s in (0, 16, 50)] if ctx.quick else steps
                found += [{**problem, "method": method, "steps": step} for step in few]
    return found


def settings(chosen: Knobs) -> RenderSettings:
    """Scene-linear light alone."""
    steps = {"gi_steps": int(chosen["steps"])} if chosen["steps"] else {}
    how = {**BOUNCES[str(chosen["bounces"])][1], **METHODS[str(chosen["method"])], **steps}
    return RenderSettings(samples=1, background="color", tone_map="none", local_shadows="all", **how)


def view(ctx: Context, scene: OpenScene, chosen: Knobs) -> View:
    width, height, _ = size(ctx)
    return View(scene.camera(width / height), width, height, settings(chosen))


def prepare(ctx: Context) -> Generator[tuple[float, str], None, None]:
    """Path trace every scene, once for each number of bounces."""
    problems = dict.fromkeys((str(k["scene"]), str(k["bounces"])) for k in knobs(ctx))
    wanted = {(name, many): (name, f"gi-{short(name)}-{many}", BOUNCES[many][0]) for name, many in problems}
    yield from traced_pictures(
        ctx, wanted, size(ctx), lambda _, key: settings({"bounces": key[1], "method": "off", "steps": 0})
    )


def run(ctx: Context, chosen: Knobs) -> Trial:
    film = ctx.scratch[chosen["scene"], chosen["bounces"]]
    if isinstance(film, LucarnaError):
        raise film
    scene = open_scene(ctx, str(chosen["scene"]))
    return redrawn(ctx, scene, view(ctx, scene, chosen), lambda: judge(ctx, scene, chosen, film.mean))


def judge(ctx: Context, scene: OpenScene, chosen: Knobs, truth: F8) -> Outcome:
    shown = chosen["method"] == "off" or chosen["steps"] in (DEFAULT["steps"], THESIS["steps"])
    label = f"{chosen['problem']}: {chosen['method']}" if shown else ""
    return judge_picture(ctx, radiance(scene, view(ctx, scene, chosen)), truth, label)


def tables(ctx: Context, points: Sequence[Point]) -> list[Table]:
    """What switching it on costs and removes, and the default beside the thesis's gather."""
    rows = []
    for problem in dict.fromkeys(str(p.knobs["problem"]) for p in points):
        of = {(str(p.knobs["method"]), int(p.knobs["steps"])): p for p in points if p.knobs["problem"] == problem}
        for title, key in (
            ("off", ("off", 0)), ("default", (DEFAULT["method"], DEFAULT["steps"])),
            ("thesis", (THESIS["method"], THESIS["steps"])),
        ):  # fmt: skip
            point = of.get((str(key[0]), int(str(key[1]))))
            if point is None or point.ms is None:
                continue
            e = point.error
            off = of.get(("off", 0))
            more = point.ms.median - off.ms.median if off is not None and off.ms is not None else 0.0
            rows.append([
                problem, title, f"{point.ms.median:.3g}", f"{more:+.3g}" if title != "off" else "",
                *(f"{e[name]:.3g}" for name in ("shown_rmse", "flip", "energy")),
            ])  # fmt: skip
    return [
        Table(
            "On, off, and the thesis's 50 places",
            ["problem", "what", "ms", "costs ms", "display rmse", "FLIP", "energy"], rows,
            "Whole frames; what it costs is beside the frame with it off. Energy: all light of the picture over that of"
            " the truth.",
        ),
        Table(
            "Known answers", ["what", "truth", "ours", "error", "allowed"],
            [
                [a.what, f"{a.truth:.4g}", f"{a.ours:.4g}", f"{a.error:+.2g}", f"{a.allowed:.2g}"]
                for a in known(ctx)
            ],
            "By formula; a closed box knows all of itself (gi_unseen = seen).",
        ),
    ]  # fmt: skip


def known(ctx: Context) -> list[Answer]:
    """Made once for the table and the extreme cases."""
    device = ctx.device
    return ctx.once("gi: known answers", lambda: list(answers(device))) if device is not None else []


def extremes(ctx: Context) -> Iterator[Extreme]:
    """What is known without a path tracer; and a lamp that goes out while pictures follow one another."""
    for answer in known(ctx):
        found = f"{answer.ours:.4g}, truth {answer.truth:.4g}, off by {answer.error:+.2g}"
        yield Extreme(answer.what, found, answer.ok)
    if ctx.device is not None:
        for smooth in (False, True):
            frames = lag(ctx.device, smooth=smooth)
            what = f"a lamp goes out, {'mixed with frames before' if smooth else 'each frame anew'}"
            yield Extreme(what, f"{frames} frames to 1 %", frames <= LONGEST_LAG)


EXPERIMENT = Experiment(
    title="Light between surfaces against a path tracer",
    method="gathered from one or two layers of what the camera sees, in slices or on a spiral; whole frame",
    truth="path tracing on embree with the same surfaces and lights, to the same number of bounces",
    metric="shown_rmse",
    unit="display value",
    knobs=knobs,
    default=DEFAULT,
    curve="method",
    problem="problem",
    run=run,
    prepare=prepare,
    extremes=extremes,
    tables=tables,
    needs=frozenset({"gpu", "rays"}),
    own_scene=True,
    timed="gpu",
    noise_floor=shown_floor,
    time_label="median frame time",
    note="No order is expected: places outside of the picture, and backs of what is seen, are not known however many"
    " places are looked at.",
)
