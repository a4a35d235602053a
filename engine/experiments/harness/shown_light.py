"""Light judged as it is shown: what experiments on light between surfaces and on mirrors share.

Pictures are exposed for the truth, so that its mean is a middle tone: one highlight would be all of a linear error.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Outcome
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.scenes import open_scene
from engine.math.color import linear_to_srgb, to_u1
from engine.render.settings import RenderSettings
from engine.report.metrics import rel_mse, rmse
from engine.report.perceptual import flip
from engine.report.records import Floor

F8 = NDArray[np.float64]

#: what the mean of the truth is shown as
MIDDLE = 0.25


def traced_pictures(
    ctx: Context, wanted: Mapping[Any, tuple[str, str, int]], size: tuple[int, int, int],
    settings: Callable[[OpenScene, Any], RenderSettings],
) -> Generator[tuple[float, str], None, None]:  # fmt: skip
    """Path trace pictures into ctx.scratch: key -> (scene, name in the cache, surfaces that a path may meet); `size`:
    width, height, paths for each pixel. What makes one impossible is kept in its place."""
    from engine.experiments.truth import reference
    from engine.experiments.truth.path_tracer import Settings
    from engine.experiments.truth.traced_scene import traced

    width, height, paths = size
    for i, (key, (name, label, surfaces)) in enumerate(wanted.items()):
        try:
            scene = open_scene(ctx, name)
        except LucarnaError as error:
            ctx.scratch[key] = error
            continue
        try:
            world, camera = traced(scene, settings(scene, key)), scene.camera(width / height)
            steps = reference.picture(
                ctx, label, world, camera, width, height, Settings(paths, surfaces, seed=ctx.seed)
            )
            ctx.scratch[key] = yield from _part(steps, i, len(wanted))
        except LucarnaError as error:
            ctx.scratch[key] = error
        finally:
            scene.close()


def _part(
    steps: Generator[tuple[float, str], None, Any], i: int, count: int
) -> Generator[tuple[float, str], None, Any]:
    while True:
        try:
            done, text = next(steps)
        except StopIteration as stop:
            return stop.value
        yield (i + done) / count, text


def judge_picture(ctx: Context, ours: F8, truth: F8, label: str) -> Outcome:
    """Errors of linear light beside `truth` f8[h,w,3]; pictures of both where there is a `label`."""
    ours = ours.reshape(truth.shape)
    scale = MIDDLE / max(float(truth.mean()), 1e-12)
    display = [linear_to_srgb(np.clip(p * scale, 0.0, 1.0)) for p in (ours, truth)]
    shown = [to_u1(p) for p in display]
    error = {
        "shown_rmse": rmse(*display), "rmse": rmse(ours, truth), "rel_mse": rel_mse(ours, truth),
        "bias": float(np.mean(ours - truth)), "energy": float(ours.mean() / max(truth.mean(), 1e-12)),
        "flip": flip(*shown)[0],
    }  # fmt: skip
    return Outcome(error, pictures=beside_truth(ctx, label, shown[0], "path traced", shown[1]) if label else [])


def shown_floor(ctx: Context) -> Floor | None:
    """Of the films that are kept in the scratch, as shown."""
    found = []
    for film in ctx.scratch.values():
        if hasattr(film, "halves"):
            scale = MIDDLE / max(float(film.mean.mean()), 1e-12)
            first, second = (linear_to_srgb(np.clip(half * scale, 0.0, 1.0)) for half in film.halves)
            found.append(rmse(first, second) / 2.0)
    return Floor(max(found), "the path tracer's noise") if found else None
