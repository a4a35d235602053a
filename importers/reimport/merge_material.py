"""A material of three sides: parameters, textures, features, queue, one by one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from engine.assets.material import MaterialAsset, TextureRef
from importers.reimport.merge import NOTHING, Report, merge_mapping, merge_value, same

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
    sides = [dict.fromkeys(side.features, True) for side in (base, theirs, ours)]
    features = merge_mapping(sides[0], sides[1], sides[2], f"{name}feature ", report)
    merged.features = list(features)
    merged.textures = {slot: _ref(value) for slot, value in merged.textures.items()}
    return merged


def changes(before: MaterialAsset, after: MaterialAsset) -> dict[str, Any]:
    """What to set in the file of `before` so that it says what `after` does, for material_toml.update_material."""
    found: dict[str, Any] = {
        name: getattr(after, name)
        for name in (*WHOLE, "features")
        if not same(getattr(before, name), getattr(after, name))
    }
    for key in dict.fromkeys([*before.params, *after.params]):
        if not same(before.params.get(key, NOTHING), after.params.get(key, NOTHING)):
            found[f"params.{key}"] = after.params.get(key)
    old, new = _plain(before), _plain(after)
    names = [n for n in TextureRef.__slots__ if n != "stated"]
    usual = TextureRef("")
    for slot in dict.fromkeys([*old, *new]):
        if slot not in new:
            found[f"textures.{slot}"] = None
        elif not same(old.get(slot, NOTHING), new[slot]):
            for name, value in zip(names, new[slot], strict=True):
                needed = name == "path" or value != getattr(usual, name)
                found[f"textures.{slot}.{name}"] = value if needed else None
    return found


def _plain(material: MaterialAsset) -> dict[str, Any]:
    return {
        slot: tuple(getattr(ref, n) for n in TextureRef.__slots__ if n != "stated")
        for slot, ref in material.textures.items()
    }


def _ref(value: Any) -> TextureRef:
    names = [n for n in TextureRef.__slots__ if n != "stated"]
    fields: dict[str, Any] = dict(zip(names, value, strict=True))
    return TextureRef(**fields)
