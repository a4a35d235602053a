"""Our forward lighting against a path tracer: what its approximations cost, and what it leaves out altogether.

Three truths, each asking for more:

    unshadowed   the same lights, nothing in their way: the difference is the approximations alone (the split sum and
                 nine harmonics for surroundings, area lights as fitted cosines, single scattering under lamps)
    direct       with shadows, of surroundings too: adds what shadow maps and ambient occlusion are for
    full         with light from surface to surface: adds what global illumination is for

The metric is against the first; the table has all three, which says where the next effort pays.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.math.color import linear_to_srgb
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.metrics import max_error, rel_mse, rmse
from engine.report.perceptual import flip
from engine.report.records import Floor, Picture, Point, Table

F8 = NDArray[np.float64]

TRUTHS = ("unshadowed", "direct", "full")
SCENES = [MADE + name for name in ("metals", "room", "panel", "blocks")]
SAMPLES = (1, 2, 4, 8)


def size(ctx: Context) -> tuple[int, int, int]:
    """Width, height, paths for each pixel; more pixels for scenes that somebody wants to look at."""
    if ctx.quick:
        return (144, 96, 96) if ctx.scenes or ctx.live is not None else (72, 48, 192)
    return (144, 96, 256)


def scenes(ctx: Context) -> list[str]:
    return own_or(ctx, SCENES[:2] if ctx.quick else SCENES)


def knobs(ctx: Context) -> list[dict[str, Any]]:
    if ctx.quick and not ctx.scenes and ctx.live is None:
        ctx.omit("the scenes " + ", ".join(short(s) for s in SCENES[2:]), "quick mode")
    return [{"scene": scene, "samples": n} for scene in scenes(ctx) for n in SAMPLES if has_samples(ctx, n)]


def has_samples(ctx: Context, wanted: int) -> bool:
    """Whether the device has just so many samples a pixel; what it has not is an omission."""
    got = ctx.device.caps.samples_for(wanted) if ctx.device is not None else wanted
    if got != wanted:
        ctx.omit(f"samples {wanted}", f"the device takes {got} for it")
    return got == wanted


def settings(samples: int = 4, **more: Any) -> RenderSettings:
    """Scene-linear light alone: no background, no curve. Shadows as they are, except where the truth has none."""
    return RenderSettings(samples=samples, background="color", tone_map="none", **more)


def prepare(ctx: Context) -> Generator[tuple[float, str], None, None]:
    """Path trace every scene's truths, slice by slice."""
    yield from traced_truths(ctx, scenes(ctx), TRUTHS)


def traced_truths(ctx: Context, named: Sequence[str], kinds: Sequence[str]) -> Generator[tuple[float, str], None, None]:
    """Films of the scenes by truth, in `ctx.scratch[scene, kind]`; for a scene that cannot be opened, the error in
    `ctx.scratch[scene]`."""
    from engine.experiments.truth import reference
    from engine.experiments.truth.path_tracer import Settings
    from engine.experiments.truth.traced_scene import traced

    width, height, paths = size(ctx)
    for i, name in enumerate(named):
        try:
            scene = open_scene(ctx, name)
        except LucarnaError as error:
            ctx.scratch[name] = error
            continue
        try:
            world = traced(scene, settings())
            camera = scene.camera(width / height)
            for note in world.notes:
                ctx.notes.append(f"{short(name)}: {note}.")
            for j, kind in enumerate(kinds):
                how = Settings(paths, 1 if kind != "full" else 6, shadows=kind != "unshadowed", seed=ctx.seed)
                label = f"picture-{short(name)}-{kind}"
                steps = reference.picture(ctx, label, world, camera, width, height, how)
                while True:
                    try:
                        done, text = next(steps)
                    except StopIteration as stop:
                        ctx.scratch[name, kind] = stop.value
                        break
                    yield (i + (j + done) / len(kinds)) / len(named), text
        finally:
            scene.close()


def run(ctx: Context, chosen: Knobs) -> Trial:
    name, samples = str(chosen["scene"]), int(chosen["samples"])
    if isinstance(ctx.scratch.get(name), LucarnaError):
        raise ctx.scratch[name]
    assert ctx.device is not None, "the experiment needs a device"
    width, height, _ = size(ctx)
    device, scene = ctx.device, open_scene(ctx, name)
    view = View(scene.camera(width / height), width, height, settings(samples))

    def work() -> None:
        scene.render(view)
        device.finish()

    return Trial(work, lambda _: judge(ctx, scene, name, samples), gpu=True, close=scene.close)


