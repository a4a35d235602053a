"""A material of three sides: parameters, textures, features, queue, one by one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from engine.assets.material import MaterialAsset, TextureRef
from importers.reimport.merge import Report, merge_mapping, merge_value

WHOLE = ("effect", "queue", "level", "parent")


def merge_material(base: MaterialAsset, theirs: MaterialAsset, ours: MaterialAsset, report: Report) -> MaterialAsset:
    """The material that `ours` becomes; texture paths are as each side's folder has them."""
    name = f"material {ours.name}: "
    merged = replace(
        ours,
        **{f: merge_value(getattr(base, f), getattr(theirs, f), getattr(ours, f), name + f, report) for f in WHOLE},
        params=merge_mapping(base.params, theirs.params, ours.params, name, report),
        textures=merge_mapping(_plain(base), _plain(theirs), _plain(ours), name, report),
        extensions=merge_mapping(base.extensions, theirs.extensions, ours.extensions, f"{name}extension ", report),
        features=[],
    )
    features: dict[str, Any] = merge_mapping(
        *(dict.fromkeys(side.features, True) for side in (base, theirs, ours)), f"{name}feature ", report
    )
    merged.features = list(features)
    merged.textures = {slot: _ref(value) for slot, value in merged.textures.items()}
    return merged


def _plain(material: MaterialAsset) -> dict[str, Any]:
    return {
        slot: tuple(getattr(ref, n) for n in TextureRef.__slots__ if n != "stated")
        for slot, ref in material.textures.items()
    }


def _ref(value: Any) -> TextureRef:
    names = [n for n in TextureRef.__slots__ if n != "stated"]
    fields: dict[str, Any] = dict(zip(names, value, strict=True))
    return TextureRef(**fields)
