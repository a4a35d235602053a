"""What happens to a picture after everything in it is lit; the same in every path."""

from __future__ import annotations

from engine.framegraph.passes import Pass
from engine.render.extra_passes import EXTRA
from engine.render.passes.auto_exposure import AutoExposurePass
from engine.render.passes.bloom import BloomPass
from engine.render.passes.depth_of_field import DepthOfFieldPass
from engine.render.passes.fxaa import FxaaPass
from engine.render.passes.resolve import ResolvePass
from engine.render.passes.smaa import SmaaPass
from engine.render.passes.taa import TaaPass
from engine.render.passes.tone_map import ToneMapPass


def lens_passes() -> list[Pass]:
    light = [DepthOfFieldPass(), TaaPass(), AutoExposurePass(), BloomPass()]
    filters = [FxaaPass(), SmaaPass()]
    return [*light, ResolvePass(), ToneMapPass(), *filters, *EXTRA.make()]
