"""The shader variants of an open runtime as rows to show: who wants each, why, what it cost. No imgui."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from engine.core.errors import InputError
from engine.materials.library import EffectLibrary
from engine.materials.variant import Variant


@dataclass(frozen=True, slots=True)
class VariantRow:
    """`reasons`, `absent`: (feature, why it is on, off). `materials`: names of those of the scene that want it."""

    variant: Variant
    label: str
    features: tuple[str, ...]
    materials: tuple[str, ...]
    reasons: tuple[tuple[str, str], ...]
    absent: tuple[tuple[str, str], ...]
    ms: float
    error: str

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
                variant.compile_ms, str(variant.error) if variant.error is not None else "",
            )
        )  # fmt: skip
    return sorted(rows, key=lambda row: (not row.used, row.label, row.features))


def source_lines(library: EffectLibrary, variant: Variant, stage: str) -> list[tuple[str, int, str]]:
    """(file, line, code) of the flattened source of a stage; the error where it cannot be had."""
    try:
        description = library.description(variant)
    except InputError as error:
        return [("<error>", 0, str(error))]
    source = description.vertex if stage == "vertex" else description.fragment
    if source is None:
        return []
    origins = zip(source.lines, source.text.splitlines(), strict=False)
    return [(file, line, code) for (file, line), code in origins]
