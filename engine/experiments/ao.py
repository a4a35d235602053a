"""Ambient occlusion against rays: method, places looked at, half size, smaller depths, frames.

The picture's view of that name is the visibility itself. The truth is the cosine-weighted part of the hemisphere over
each pixel's facet that rays find free, where what they meet counts less with its distance by the fall-off of the
methods: so an infinite number of samples would still leave what depth does not show, and the method's own bias.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.experiments.harness.occlusion_order import COUNTS, errors, slope
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import (
    PixelTruth,
    by_rays,
    greys,
    radiance,
    redrawn,
    truth,
    truths,
    worst_noise,
)
from engine.experiments.harness.pixel_truth import picture_size as size
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.math.quat import from_axis_angle, to_matrix3
from engine.render.occlusion import METHODS, radius_of
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.perceptual import flip
from engine.report.records import Point, Table

F8 = NDArray[np.float64]

SCENES = (MADE + "room", MADE + "blocks", MADE + "box", MADE + "nave", MADE + "atrium")
#: (directions, steps) of horizons; places of the spiral
SLICES, PLACES = ((1, 2), (1, 4), (1, 8), (2, 8), (4, 8), (8, 16)), (4, 9, 16, 32, 64)
#: of what is not the default: half size, hbao
FEWER = SLICES[1:4] + SLICES[-1:]
DEFAULT = ("gtao", 1, 8)
#: what the thesis takes: so many places of the Alchemy method (its ch. 6)
THESIS = ("alchemy", 1, 9)
#: of a time, that two settings may lie apart and count as equal: what runs differ by
SAME_TIME = 0.05
RAYS = 64
#: frames of a camera that goes round what it looks at, and how far it goes in each, radians
FRAMES, STEP = 10, 0.004

PLAIN: dict[str, Any] = {"half": False, "mips": False, "frames": 1}


def knobs(ctx: Context) -> list[dict[str, Any]]:
    """Every method at every number of places; the default at half size, with smaller depths, after some frames of a
    moving camera; on every scene."""
    default = RenderSettings()
    slices: dict[str, Sequence[tuple[int, int]]] = {"gtao": SLICES, "hbao": FEWER}
    places: Sequence[int] = PLACES
    if ctx.quick:
        slices, places = {"gtao": SLICES[::2], "hbao": FEWER[::2]}, PLACES[1::2]
    found: list[dict[str, Any]] = []
    for scene in scenes(ctx):
        rows: list[dict[str, Any]] = [{"method": "off", "directions": 0, "steps": 0, **PLAIN}]
        for method, of in slices.items():
            rows += [{"method": method, "directions": d, "steps": s, **PLAIN} for d, s in of]
        rows += [{"method": "alchemy", "directions": 1, "steps": n, **PLAIN} for n in places]
        rows += [{"method": "gtao", "directions": d, "steps": s, **PLAIN, "half": True} for d, s in slices["hbao"]]
        own = {"method": METHODS[-1], "directions": default.ao_directions, "steps": default.ao_steps, **PLAIN}
        rows += [{**own, "mips": True}, {**own, "frames": FRAMES}, {**own, "directions": 2, "frames": FRAMES}]
        found += [{"scene": scene, **row} for row in (rows if own in rows else [own, *rows])]
    return found


def scenes(ctx: Context) -> list[str]:
    return own_or(ctx, SCENES[:1] if ctx.quick else SCENES)


def settings(chosen: Knobs) -> RenderSettings:
    return RenderSettings(
        samples=1, view="ambient_occlusion", ambient_occlusion=str(chosen["method"]), shadows=False,
        ao_directions=max(int(chosen["directions"]), 1), ao_steps=max(int(chosen["steps"]), 1),
        ao_half=bool(chosen["half"]), ao_mips=bool(chosen["mips"]), ao_temporal=int(chosen["frames"]) > 1,
    )  # fmt: skip


def view(ctx: Context, scene: OpenScene, chosen: Knobs) -> View:
    width, height = size(ctx)
    return View(scene.camera(width / height), width, height, settings(chosen))


def seen(ctx: Context, scene: OpenScene, name: str) -> PixelTruth:
    from engine.experiments.truth.traced_scene import surface_seen, traced
    from engine.experiments.truth.visibility import ambient_occlusion

    bare = view(ctx, scene, {"method": "gtao", "directions": 1, "steps": 1, **PLAIN})
    world = traced(scene, bare.settings)
    met, surface = surface_seen(world, bare.camera, *size(ctx))
    if not met.any():
        raise InputError(f"{short(name)}: nothing solid is seen", hint="turn the camera")
    radius = radius_of(bare.settings, *scene.scene.bounds())

    def rays(which: str) -> F8:
        turned = ctx.rng(f"ao {which}")
        return ambient_occlusion(world.rays, surface.place, surface.face, RAYS, turned, radius, fades=True)

    key = {"rays": RAYS, "radius": radius}
    visible, noise = by_rays(ctx, f"ao-{short(name)}", world, bare.camera, size(ctx), key, rays)
    return PixelTruth(np.flatnonzero(met), visible, noise)


def prepare(ctx: Context) -> Iterable[tuple[float, str]]:
    problems = [(name, name) for name in scenes(ctx)]
    return truths(ctx, problems, "rays into the surroundings", lambda scene, name, _: seen(ctx, scene, name))


def run(ctx: Context, chosen: Knobs) -> Trial:
    name = str(chosen["scene"])
    found = truth(ctx, name)
    scene = open_scene(ctx, name)
    if chosen["method"] == "off":  # its view is white, and hardly anything is drawn: a time would say nothing
        return Trial(None, lambda _: judge(ctx, scene, chosen, found), close=scene.close)
    return redrawn(ctx, scene, view(ctx, scene, chosen), lambda: judge(ctx, scene, chosen, found))


def way(ctx: Context, scene: OpenScene, chosen: Knobs) -> list[View]:
    """Frames of a camera that turns about the world's vertical and ends where the truth is."""
    last = view(ctx, scene, chosen)
    found = []
    for i in range(FRAMES):
        turn = np.eye(4)
        turn[:3, :3] = to_matrix3(from_axis_angle((0.0, 1.0, 0.0), STEP * (i + 1 - FRAMES)))
        camera = replace(last.camera, world_from_camera=turn @ last.camera.world_from_camera)
        found.append(replace(last, camera=camera, seconds=1.0 / 60.0, cut=i == 0))
    return found


