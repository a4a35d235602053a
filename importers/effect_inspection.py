"""What is in an effect: parameters, features, generated blocks, flattened sources, and with a scene its variants: which
are compiled, which materials want each and why, what compiling took."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from engine.app.project import shader_folders
from engine.core.errors import InputError, UsageError
from engine.core.paths import shaders_dir
from engine.materials.effect import Effect, load_effect
from engine.materials.library import EffectLibrary
from engine.materials.merge import effect_name

Description = dict[str, Any]

#: size of the picture that a scene is drawn in to learn its variants
SIZE = (64, 36)


def describe_effect(path: Path, *, scene: Path | None = None, features: tuple[str, ...] = ()) -> Description:
    """Describe an effect file; `scene`: with the variants that it uses (needs a graphics device); `features`: those of
    the variant whose sources are shown. Raises ShaderError, InputError, UsageError, DeviceError."""
    search = list(dict.fromkeys([path.absolute().parent.parent, *shader_folders(path.parent), shaders_dir()]))
    effect = load_effect(path, search=search)
    described = _declared(effect)
    described["variants_possible"] = 2 ** len(effect.features) * len(effect.techniques)
    described["generated"] = effect.glsl(frozenset(features)).splitlines()
    described["sources"] = _sources(effect, search, frozenset(features))
    if scene is not None:
        described |= _variants(effect_name(path), scene)
    return described


def _declared(effect: Effect) -> Description:
    return {
        "name": effect.name,
        "doc": effect.doc,
        "files": [str(file) for file in effect.files],
        "features": [
            {"name": f.name, "implied_by": f.implied_by, "needs": list(f.needs), "doc": f.doc}
            for f in effect.features.values()
        ],
        "params": [
            {
                "name": p.name,
                "type": p.type,
                "default": p.default,
                "min": _finite(p.min),
                "max": _finite(p.max),
                "unit": p.unit,
            }
            for p in effect.params
        ],
        "textures": [{"name": s.name, "space": s.space, "default": s.default} for s in effect.textures],
        "techniques": [
            {"role": t.role, "vertex": t.vertex, "fragment": t.fragment, "level": t.level, "blend": t.blend}
            for t in effect.techniques.values()
        ],
        "row_bytes": effect.row_layout.size,
    }


def _finite(value: float) -> float | None:
    """JSON knows no infinity: no limit is null."""
    return value if math.isfinite(value) else None


def _sources(effect: Effect, search: list[Path], features: frozenset[str]) -> Description:
    """stage -> lines `file:line | code` of the first technique."""
    from engine.materials.variant import VariantRequest, describe
    from engine.render.programs import SCENE_PRELUDE
    from engine.resources.arena import OBJECT_ATTRIBUTE

    if not effect.techniques:
        return {}
    try:
        effect.check_features(features)
    except InputError as error:
        raise UsageError(error.message, hint=error.hint) from error
    role = next(iter(effect.techniques))
    request = VariantRequest(effect.name, role, features, (OBJECT_ATTRIBUTE,), prelude=SCENE_PRELUDE)
    desc = describe(effect, request, search)
    found: Description = {}
    for source in (desc.vertex, desc.fragment):
        if source is not None:
            lines = zip(source.lines, source.text.splitlines(), strict=False)
            found[source.stage] = [f"{Path(file).name}:{line} | {code}" for (file, line), code in lines]
    return found


def _variants(name: str, scene: Path) -> Description:
    """Draw the scene once and tell of the variants of effect `name`."""
    from engine.app.headless import render_image
    from engine.app.runtime import Runtime
    from engine.gpu import open_device
    from engine.render.view import View
    from importers.opening import open_path

    device = open_device("gl")
    runtime = Runtime(device, profile=False)
    try:
        findings = open_path(runtime, scene)
        aspect = SIZE[0] / SIZE[1]
        render_image(runtime, View(runtime.default_camera(aspect), *SIZE))
        library: EffectLibrary = runtime.residency.effects
        uses = runtime.renderer.variant_uses()
        records = runtime.residency.materials.records
        variants = []
        for variant in library.variants():
            if variant.request.effect == name:
                materials = sorted({records[m].asset.name for m in uses.get(variant.request, [])})
                variants.append(
                    {
                        "role": variant.request.role, "features": sorted(variant.features),
                        "streams": [a.stream for a in variant.request.attributes],
                        "used_by": materials, "reasons": variant.reasons, "absent": variant.absent,
                        "compile_ms": round(variant.compile_ms, 2),
                        "error": str(variant.error) if variant.error is not None else "",
                    }
                )  # fmt: skip
        return {
            "scene": str(scene), "variants_compiled": len(variants), "variants": variants,
            "scene_findings": len(findings.items),
        }  # fmt: skip
    finally:
        runtime.close()
        device.release()
