"""The shader variants of an open runtime as rows to show: who wants each, why, what it cost. No imgui."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from engine.core.errors import InputError
from engine.materials.library import EffectLibrary
from engine.materials.variant import Variant


@dataclass(frozen=True, slots=True)
class VariantRow:
    """`reasons`, `absent`: (feature, why it is on, off). `materials`: names of those of the scene that want it.
    `loaded`: it was not compiled but taken from the program cache."""

    variant: Variant
    label: str
    features: tuple[str, ...]
    materials: tuple[str, ...]
    reasons: tuple[tuple[str, str], ...]
    absent: tuple[tuple[str, str], ...]
    ms: float
    error: str
    loaded: bool = False

    @property
    def used(self) -> bool:
        return bool(self.materials)


def variant_rows(runtime: Any) -> list[VariantRow]:
    """All variants, those in use first."""
    records = runtime.residency.materials.records
    uses = runtime.renderer.variant_uses()
    rows = []
    for variant in runtime.residency.effects.variants():
        wanted = uses.get(variant.request, [])
        rows.append(
            VariantRow(
                variant, variant.label, tuple(sorted(variant.features)),
                tuple(dict.fromkeys(records[m].asset.name or f"material {m}" for m in wanted)),
                tuple(sorted(variant.reasons.items())), tuple(sorted(variant.absent.items())),
                variant.compile_ms, str(variant.error) if variant.error is not None else "", variant.loaded,
            )
        )  # fmt: skip
    return sorted(rows, key=lambda row: (not row.used, row.label, row.features))


def stages_of(library: EffectLibrary, variant: Variant) -> list[str]:
    """The stages of a variant; none where its source cannot be had."""
    try:
        return [source.stage for source in library.description(variant).stages]
    except InputError:
        return []


def source_lines(library: EffectLibrary, variant: Variant, stage: str) -> list[tuple[str, int, str]]:
    """(file, line, code) of the flattened source of a stage, or of what is `generated`; the error where it cannot be
    had."""
    try:
        if stage == "generated":
            text = library.get(variant.request.effect).glsl(variant.features)
            return [("<generated>", number, code) for number, code in enumerate(text.splitlines(), 1)]
        sources = {source.stage: source for source in library.description(variant).stages}
    except InputError as error:
        return [("<error>", 0, str(error))]
    if stage not in sources:
        return []
    source = sources[stage]
    origins = zip(source.lines, source.text.splitlines(), strict=False)
    return [(file, line, code) for (file, line), code in origins]