def flicker(pictures: Sequence[F8], steady: Sequence[F8]) -> float:
    """How much the error changes from frame to frame, rms: `steady` are the same frames with many slices."""
    off = [a - b for a, b in zip(pictures, steady, strict=True)]
    return float(np.sqrt(np.mean([(b - a) ** 2 for a, b in pairwise(off)])))


def judge(ctx: Context, scene: OpenScene, chosen: Knobs, found: PixelTruth) -> Outcome:
    extra: dict[str, Any] = {"frames": int(chosen["frames"])}
    if int(chosen["frames"]) > 1:
        views = way(ctx, scene, chosen)
        pictures = [radiance(scene, each)[:, 0] for each in views]
        # alone: the same frames, each as if it were the only one
        alone = [radiance(scene, replace(each, seconds=None))[:, 0] for each in views[-3:]]
        many = {**chosen, "directions": 16, "frames": 1}
        steady = [radiance(scene, replace(each, settings=settings(many), seconds=None))[:, 0] for each in views[-3:]]
        extra |= {"flicker": flicker(pictures[-3:], steady), "flicker_alone": flicker(alone, steady)}
        ours = pictures[-1][found.rows]
    else:
        ours = radiance(scene, view(ctx, scene, chosen))[found.rows, 0]
    off = ours - found.value
    a, b = greys(size(ctx), found.rows, ours, found.value)
    error = {
        "rmse": float(np.sqrt(np.mean(off**2))), "bias": float(np.mean(off)), "flip": flip(a, b)[0],
        "worst": float(np.abs(off).max()),
    }  # fmt: skip
    pictures_ = []
    if _shown(chosen) and int(chosen["directions"]) < 2:
        pictures_ = beside_truth(ctx, f"{short(str(chosen['scene']))}: {_named_by(chosen)}", a, f"{2 * RAYS} rays", b)
    return Outcome(error, extra=extra, pictures=pictures_)


def tables(ctx: Context, points: Sequence[Point]) -> Iterable[Table]:
    found = (each_on_each(points), against_the_thesis(points), over_frames(points), order_of_places())
    yield from (table for table in found if table.rows)


def each_on_each(points: Sequence[Point]) -> Table:
    """How far off every technique is on every scene."""
    rows = [
        [short(str(p.knobs["scene"])), _named(p), f"{p.ms.median:.2f}" if p.ms is not None else ""]
        + [f"{p.error[name]:.4f}" for name in ("rmse", "bias", "flip")]
        for p in points
        if p.status == "ok" and _shown(p.knobs)
    ]
    note = "Whole frames. Pictures of them, beside the truth, are below."
    return Table("Each technique on each scene", ["scene", "what", "ms", "rmse", "bias", "FLIP"], rows, note)


def order_of_places() -> Table:
    """Errors of the estimator alone."""
    rows = []
    for name, spiral in (("at random", False), ("on the spiral", True)):
        found = errors(spiral=spiral)
        rows.append([name, *(f"{e:.4f}" for e in found), f"{slope(found):.2f}"])
    note = (
        "A wall that is known, and no depth that could hide anything: order -0.5 at random, about -0.75 for points of"
        " low discrepancy. In pictures the method's bias is what is left."
    )
    return Table("Order of the number of places", ["places", *map(str, COUNTS), "slope"], rows, note)


