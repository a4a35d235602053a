"""Which features of a scene's variants never change a pixel: each is switched off and the pictures are compared.

    for each set of features in use by an effect:
        the picture without its instances    ──► which pixels it covers at all; none: nothing can be said
        for each of its features: a variant without it stands in, drawn from the same views ──► pixels that differ

Compared are the bits of the scene-linear picture before it is rounded for display. The mesh's streams, the values and
the textures stay as they are. What is found holds for these views and values: a feature that changes nothing here may
elsewhere. One that changes nothing anywhere in a scene costs it a variant for nothing.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.materials.variant import VariantRequest
from engine.render.settings import RenderSettings
from engine.render.view import View

if TYPE_CHECKING:
    from engine.app.runtime import Runtime

SIZE = (160, 90)
#: degrees about the scene, beside its own camera
AZIMUTHS = (35.0, 215.0)

Picture = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class FeatureEffect:
    """What becomes of a variant without `feature`: `changed` of the `covered` pixels, all views together, by `largest`
    at most. `error`: why it cannot be drawn so."""

    effect: str
    features: frozenset[str]
    feature: str
    materials: tuple[str, ...]
    covered: int
    changed: int = 0
    largest: float = 0.0
    error: str = ""

    @property
    def verdict(self) -> str:
        if self.error:
            return "cannot be drawn without it"
        if not self.covered:
            return "not seen"
        return "changes pixels" if self.changed else "never changes a pixel"


def views_of(runtime: Runtime, settings: RenderSettings | None = None, size: tuple[int, int] = SIZE) -> list[View]:
    """The scene's own camera and two that see everything, from either side."""
    settings = settings or RenderSettings(samples=1)
    aspect = size[0] / size[1]
    cameras = [runtime.default_camera(aspect), *(runtime.framing_camera(aspect, azimuth, 15.0) for azimuth in AZIMUTHS)]
    return [View(camera, *size, settings) for camera in cameras]


def feature_effects(
    runtime: Runtime, views: Sequence[View], effect: str = ""
) -> Generator[tuple[float, str], None, list[FeatureEffect]]:
    """Measure; `effect` '': of all effects. Yields (how far 0..1, what comes next) between steps, returns the list.

    The runtime's scene, variants and materials are as before when it ends, or is closed."""
    library, programs = runtime.residency.effects, runtime.renderer.programs
    base = _pictures(runtime, views)
    kept = library.variants()
    groups = _groups(runtime, effect)
    steps, done = sum(1 + len(features) for _, features in groups), 0
    found: list[FeatureEffect] = []
    try:
        for (name, features), materials in groups.items():
            yield done / max(steps, 1), f"{name}: {', '.join(sorted(features)) or 'no features'}"
            done += 1
            names = tuple(sorted({runtime.residency.material(m).asset.name for m in materials}))
            covered = sum(int(m.sum()) for m in _covered(runtime, views, base, materials)) if features else 0
            for feature in sorted(features):
                yield done / steps, f"{name} without {feature}"
                done += 1
                measured = FeatureEffect(name, features, feature, names, covered)
                library.stand_in = lambda request, w=(name, features, feature): _without(request, *w)
                programs.forget()
                errors = set(programs.errors)
                try:
                    seen = _pictures(runtime, views)
                except InputError as error:
                    found.append(replace(measured, error=str(error)))
                    continue
                finally:
                    library.stand_in = None
                wrong = [str(e) for key, e in programs.errors.items() if key not in errors]
                changed, largest = _difference(base, seen)
                found.append(replace(measured, changed=changed, largest=largest, error=wrong[0] if wrong else ""))
    finally:
        library.stand_in = None
        programs.forget()
        library.keep_only(kept)
    return found


def measured(runtime: Runtime, views: Sequence[View], effect: str = "") -> list[FeatureEffect]:
    """`feature_effects` in one go."""
    run = feature_effects(runtime, views, effect)
    while True:
        try:
            next(run)
        except StopIteration as end:
            result: list[FeatureEffect] = end.value
            return result


def idle_features(found: Sequence[FeatureEffect]) -> dict[str, list[str]]:
    """effect -> features that change no pixel in any variant that is seen and has them."""
    idle: dict[str, list[str]] = {}
    for name in dict.fromkeys(item.effect for item in found):
        mine = [item for item in found if item.effect == name and item.covered and not item.error]
        for feature in dict.fromkeys(item.feature for item in mine):
            if not any(item.changed for item in mine if item.feature == feature):
                idle.setdefault(name, []).append(feature)
    return idle


def _groups(runtime: Runtime, effect: str) -> dict[tuple[str, frozenset[str]], list[int]]:
    """(effect, features) of what shades surfaces -> the materials that want it."""
    groups: dict[tuple[str, frozenset[str]], list[int]] = {}
    for request, materials in runtime.renderer.variant_uses().items():
        if request.role in ("forward", "gbuffer") and effect in ("", request.effect):
            mine = groups.setdefault((request.effect, frozenset(request.features)), [])
            mine += [material for material in materials if material not in mine]
    return groups


def _without(request: VariantRequest, effect: str, features: frozenset[str], feature: str) -> VariantRequest:
    """The request without `feature`, where it is of that effect and its features are of that set."""
    if request.effect != effect or feature not in request.features or not request.features <= features:
        return request
    cull = "back" if feature == "double_sided" else request.cull  # what the draw list makes of it
    return replace(request, features=frozenset(request.features) - {feature}, cull=cull)


def _pictures(runtime: Runtime, views: Sequence[View]) -> list[Picture]:
    from engine.app.headless import render_hdr  # here: who only tells what was found needs no renderer

    return [np.array(render_hdr(runtime, view)[0]) for view in views]


def _covered(
    runtime: Runtime, views: Sequence[View], base: Sequence[Picture], materials: Sequence[int]
) -> list[NDArray[np.bool_]]:
    """bool[h,w] per view: what changes when the instances of these materials are hidden."""
    instances = runtime.scene.instances
    rows = np.flatnonzero(np.isin(instances.material, materials) & instances.visible)
    instances.set_visible(rows, False)
    try:
        without = _pictures(runtime, views)
    finally:
        instances.set_visible(rows, True)
    return [_differs(a, b) for a, b in zip(base, without, strict=True)]


def _differs(a: Picture, b: Picture) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = (a.view(np.uint32) != b.view(np.uint32)).any(axis=-1)
    return found


def _difference(base: Sequence[Picture], seen: Sequence[Picture]) -> tuple[int, float]:
    """(pixels that differ in any bit, the largest difference)."""
    changed = sum(int(_differs(a, b).sum()) for a, b in zip(base, seen, strict=True))
    return changed, max((float(np.abs(a - b).max()) for a, b in zip(base, seen, strict=True)), default=0.0)
