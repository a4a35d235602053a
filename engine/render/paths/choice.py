"""Which path a frame takes: the one asked for, or the cheapest by a cost model. Says why."""

from __future__ import annotations

from collections.abc import Callable

from engine.framegraph.passes import Pass
from engine.render.lighting import Choice, Lighting
from engine.render.paths.cost import CostModel
from engine.render.paths.deferred import deferred_passes, tiled_deferred_passes
from engine.render.paths.forward import forward_passes
from engine.render.paths.forward_plus import forward_plus_passes
from engine.render.settings import RenderSettings

#: path -> its passes
PASSES: dict[str, Callable[[], list[Pass]]] = {
    "forward": forward_passes, "deferred": deferred_passes, "tiled-deferred": tiled_deferred_passes,
    "forward-plus": forward_plus_passes,
}  # fmt: skip

#: paths that keep surfaces in a G-buffer
ONE_SAMPLE = ("deferred", "tiled-deferred")

#: views that show the sum of light; all others replace it, and need no other path than forward
LIT_VIEWS = frozenset({"lit", "lighting", "light_tiles"})


def choose(
    settings: RenderSettings, *, local_lights: bool, lights: int, pixels: int, samples: int, model: CostModel,
    force_all: bool = False,
) -> Choice:  # fmt: skip
    """`lights` local ones over `pixels`, with `samples` a pixel.

    Going from path to path leaves the picture as it is. A G-buffer has one sample a pixel, so that with more of them
    Forward+ makes the picture that a deferred path was asked for.
    """
    asked = settings.path
    if settings.shading_view not in LIT_VIEWS:
        return Choice("forward", samples, f"the view {settings.shading_view} shows no sum of lights")
    if settings.shading_view == "light_tiles" and asked in ("auto", "forward"):
        return Choice("forward-plus", samples, "the view shows its light lists")
    if not local_lights and not force_all:
        return Choice("forward", samples, "no local lights: all paths are the same")
    if asked in ONE_SAMPLE and samples > 1:
        why = f"{asked} has one sample a pixel, not {samples}: with samples = 1 it is taken"
        return Choice("forward-plus", samples, why)
    if asked != "auto":
        return Choice(asked, samples, "asked for")
    path, reason = model.cheapest(lights, pixels, samples)
    return Choice(path, samples, reason)


def lighting_of(
    settings: RenderSettings, choice: Choice, gbuffer: int, *, steps: int, forward_only: bool, used: bool
) -> Lighting:
    """The lighting of a frame; the default one where no local light uses it."""
    if not used:
        return Lighting(gbuffer=gbuffer)
    if choice.path == "forward":
        return Lighting(gbuffer=gbuffer, steps=steps)
    return Lighting(
        choice.path, gbuffer, int(settings.light_tile), settings.light_test, settings.light_depth,
        settings.light_form == "three-pass" and choice.path == "deferred",
        forward_only and choice.path in ("deferred", "tiled-deferred"), steps,
    )  # fmt: skip
