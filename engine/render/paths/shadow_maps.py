"""What every path draws first: the sun's shadow maps and those of local lights, their moments and tints."""

from __future__ import annotations

from engine.framegraph.passes import Pass
from engine.render.passes.local_moments import LocalMomentsPass
from engine.render.passes.local_shadows import LocalShadowsPass
from engine.render.passes.local_tints import LocalTintsPass
from engine.render.passes.shadow_cascades import ShadowCascadesPass
from engine.render.passes.shadow_moments import ShadowMomentsPass
from engine.render.passes.shadow_tints import ShadowTintsPass


def shadow_passes() -> list[Pass]:
    return [
        ShadowCascadesPass(), ShadowMomentsPass(), ShadowTintsPass(), LocalShadowsPass(), LocalMomentsPass(),
        LocalTintsPass(),
    ]  # fmt: skip
