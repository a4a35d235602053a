"""What of a material an effect can take. The effect may have been edited since the material was written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from engine.assets.material import MaterialAsset
from engine.core.errors import FormatError, InputError, UsageError
from engine.core.toml_source import KeyPath, load_toml
from engine.materials.effect import Effect
from engine.materials.suggest import hint

#: where in the material file, and what is wrong
Complaint = tuple[KeyPath, str]


def fitted(effect: Effect, material: MaterialAsset) -> tuple[MaterialAsset, list[Complaint]]:
    """The material without what the effect does not know or take, and a complaint (with did-you-mean) for each of that.

    The same object when all of it fits."""
    complaints: list[Complaint] = []
    params = {}
    for name, value in material.params.items():
        try:
            effect.param(name).check(value)
            params[name] = value
        except UsageError as error:
            complaints.append((("params", name), str(error)))
    has_no = f"effect {effect.name!r} has no"
    for index, name in enumerate(material.features):
        if name not in effect.features:
            message = f"{has_no} feature {name!r} ({hint(name, effect.features)})"
            complaints.append((("features", index), message))
    for name in material.textures:
        if name not in effect.slot_by_name:
            message = f"{has_no} texture {name!r} ({hint(name, effect.slot_by_name)})"
            complaints.append((("textures", name), message))
    if not complaints:
        return material, complaints
    features = [name for name in material.features if name in effect.features]
    textures = {slot: ref for slot, ref in material.textures.items() if slot in effect.slot_by_name}
    return replace(material, params=params, features=features, textures=textures), complaints


def unfit(path: Path, complaints: list[Complaint]) -> FormatError:
    """The error to raise for a material file that its effect does not take: at the first complaint, with a caret."""
    keypath, message = complaints[0]
    try:
        source = load_toml(path)
    except InputError:
        return FormatError(message, where=path)
    more = "".join(f"\n{source.place(key)}: {text}" for key, text in complaints[1:])
    error = source.error(keypath, message)
    return FormatError(error.message + more, where=error.where) if more else error


def merged(base: MaterialAsset, mine: MaterialAsset, theirs: MaterialAsset) -> MaterialAsset:
    """`theirs` with the parameters that `mine` changed since `base` and `theirs` did not."""
    params = dict(theirs.params)
    for name in {*mine.params, *base.params}:
        changed_here = mine.params.get(name) != base.params.get(name)
        changed_there = theirs.params.get(name) != base.params.get(name)
        if changed_here and not changed_there and name in mine.params:
            params[name] = mine.params[name]
    return replace(theirs, params=params)
