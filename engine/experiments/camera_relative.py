"""Far from the origin: float32 world matrices against positions relative to the camera."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.math.projection import perspective_reversed
from engine.math.quat import normalize
from engine.math.transform import compose, inverse_affine, look_at
from engine.render.transforms import origin_near
from engine.report.records import Extreme

F8 = NDArray[np.float64]
F4 = NDArray[np.float32]

DISTANCES = 10.0 ** np.arange(0.0, 8.0)
HEIGHT, YFOV, ZNEAR = 1080.0, 0.9, 0.1
#: of a camera that moves by 10 cm a frame
FRAMES = 30
METHODS = ("grid origin", "camera origin", "combined float64", "world float32")


def scene(ctx: Context, distance: float) -> tuple[F8, F8, F8]:
    """World matrices f8[n,4,4], points in mesh space f8[n,3], and the camera's pose, all about `distance` away."""
    rng = ctx.rng("scene")
    n = 1 << (11 if ctx.quick else 13)
    away = np.array([0.6, 0.1, 0.79]) * distance
    place = rng.uniform(-2.0, 2.0, (n, 3)) + away
    world = compose(place, normalize(rng.normal(size=(n, 4))), np.ones((n, 3)))
    points = rng.uniform(-0.5, 0.5, (n, 3))
    return world, points, look_at(away + np.array([0.3, 0.4, 5.0]), away)


def clip(method: str, world: F8, points: F8, camera: F8) -> F4:
    """Clip positions f4[n,4] as a vertex shader in float32 makes them from what the method uploads."""
    projection = perspective_reversed(YFOV, 16.0 / 9.0, ZNEAR)
    p = np.concatenate([points, np.ones((len(points), 1))], axis=1).astype(np.float32)
    if method == "combined float64":
        combined = (projection @ inverse_affine(camera) @ world).astype(np.float32)
        return np.asarray(np.einsum("nij,nj->ni", combined, p))
    if method == "world float32":
        origin = np.zeros(3)
    else:
        origin = camera[:3, 3] if method == "camera origin" else origin_near(camera[:3, 3], ZNEAR)
    rows = world[:, :3, :].astype(np.float32)
    rows[:, :, 3] = (world[:, :3, 3] - origin).astype(np.float32)
    pose = camera.copy()
    pose[:3, 3] -= origin
    clip_from_origin = (projection @ inverse_affine(pose)).astype(np.float32)
    q = np.einsum("nij,nj->ni", rows, p)
    return np.asarray(np.concatenate([q, p[:, 3:]], axis=1) @ clip_from_origin.T)


def pixels(clip_position: NDArray[np.floating]) -> F8:
    """f8[n,2], pixels of a 1920 x 1080 picture."""
    c = clip_position.astype(np.float64)
    result: F8 = c[:, :2] / c[:, 3:] * np.array([HEIGHT * 16.0 / 9.0, HEIGHT]) / 2.0
    return result


def truth(world: F8, points: F8, camera: F8) -> F8:
    """The same in float64, relative to the camera before anything is multiplied."""
    near = world.copy()
    near[:, :3, 3] -= camera[:3, 3]
    pose = camera.copy()
    pose[:3, 3] = 0.0
    p = np.concatenate([points, np.ones((len(points), 1))], axis=1)
    matrix = perspective_reversed(YFOV, 16.0 / 9.0, ZNEAR) @ inverse_affine(pose)
    return pixels(np.einsum("nij,nj->ni", matrix @ near, p))


def run(ctx: Context, knobs: Knobs) -> Trial:
    method = str(knobs["method"])
    far = ctx.once("far", lambda: scene(ctx, 1e6))

    def judge(_: object) -> Outcome:
        rows = []
        for distance in DISTANCES:
            given = scene(ctx, distance)
            off = np.linalg.norm(pixels(clip(method, *given)) - truth(*given), axis=1)
            rows.append(float(off.max()) if np.isfinite(off).all() else np.inf)
        return Outcome(
            {"max_pixels": rows[6], "pixels_at_origin": rows[0]}, profile=list(zip(DISTANCES, rows, strict=True))
        )

    path = [far[2] + np.array([[0.0] * 3 + [0.1 * i]] + [[0.0] * 4] * 3) for i in range(FRAMES)]
    rows = np.zeros((len(far[0]), 3, 4), np.float32)

    def work() -> None:
        seen: bytes = b""
        for camera in path:
            seen = prepare(method, far[0], camera, rows, seen)

    return Trial(work, judge)


def prepare(method: str, world: F8, camera: F8, rows: F4, seen: bytes) -> bytes:
    """What the CPU does for one frame: fill `rows` f4[n,3,4] where they changed. Returns what they are relative to."""
    if method == "combined float64":
        combined = perspective_reversed(YFOV, 16.0 / 9.0, ZNEAR) @ inverse_affine(camera) @ world
        combined.astype(np.float32)
        return b""
    if method == "world float32":
        origin = np.zeros(3)
    else:
        origin = camera[:3, 3] if method == "camera origin" else origin_near(camera[:3, 3], ZNEAR)
    key = origin.tobytes()
    if key != seen:
        rows[...] = world[:, :3, :]
        np.subtract(world[:, :3, 3], origin, out=rows[:, :, 3], casting="same_kind")
    return key


def extremes(ctx: Context) -> Iterator[Extreme]:
    for distance in (1e6, 1e7):
        given = scene(ctx, distance)
        off = float(np.linalg.norm(pixels(clip("grid origin", *given)) - truth(*given), axis=1).max())
        yield Extreme(f"at {distance:.0e} m, as the renderer does it", f"{off:.2g} pixels", off < 0.02)


EXPERIMENT = Experiment(
    title="Far from the origin",
    method="vertices through float32 matrices: of the world, relative to the camera, relative to a grid point near it"
    " (the renderer's), and combined in float64 for each object",
    truth="the same in float64, made relative to the camera first; error on screen at 1080p, objects 5 m away",
    metric="max_pixels",
    unit="pixels at 10⁶ m",
    knobs=[{"method": m} for m in METHODS],
    default={"method": "grid origin"},
    curve="method",
    run=run,
    orders=[
        Order(
            1.0,
            "float32 resolves a fixed part of the distance",
            "distance",
            point={"method": "world float32"},
            between=(10.0, 1e7),
        ),
        Order(0.0, "nothing depends on the distance", "distance", tolerance=0.15),
    ],
    extremes=extremes,
    profile_label="distance from the world's origin (m)",
    time_label=f"median time of {FRAMES} frames' uploads",
    note="Time is what the CPU prepares for the vertex shader while the camera moves by 3 m: the grid origin fills rows"
    " only when the camera enters another cell, the others in every frame, or never. The grid's error is larger than"
    " that of the camera's own position because the origin is up to a cell away, and still far below a pixel.",
)