def judge(ctx: Context, scene: OpenScene, name: str, samples: int) -> Outcome:
    width, height, _ = size(ctx)
    pictures: dict[str, F8] = {}
    for shadows in (False, True):
        view = View(scene.camera(width / height), width, height, settings(samples, shadows=shadows))
        hdr = scene.render(view, hdr=True).hdr
        assert hdr is not None, "asked for"
        pictures["shadowed" if shadows else "unshadowed"] = np.asarray(hdr.read(), np.float64)[..., :3]
    error: dict[str, float] = {}
    for kind in TRUTHS:
        film = ctx.scratch[name, kind]
        ours = pictures["unshadowed" if kind == "unshadowed" else "shadowed"]
        error[f"shown_rmse_{kind}"] = rmse(shown(ours), shown(film.mean))
        error[f"rel_mse_{kind}"] = rel_mse(ours, film.mean)
        error[f"flip_{kind}"] = flip(shown(ours), shown(film.mean))[0]
    film = ctx.scratch[name, "unshadowed"]
    error["max_error_unshadowed"] = max_error(pictures["unshadowed"], film.mean)
    rows: list[Picture] = []
    if samples == 4:
        rows = beside_truth(ctx, f"{short(name)}: ours, no shadows", bytes_of(pictures["unshadowed"]),
                            "path traced, unshadowed", bytes_of(film.mean))  # fmt: skip
        rows += beside_truth(ctx, "ours", bytes_of(pictures["shadowed"]), "path traced, full",
                             bytes_of(ctx.scratch[name, "full"].mean))  # fmt: skip
    return Outcome(error, extra={"truth's noise": noise(ctx, name, "unshadowed")}, pictures=rows)


def shown(linear: F8) -> F8:
    """Display values in [0, 1]."""
    return linear_to_srgb(np.clip(linear, 0.0, 1.0))


def bytes_of(linear: F8) -> NDArray[np.uint8]:
    return np.asarray(np.rint(shown(linear) * 255.0), np.uint8)


def noise(ctx: Context, name: str, kind: str) -> float:
    """Of a truth, in display values: half the difference of its independent halves."""
    first, second = ctx.scratch[name, kind].halves
    return rmse(shown(first), shown(second)) / 2.0


def noise_floor(ctx: Context) -> Floor | None:
    found = [noise(ctx, name, "unshadowed") for name in scenes(ctx) if (name, "unshadowed") in ctx.scratch]
    return Floor(max(found), "the path tracer's noise") if found else None


def tables(ctx: Context, points: Sequence[Point]) -> list[Table]:
    """What each truth adds, scene by scene, at the default."""
    rows = []
    for point in points:
        if point.knobs["samples"] != 4:
            continue
        name = str(point.knobs["scene"])
        for kind in TRUTHS:
            rows.append([
                short(name), kind, *(f"{point.error[f'{m}_{kind}']:.3g}" for m in ("shown_rmse", "rel_mse", "flip")),
                f"{noise(ctx, name, kind):.2g}",
            ])  # fmt: skip
    return [
        Table(
            "What the lighting leaves out, by truth", ["scene", "truth", "display rmse", "rel. MSE", "FLIP", "noise"],
            rows, "unshadowed: approximations alone. direct: and missing shadows. full: and light between surfaces.",
        )
    ]  # fmt: skip


EXPERIMENT = Experiment(
    title="Lighting against a path tracer",
    method="the forward path: split-sum surroundings, harmonics, lamps without and with extent; 1 to 8 samples a pixel",
    truth="path tracing on embree with the same surface and lights, shadows off: mean of independent halves",
    metric="shown_rmse_unshadowed",
    unit="display value",
    knobs=knobs,
    default={"samples": 4},
    curve="scene",
    problem="scene",
    run=run,
    prepare=prepare,
    needs=frozenset({"gpu", "rays"}),
    own_scene=True,
    timed="gpu",
    noise_floor=noise_floor,
    format_floor=Floor(1.0 / 255.0 / np.sqrt(12.0), "8-bit display"),
    tables=tables,
    time_label="median frame time",
    note="No order is expected: what samples leave is the bias of the approximations. Give your own by --scene FILE.",
)
