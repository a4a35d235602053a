"""What can be done to materials, one or many at once: shared parameters, copying, pasting, resetting. No imgui.

A copy is TOML text as a material file has it, so it can be pasted into one, or into a message:

    roughness = 0.4                      one parameter
    schema = "lucarna.material/1" …      a whole material
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from editor import work
from editor.document import Document
from editor.picture_texture import PICTURES, PictureTexture
from editor.tables import FEATURES, QUEUE, TEXTURE, material_values, plain, texture_to_plain
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.material_parent import SUFFIX
from engine.assets.material_toml import SCHEMA, format_material, parse_material, read_material
from engine.core.atomic import write_text
from engine.core.errors import InputError, LucarnaError
from engine.core.param import Param

if TYPE_CHECKING:
    from editor.session import Session


#: of more materials than this only so many are looked at to say whether they differ; all are edited
MOST_COMPARED = 200


@dataclass(frozen=True, slots=True)
class Shared:
    """A parameter that several materials have: `values[i]` is that of the i-th."""

    param: Param
    values: tuple[Any, ...]

    @property
    def mixed(self) -> bool:
        return any(value != self.values[0] for value in self.values[1:])

    @property
    def changed(self) -> bool:
        """Whether one of them is not the default."""
        return any(plain(value) != plain(self.param.default) for value in self.values)


def materials_of(document: Document, rows: Iterable[int]) -> list[int]:
    """The materials of these nodes, each once, in the order of the drawn parts; of what is varied on an object, the
    material itself."""
    instances = document.runtime.scene.instances
    wanted = np.isin(np.asarray(instances.node), np.array(list(rows), np.int64))
    base_of = getattr(getattr(document.runtime.residency, "materials", None), "base_of", int)
    return list(dict.fromkeys(base_of(m) for m in np.asarray(instances.material)[wanted].tolist()))


def shared_params(residency: Any, materials: Sequence[int]) -> list[Shared]:
    """The parameters that all of `materials` declare alike (name, type, choices), as the first's effect orders them."""
    inherited = parent_values(residency, materials[0]) if len(materials) == 1 else {}
    materials = materials[:MOST_COMPARED]
    effects = [residency.material(m).effect for m in materials]
    values = [material_values(residency, m) for m in materials]
    found = []
    for param in effects[0].params:
        others = [next((p for p in effect.params if p.name == param.name), None) for effect in effects[1:]]
        if all(o is not None and (o.type, o.choices) == (param.type, param.choices) for o in others):
            narrow = replace(
                param,
                default=inherited.get(param.name, param.default),
                min=max([param.min, *(o.min for o in others if o is not None)]),
                max=min([param.max, *(o.max for o in others if o is not None)]),
            )
            found.append(Shared(narrow, tuple(plain(v[param.name]) for v in values)))
    return found


#: (material file, the residency's revision) -> what its parent says
_PARENTS: dict[tuple[str, int], dict[str, Any]] = {}


def parent_values(residency: Any, material: int) -> dict[str, Any]:
    """What a material would be without its own parameters: those of its parent; nothing where it has none."""
    record = residency.material(material)
    parent = getattr(record.asset, "parent", "")
    if not parent or not record.path:
        return {}
    from engine.materials.fit import fitted, in_numbers

    key = (str(record.path), int(residency.structure_rev))
    if key not in _PARENTS:
        _PARENTS.clear()  # one is enough: that of the material in the inspector
        try:
            said = read_material(Path(record.path).parent / parent)
            _PARENTS[key] = dict(fitted(record.effect, in_numbers(record.effect, said))[0].params)
        except LucarnaError:
            _PARENTS[key] = {}  # the watcher says what is wrong with it
    return _PARENTS[key]


# --- edits: each is one entry of the history ---


def set_param(session: Session, materials: Sequence[int], name: str, value: Any) -> None:
    """All of them get `value`; what a drag sets is one entry."""
    key = ("materials", name, tuple(materials))
    session.edit(
        "materials", name, materials, [value] * len(materials), gesture=key, label=label_of(session, materials, name)
    )


def set_parts(session: Session, materials: Sequence[int], new: Mapping[str, Any], label: str) -> None:
    """Set several columns (see editor.tables) of all of `materials` as one entry."""
    columns = ",".join(new)
    value = tuple(new.values()) if len(new) > 1 else next(iter(new.values()), None)
    if new:
        session.edit("materials", columns, materials, [value] * len(materials), label=label)


def reset(session: Session, materials: Sequence[int], names: Sequence[str] = ()) -> None:
    """Parameters back to their defaults: `names`, or all that all of them share."""
    document = session.document
    if document is None:
        return
    shared = shared_params(document.runtime.residency, materials)
    new = {s.param.name: plain(s.param.default) for s in shared if s.changed and (not names or s.param.name in names)}
    set_parts(session, materials, new, f"Reset {label_of(session, materials, names[0] if len(names) == 1 else '')}")


