"""The lines of --explain: which passes and shader variants were left out, why, and what that saved."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Protocol

from engine.framegraph.compiled import CompiledGraph
from engine.framegraph.resources import human_bytes


class VariantLike(Protocol):
    """What is said about a shader variant. `reasons`: why each feature is on; `absent`: feature -> why it is off."""

    @property
    def label(self) -> str: ...
    @property
    def features(self) -> frozenset[str]: ...
    @property
    def reasons(self) -> Mapping[str, str]: ...
    @property
    def absent(self) -> Mapping[str, str]: ...


def explain(graph: CompiledGraph, variants: Iterable[VariantLike] = ()) -> list[str]:
    """Text lines, without line breaks: the passes that run, those left out, then the variants."""
    lines = [
        f"{len(graph.passes)} passes run: {', '.join(item.name for item in graph.passes) or 'none'}",
        f"textures: {human_bytes(graph.transient_bytes)} shared in the frame"
        f" ({human_bytes(graph.unaliased_bytes - graph.transient_bytes)} saved by aliasing)",
    ]
    if graph.left_out:
        saved = sum(left.saved for left in graph.left_out)
        lines.append(f"{len(graph.left_out)} passes left out, {human_bytes(saved)} of textures not written:")
        lines += [f"  {left.name}: {left.reason} (saves {human_bytes(left.saved)})" for left in graph.left_out]
    else:
        lines.append("no pass left out")
    listed = sorted(variants, key=lambda v: (v.label, sorted(v.features)))
    if listed:
        lines.append(f"{len(listed)} shader variants:")
    for variant in listed:
        lines.append(f"  {variant.label}: {', '.join(sorted(variant.features)) or 'no features'}")
        lines += [f"    with {name}: {variant.reasons[name]}" for name in sorted(variant.reasons)]
        lines += [f"    without {name}: {variant.absent[name]}" for name in sorted(variant.absent)]
    return lines