def _shown(chosen: Knobs) -> bool:
    """The techniques that are shown beside the truth: the default, at half size too; as many places of the others."""
    if chosen["mips"] or int(chosen["frames"]) != 1:
        return False
    return (chosen["method"], chosen["directions"], chosen["steps"]) in (
        ("off", 0, 0), DEFAULT, ("gtao", 2, 8), ("hbao", 1, 8), THESIS,
    )  # fmt: skip


def against_the_thesis(points: Sequence[Point]) -> Table:
    """The default and the best setting that takes as long as the thesis's own, beside it, on every scene."""
    rows: list[list[str]] = []
    good = [p for p in points if p.status == "ok" and p.ms is not None]
    for scene in dict.fromkeys(p.knobs["scene"] for p in good):
        here = [p for p in good if p.knobs["scene"] == scene]
        theirs = next((p for p in here if _is(p, *THESIS)), None)
        ours = next((p for p in here if _is(p, *DEFAULT)), None)
        if theirs is None or ours is None:
            continue
        limit = _ms(theirs)
        others = [p for p in here if p.knobs["method"] != "alchemy" and p.knobs["frames"] == 1]
        quick = [p for p in others if p.knobs["method"] != "off" and _ms(p) <= limit * (1.0 + SAME_TIME)]
        longer = [p for p in here if p.knobs["method"] == "alchemy" and _ms(p) <= _ms(ours) * (1.0 + SAME_TIME)]
        most = min(longer, key=lambda p: p.error["rmse"], default=theirs)
        best = min(quick, key=lambda p: p.error["rmse"], default=None)
        rows.append([
            short(str(scene)), f"{theirs.error['rmse']:.4f}", f"{limit:.2f}", f"{ours.error['rmse']:.4f}",
            f"{_ms(ours):.2f}", _named(best), f"{best.error['rmse']:.4f}" if best else "",
            f"{theirs.error['rmse'] / best.error['rmse']:.2f}" if best else "",
            _named(most), f"{most.error['rmse']:.4f}", f"{most.error['rmse'] / ours.error['rmse']:.2f}",
        ])  # fmt: skip
    header = [
        "scene", "Alchemy, 9 places: rmse", "ms", "default: rmse", "ms", "best in that time", "rmse", "times nearer",
        "Alchemy in the default's time", "rmse", "default is times nearer",
    ]  # fmt: skip
    return Table("Against the thesis's 9 places of the Alchemy method", header, rows)


def over_frames(points: Sequence[Point]) -> Table:
    rows = [
        [short(str(p.knobs["scene"])), str(p.knobs["directions"])]
        + [f"{value:.4f}" for value in (p.error["rmse"], p.extra["flicker"], p.extra["flicker_alone"])]
        for p in points
        if "flicker" in p.extra
    ]
    header = ["scene", "slices", "rmse", "change of the error a frame, mixed", "each frame alone"]
    return Table(f"A camera that moves: the last of {FRAMES} frames", header, rows)


def _is(point: Point, method: str, directions: int, steps: int) -> bool:
    wanted = {"method": method, "directions": directions, "steps": steps, **PLAIN}
    return all(point.knobs[name] == value for name, value in wanted.items())


def _ms(point: Point) -> float:
    return point.ms.median if point.ms is not None else np.inf


def _named(point: Point | None) -> str:
    if point is None:
        return "none"
    return _named_by(point.knobs)


def _named_by(k: Knobs) -> str:
    if k["method"] == "off":
        return "off"
    places = f"{k['directions']}x{k['steps']}" if k["method"] != "alchemy" else str(k["steps"])
    return f"{k['method']} {places}{', half size' if k['half'] else ''}"


EXPERIMENT = Experiment(
    title="Ambient occlusion against rays",
    method="from depth alone: horizons in slices (gtao, hbao) or a spiral of places (alchemy); whole frame",
    truth="cosine-weighted visibility by rays from each pixel's place, with the methods' fall-off",
    metric="rmse",
    unit="visibility",
    knobs=knobs,
    default={"method": DEFAULT[0], "directions": DEFAULT[1], "steps": DEFAULT[2], **PLAIN},
    curve="method",
    problem="scene",
    also=("frames",),
    run=run,
    prepare=prepare,
    tables=tables,
    orders=[
        Order(0.0, "depth shows fronts only: more places end at the method's bias", "places",
              step=lambda k: 1.0 / max(float(k["directions"] * k["steps"]), 1.0), curve="alchemy", tolerance=0.5),
    ],
    needs=frozenset({"gpu", "rays"}),
    own_scene=True,
    timed="gpu",
    noise_floor=worst_noise,
    step_label="1 / places",
    time_label="median frame time",
)  # fmt: skip
