"""Light of the surroundings under ambient occlusion, against a path tracer: does what it does bring the picture nearer?

Ambient occlusion (`ao`) is judged by the visibility that it estimates. Here it is judged by what it is for: the light
that surroundings send to surfaces which stand in each other's way, with what these send on (bounces), and from where it
comes (bent normals). The truth has all light from surface to surface, so what lamps' light does on its second surface
stays as an error in every row; global illumination (`gi`) is for that.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError
from engine.experiments.harness.context import Context, OpenScene
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.pictures import beside_truth
from engine.experiments.harness.pixel_truth import redrawn
from engine.experiments.harness.scenes import MADE, open_scene, own_or, short
from engine.experiments.picture_lights import bytes_of, settings, shown, size, traced_truths
from engine.experiments.picture_lights import noise as film_noise
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.metrics import rmse
from engine.report.perceptual import flip
from engine.report.records import Floor

SCENES = (MADE + "court", MADE + "nave")
TRUTH = "full"
#: name -> what is set
VARIANTS: dict[str, dict[str, Any]] = {
    "off": {"ambient_occlusion": "off"},
    "dims": {"ambient_occlusion": "gtao", "ao_bent": False, "ao_bounces": False},
    "bent": {"ambient_occlusion": "gtao", "ao_bent": True, "ao_bounces": False},
    "bounces": {"ambient_occlusion": "gtao", "ao_bent": False, "ao_bounces": True},
    "bent, bounces": {"ambient_occlusion": "gtao", "ao_bent": True, "ao_bounces": True},
}
#: of the radius that the scene's size suggests
RADII = (1.0, 4.0, 16.0)


def scenes(ctx: Context) -> list[str]:
    return own_or(ctx, SCENES[:1] if ctx.quick else SCENES)


def knobs(ctx: Context) -> list[dict[str, Any]]:
    return [
        {"scene": scene, "variant": variant, "radius": radius}
        for scene in scenes(ctx) for variant in VARIANTS for radius in (RADII if variant != "off" else RADII[:1])
    ]  # fmt: skip


def prepare(ctx: Context) -> Generator[tuple[float, str], None, None]:
    yield from traced_truths(ctx, scenes(ctx), (TRUTH,))


def view(ctx: Context, scene: OpenScene, chosen: Knobs) -> View:
    from engine.render.occlusion import radius_of

    width, height, _ = size(ctx)
    own = radius_of(RenderSettings(), *scene.scene.bounds())
    values = {**VARIANTS[str(chosen["variant"])], "ao_radius": own * float(chosen["radius"])}
    return View(scene.camera(width / height), width, height, settings(1, **values))


def run(ctx: Context, chosen: Knobs) -> Trial:
    name = str(chosen["scene"])
    if isinstance(ctx.scratch.get(name), LucarnaError):
        raise ctx.scratch[name]
    scene = open_scene(ctx, name)
    return redrawn(ctx, scene, view(ctx, scene, chosen), lambda: judge(ctx, scene, chosen))


def judge(ctx: Context, scene: OpenScene, chosen: Knobs) -> Outcome:
    hdr = scene.render(view(ctx, scene, chosen), hdr=True).hdr
    assert hdr is not None, "asked for"
    ours: NDArray[np.float64] = np.asarray(hdr.read(), np.float64)[..., :3]
    true = ctx.scratch[chosen["scene"], TRUTH].mean
    error = {
        "shown_rmse": rmse(shown(ours), shown(true)), "bias": float(np.mean(shown(ours) - shown(true))),
        "flip": flip(shown(ours), shown(true))[0],
    }  # fmt: skip
    pictures = []
    if chosen["radius"] == RADII[0] and chosen["variant"] in ("off", EXPERIMENT.default["variant"]):
        label = f"{short(str(chosen['scene']))}: {chosen['variant']}"
        pictures = beside_truth(ctx, label, bytes_of(ours), "path traced", bytes_of(true))
    return Outcome(error, pictures=pictures)


def noise_floor(ctx: Context) -> Floor | None:
    found = [film_noise(ctx, name, TRUTH) for name in scenes(ctx) if (name, TRUTH) in ctx.scratch]
    return Floor(max(found), "the path tracer's noise") if found else None


EXPERIMENT = Experiment(
    title="Light of the surroundings under ambient occlusion",
    method="ambient occlusion by default (gtao), dimming alone; with bounces; with bent normals; by its radius",
    truth="path tracing with all light from surface to surface",
    metric="shown_rmse",
    unit="of the display's range",
    knobs=knobs,
    default={"variant": "bent", "radius": 1.0},
    curve="variant",
    problem="scene",
    run=run,
    prepare=prepare,
    needs=frozenset({"gpu", "rays"}),
    own_scene=True,
    timed="gpu",
    noise_floor=noise_floor,
    advisory=True,
    time_label="median frame time",
    note="Bounces brighten what the fall-off leaves too bright already: they pay in white places with a large radius.",
)  # fmt: skip
