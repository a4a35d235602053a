"""The shader variants that a scene uses: which there are, which materials want each and why, what making them took, and
which of their features never change a pixel of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from engine.app.runtime import Runtime
from engine.materials.library import EffectLibrary
from engine.materials.variant import VariantRequest

Description = dict[str, Any]

#: size of the picture that a scene is drawn in to learn its variants
SIZE = (64, 36)


def scene_variants(name: str, scene: Path, *, pixels: bool = False) -> Description:
    """Draw a scene once, on a device of its own, and tell of the variants of effect `name` ('': of all). `pixels`: also
    switch each of their features off and compare the pictures. Raises InputError, DeviceError."""
    from engine.app.headless import render_image
    from engine.gpu import open_device
    from engine.render.view import View
    from importers.opening import open_path

    device = open_device("gl")
    runtime = Runtime(device, profile=False)
    try:
        findings = open_path(runtime, scene)
        render_image(runtime, View(runtime.default_camera(SIZE[0] / SIZE[1]), *SIZE))
        variants = variant_rows(runtime, name)
        described: Description = {
            "scene": str(scene), "variants_compiled": len(variants), "variants": variants,
            "scene_findings": len(findings.items),
        }  # fmt: skip
        return described | (_pixels(runtime, name) if pixels else {})
    finally:
        runtime.close()
        device.release()


def variant_rows(runtime: Runtime, name: str = "") -> list[Description]:
    """The variants of an open runtime that was drawn, of effect `name` ('': of all)."""
    library: EffectLibrary = runtime.residency.effects
    uses = runtime.renderer.variant_uses()
    records = runtime.residency.materials.records
    return [
        {
            "effect": variant.request.effect,
            "role": variant.request.role, "pass": variant.request.index + 1, "level": variant.level,
            "level_reason": variant.level_reason, "features": sorted(variant.features),
            "streams": [a.stream for a in variant.request.attributes],
            "used_by": sorted({records[m].asset.name for m in uses.get(variant.request, [])}),
            "reasons": variant.reasons, "absent": variant.absent,
            "state": state_words(variant.request), "program": variant.source_hash[:12],
            "compile_ms": round(variant.compile_ms, 2), "from_cache": variant.loaded,
            "error": str(variant.error) if variant.error is not None else "",
        }
        for variant in library.variants()
        if name in ("", variant.request.effect)
    ]  # fmt: skip


def state_words(request: VariantRequest) -> list[str]:
    """What beside features and streams makes a variant another one."""
    words = [request.topology] if request.topology != "triangles" else []
    words += ["both faces"] if request.cull == "none" else []
    words += ["mirrored: front faces are clockwise"] if not request.front_ccw else []
    words += ["blended"] if request.depth_write is False else []
    words += [request.fill] if request.fill not in (None, "solid") else []
    return words


def _pixels(runtime: Runtime, name: str) -> Description:
    from engine.app.feature_pixels import idle_features, measured, views_of

    found = measured(runtime, views_of(runtime), name)
    return {
        "feature_pixels": [
            {
                "feature": item.feature, "verdict": item.verdict, "materials": list(item.materials),
                "changed": item.changed, "covered": item.covered, "largest": float(f"{item.largest:.4g}"),
                "effect": item.effect, "of": sorted(item.features), "error": item.error,
            }
            for item in found
        ],
        "never_change_a_pixel": [f"{effect}: {', '.join(names)}" for effect, names in idle_features(found).items()],
    }  # fmt: skip