def copy_text(session: Session, material: int, name: str = "") -> str:
    """A material, or one parameter of it, as text for the clipboard."""
    assert session.document is not None
    residency = session.document.runtime.residency
    record = residency.material(material)
    if name:
        text = format_material(MaterialAsset("", params={name: material_values(residency, material)[name]}))
        return text.split("[params]\n")[1]
    asset = replace(record.asset, params=material_values(residency, material), textures=dict(record.asset.textures))
    folder = Path(getattr(record, "folder", Path()))
    for slot, ref in asset.textures.items():  # the material that it is pasted into may lie elsewhere
        if ref.path:
            asset.textures[slot] = replace(ref, path=(folder / ref.path).as_posix())
    return format_material(asset)


def paste(session: Session, materials: Sequence[int], text: str) -> None:
    """Take over what `text` (see copy_text) says and the materials' effects know; a word on what they do not."""
    document = session.document
    if document is None:
        return
    try:
        said = read_copy(text)
    except LucarnaError as error:
        session.ui.notice = f"The clipboard holds no material: {error.message}"
        return
    effect = document.runtime.residency.material(materials[0]).effect
    known = {s.param.name: s.param for s in shared_params(document.runtime.residency, materials)}
    new: dict[str, Any] = {}
    left = []
    for name, value in said.params.items():
        try:
            new[name] = plain(known[name].check(value))
        except (KeyError, LucarnaError):
            left.append(name)
    if said.name or said.textures or said.features:  # a whole material, not one parameter
        slots = {slot.name for slot in effect.textures}
        left += [slot for slot in said.textures if slot not in slots]
        for slot in slots:
            new[f"{TEXTURE}{slot}"] = texture_to_plain(said.textures.get(slot))
        features = getattr(effect, "features", {})
        left += [name for name in said.features if name not in features]
        new[FEATURES] = tuple(name for name in said.features if name in features)
        new[QUEUE] = said.queue
    what = next(iter(said.params)) if len(said.params) == 1 and not said.name else ""
    set_parts(session, materials, new, f"Paste {label_of(session, materials, what)}")
    if left:
        session.ui.notice = f"Not taken by effect {effect.name}: {', '.join(left)}"


def read_copy(text: str) -> MaterialAsset:
    """What the text of a copy says; one with an empty name is parameters alone. Raises InputError, FormatError."""
    if "schema" in text:
        return parse_material(text, "clipboard")
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(str(error)) from error
    data = data.get("params", data)
    if not data or not all(isinstance(v, (bool, int, float, str, list)) for v in data.values()):
        raise InputError("it is no parameter")
    return MaterialAsset("", params={k: tuple(v) if isinstance(v, list) else v for k, v in data.items()})


def set_texture(session: Session, materials: Sequence[int], slot: str, path: Path | None) -> None:
    """Put a texture file (.dds) into a slot, sampled as the one before it was; None empties it. Of a picture a texture
    is made first, which takes its time."""
    document = session.document
    if document is None:
        return
    if path is not None and path.suffix.lower() in PICTURES:
        record = document.runtime.residency.material(materials[0])
        space = next((s.space for s in record.effect.textures if s.name == slot), "linear")
        work.start(session, PictureTexture(path, list(materials), slot, space, Path(record.folder)))
        return
    if path is not None and path.suffix.lower() != ".dds":
        session.ui.notice = f"{path.name} is no picture or texture"
        return
    values = []
    for material in materials:
        old = document.runtime.residency.material(material).asset.textures.get(slot)
        new = None if path is None else replace(old or TextureRef(""), path=path.resolve().as_posix())
        values.append(texture_to_plain(new))
    verb = "Set" if path is not None else "Empty"
    what = label_of(session, materials, slot.removesuffix("_map"))
    session.edit("materials", f"{TEXTURE}{slot}", materials, values, label=f"{verb} {what[:1].lower()}{what[1:]}")


def derive(path: Path) -> Path:
    """A new material file beside `path` that inherits all of it; returns its path. Raises OutputError."""
    stem = path.name.removesuffix(SUFFIX)
    number = next(n for n in range(1, 10_000) if not (path.parent / f"{stem}.{n}{SUFFIX}").exists())
    child = path.parent / f"{stem}.{number}{SUFFIX}"
    lines = [f'schema = "{SCHEMA}"', f"name = {json.dumps(f'{stem} {number}')}", f"parent = {json.dumps(path.name)}"]
    write_text(child, "\n".join([*lines, "", "# what is not said here is as in the parent", "[params]", ""]))
    return child


def label_of(session: Session, materials: Sequence[int], name: str = "") -> str:
    """`Roughness of paint`, `Roughness of 3 materials`, `paint`."""
    assert session.document is not None
    if len(materials) == 1:
        whose = session.document.runtime.residency.material(materials[0]).asset.name or f"material {materials[0]}"
    else:
        whose = f"{len(materials)} materials"
    words = name.replace("_", " ")
    return f"{words[:1].upper()}{words[1:]} of {whose}" if name else whose
