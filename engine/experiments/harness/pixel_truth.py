"""Experiments on whole pictures that compare one number per pixel with rays: what those of shadows and light share.

    prepare: truths(ctx, [(scene, key), …], make)   each scene opened, looked at by rays, closed   -> ctx.scratch[key]
    run:     redrawn(ctx, scene, view, judge, …)    a scene of the trial's own, drawn again and again -> Trial
    judge:   brightness / channel of a frame ─► differences(…), paired(…)                          -> Outcome

What made a truth impossible (a scene without such a light, no rays) is kept in its place and raised by each trial that
asks for it, so that the other scenes are measured all the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Outcome, Trial
from engine.experiments.harness.scenes import open_scene
from engine.math.color import to_u1
from engine.render.view import View
from engine.report.records import Floor

if TYPE_CHECKING:
    from engine.experiments.truth.traced_scene import TracedScene
    from engine.render.camera import Camera

F8 = NDArray[np.float64]


def picture_size(ctx: Context) -> tuple[int, int]:
    """Width and height that such experiments look at."""
    return (160, 107) if ctx.quick else (320, 213)


@dataclass(slots=True)
class PixelTruth:
    """`rows` i8[n]: pixels (row by row) that the truth knows; `value` f8[n]: the truth there; `noise`: its rmse;
    `drawn`: pictures f8[h*w] that reading the value out of a picture takes."""

    rows: NDArray[np.int64]
    value: F8
    noise: float
    drawn: Sequence[F8] = ()


def truths(
    ctx: Context, problems: Sequence[tuple[str, str]], doing: str, make: Callable[[OpenScene, str, str], PixelTruth]
) -> Iterator[tuple[float, str]]:
    """Make the truth of each (scene, key) by `make(scene, its name, key)`: an experiment's `prepare`."""
    for i, (name, key) in enumerate(problems):
        yield i / len(problems), f"{doing}, {key}"
        try:
            scene = open_scene(ctx, name)
            try:
                ctx.scratch[key] = make(scene, name, key)
            finally:
                scene.close()
        except LucarnaError as error:
            ctx.scratch[key] = error


def truth(ctx: Context, key: str) -> PixelTruth:
    """What `truths` has made. Raises what made it impossible."""
    found = ctx.scratch[key]
    if isinstance(found, LucarnaError):
        raise found
    assert isinstance(found, PixelTruth), key
    return found


def by_rays(
    ctx: Context, name: str, world: TracedScene, camera: Camera, size: tuple[int, int], key: dict[str, Any],
    rays: Callable[[str], F8],
) -> tuple[F8, float]:  # fmt: skip
    """The mean of two independent sets of rays (`rays("0")`, `rays("1")`) and its rmse, as far as the two tell; from
    the cache where it is there. `key`: what it depends on besides scene, camera and size."""
    from engine.experiments.truth.reference import content_hash

    def make() -> dict[str, Any]:
        first, second = (rays(i) for i in "01")
        return {"first": first, "second": second, "noise_floor": np.sqrt(np.mean((first - second) ** 2)) / 2.0}

    whole = {
        "scene": content_hash(world), "size": size, **key,
        "camera": repr((camera.world_from_camera.tolist(), camera.yfov, camera.ymag)),
    }  # fmt: skip
    found = ctx.references.get(name, whole, make, seed=ctx.seed)
    return (found["first"] + found["second"]) / 2.0, float(found["noise_floor"])


def redrawn(
    ctx: Context, scene: OpenScene, view: View, judge: Callable[[], Outcome],
    change: Callable[[View, bool], None] | None = None,
) -> Trial:  # fmt: skip
    """Times frames of `view`; `change(view, odd)` before each, so that what is kept between frames is made anew."""
    assert ctx.device is not None, "the experiment needs a device"
    device, odd = ctx.device, [False]

    def work() -> None:
        odd[0] = not odd[0]
        if change is not None:
            change(view, odd[0])
        scene.render(view)
        device.finish()

    return Trial(work, lambda _: judge(), gpu=True, close=scene.close)


def radiance(scene: OpenScene, view: View) -> F8:
    """A picture before tone mapping, f8[h*w,3]."""
    hdr = scene.render(view, hdr=True).hdr
    assert hdr is not None, "asked for"
    return np.asarray(hdr.read(), np.float64)[..., :3].reshape(-1, 3)


def brightness(scene: OpenScene, view: View) -> F8:
    """Sum of its channels, f8[h*w]."""
    total: F8 = radiance(scene, view).sum(axis=1)
    return total


def shadow_errors(ours: F8, visible: F8) -> dict[str, float]:
    """Of visibilities f8[n]: rmse; the part of pixels where one says more than half and the other does not; and of
    those that are wrong by more than half."""
    off = ours - visible
    return {
        "rmse": float(np.sqrt(np.mean(off**2))), "misclassified": float(np.mean((ours > 0.5) != (visible > 0.5))),
        "too_dark": float(np.mean(off < -0.5)), "too_light": float(np.mean(off > 0.5)),
    }  # fmt: skip


def greys(size: tuple[int, int], rows: NDArray[np.int64], *values: F8) -> list[NDArray[np.uint8]]:
    """Pictures u1[h,w,3] of values f8[n] in [0, 1] at pixels `rows`; nearly black where there is none."""
    width, height = size
    found = []
    for value in values:
        canvas = np.full(width * height, 0.02)
        canvas[rows] = 0.08 + 0.72 * np.clip(value, 0.0, 1.0)
        found.append(to_u1(np.repeat(canvas.reshape(height, width, 1), 3, axis=2)))
    return found


def worst_noise(ctx: Context) -> Floor | None:
    """The noisiest of the truths: an experiment's `noise_floor`."""
    found = [v.noise for v in ctx.scratch.values() if isinstance(v, PixelTruth) and v.noise > 0.0]
    return Floor(max(found), "the rays' noise") if found else None
