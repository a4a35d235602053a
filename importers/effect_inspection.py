"""What is in an effect: parameters, features, generated blocks, flattened sources, and with a scene its variants: which
are compiled, which materials want each and why, what compiling took."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from engine.app.project import shader_folders
from engine.core.errors import InputError, UsageError
from engine.core.findings import Findings
from engine.core.paths import shaders_dir
from engine.materials.effect import Effect, load_effect
from engine.materials.explain import role_lines, technique_rows
from engine.materials.merge import effect_name
from importers.variant_inspection import scene_variants

Description = dict[str, Any]


def describe_effect(
    path: Path, *, scene: Path | None = None, features: tuple[str, ...] = (), pixels: bool = False
) -> Description:
    """Describe an effect file; `scene`: with the variants that it uses (needs a graphics device), and with `pixels`
    what each of their features changes in its picture; `features`: those of the variant whose sources are shown. Raises
    ShaderError, InputError, UsageError, DeviceError."""
    search = search_of(path)
    effect = load_effect(path, search=search)
    described = _declared(effect)
    described["variants_possible"] = 2 ** len(effect.features) * len(effect.techniques)
    described["generated"] = effect.glsl(frozenset(features)).splitlines()
    described["sources"] = _sources(effect, search, frozenset(features))
    if scene is not None:
        described |= scene_variants(effect_name(path), scene, pixels=pixels)
    elif pixels:
        raise UsageError("--pixels needs a scene to look at", hint="give --scene FILE")
    return described


def search_of(path: Path) -> list[Path]:
    """The folders that an effect file's shaders and what it extends are looked for in."""
    return list(dict.fromkeys([path.absolute().parent.parent, *shader_folders(path.parent), shaders_dir()]))


def effect_findings(path: Path) -> Findings:
    """What `check` and `inspect` say of an effect that is no mistake. Raises ShaderError, InputError."""
    findings = Findings(str(path))
    for message, place in load_effect(path, search=search_of(path)).findings:
        findings.warn("effect.technique", message, str(place))
    return findings


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
                "choices": list(p.choices),
                "group": p.group,
                "order": p.order,
                "when": p.when,
                "doc": p.doc,
            }
            for p in effect.params
        ],
        "textures": [
            {
                "name": s.name,
                "space": s.space,
                "default": s.default,
                "doc": s.doc,
                "sampler": ""
                if s.sampler is None
                else f"{s.sampler.min_filter}, {s.sampler.wrap_u} x {s.sampler.wrap_v}",
            }
            for s in effect.textures
        ],
        "techniques": list(technique_rows(effect)),
        "absent": role_lines([effect]),
        "row_bytes": effect.row_layout.size,
    }


def _finite(value: float) -> float | None:
    """JSON knows no infinity: no limit is null."""
    return value if math.isfinite(value) else None


def _sources(effect: Effect, search: list[Path], features: frozenset[str]) -> Description:
    """stage -> lines `file:line | code` of the first technique."""
    from engine.materials.variant import VariantRequest, describe
    from engine.render.blocks import SCENE_PRELUDE
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
    for source in desc.stages:
        lines = zip(source.lines, source.text.splitlines(), strict=False)
        found[source.stage] = [f"{Path(file).name}:{line} | {code}" for (file, line), code in lines]
    return found
