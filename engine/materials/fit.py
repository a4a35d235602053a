"""What of a material an effect can take. The effect may have been edited since the material was written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from engine.assets.material import MaterialAsset
from engine.assets.material_parent import load_chain
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
    material = in_numbers(effect, material)
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


def in_numbers(effect: Effect, material: MaterialAsset) -> MaterialAsset:
    """The material with colours that are written as words in linear numbers; the same object when there are none. What
    is no colour stays: `fitted` complains of it."""
    numbers = {}
    for name, value in material.params.items():
        param = effect.param_by_name.get(name)
        short = isinstance(value, (tuple, list)) and len(value) == 3
        if param is not None and param.type in ("color3", "color4") and (isinstance(value, str) or short):
            try:
                numbers[name] = param.check(value)
            except UsageError:
                continue
    changed = {name: value for name, value in numbers.items() if value != material.params[name]}
    return replace(material, params={**material.params, **changed}) if changed else material


def unfit(path: Path, complaints: list[Complaint]) -> FormatError:
    """The error to raise for a material file that its effect does not take: at the first complaint, with a caret."""
    keypath, message = complaints[0]
    try:
        source = load_chain(load_toml(path), path).locate(keypath)[0]
    except InputError:
        return FormatError(message, where=path)
    more = "".join(f"\n{source.place(key)}: {text}" for key, text in complaints[1:])
    error = source.error(keypath, message)
    return FormatError(error.message + more, where=error.where) if more else error


def merged(base: MaterialAsset, mine: MaterialAsset, theirs: MaterialAsset) -> MaterialAsset:
    """`theirs` with what `mine` changed since `base` and `theirs` did not: parameters, textures, features, queue."""
    params, textures = dict(theirs.params), dict(theirs.textures)
    for name in {*mine.params, *base.params}:
        changed_here = mine.params.get(name) != base.params.get(name)
        changed_there = theirs.params.get(name) != base.params.get(name)
        if changed_here and not changed_there:
            params.pop(name, None)
            if name in mine.params:
                params[name] = mine.params[name]
    for slot in {*mine.textures, *base.textures}:
        here, before, there = mine.textures.get(slot), base.textures.get(slot), theirs.textures.get(slot)
        if here != before and there == before:
            textures.pop(slot, None)
            if here is not None:
                textures[slot] = here
    features = mine.features if theirs.features == base.features else theirs.features
    queue = mine.queue if theirs.queue == base.queue else theirs.queue
    return replace(theirs, params=params, textures=textures, features=list(features), queue=queue)
