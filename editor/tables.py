"""The columns that the editor may change, by table name: how to read them as plain values and write them back.

nodes        translation rotation scale visible name    rows = node rows
             weights (of morph targets) skinning (linear | dual_quaternion)
animation    text drive root_motion                     row 0
lights       fields of LightAsset                        rows = light rows
cameras      yfov znear                                 rows = camera rows
materials    <parameter of the effect>                  rows = material ids
             texture:SLOT (see texture_to_plain, None: nothing in it)  :features  :queue
             several of these joined by commas: one edit, their values in one tuple
objects      SLOT:PARAMETER, of the material in that slot   rows = node rows; None: as the material says
environment  fields of EnvironmentAsset                 row 0
look         fields of LookAsset                        row 0
settings     names of render settings, joined by commas  row 0; of the view, not of the document: never saved
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any, Protocol

import numpy as np

from editor.commands.command import Command
from editor.host import Runtime
from engine.assets.material import QUEUES, TextureRef
from engine.assets.scene_json import check_field
from engine.core.errors import InputError
from engine.math import quat

#: columns of the materials that are no parameters
TEXTURE, FEATURES, QUEUE = "texture:", ":features", ":queue"


class Table(Protocol):
    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]: ...
    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None: ...


def plain(value: Any) -> Any:
    """numpy scalars and arrays as Python numbers and tuples, so that commands compare and print."""
    if isinstance(value, np.ndarray):
        return tuple(plain(v) for v in value.tolist())
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (list, tuple)):
        return tuple(plain(v) for v in value)
    return value


class NodeColumns:
    """Nodes. `local` is (translation, rotation, scale, matrix or None) in one: where the linear part is a matrix that
    no rotation and scale can say, setting a part of it and taking that back must bring the matrix back."""

    def __init__(self, nodes: Any, scene: Any = None) -> None:
        self._nodes, self._scene = nodes, scene

    def own(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> tuple[Any, ...]:
        """`values` of the table without what clips do to these rows now, where they move about places of their own: as
        `write` takes them, wherever time stands."""
        places = getattr(self._scene, "places", None)
        if not places or column not in (*LOCAL_PARTS, "local"):
            return tuple(values)
        found = []
        for row, value in zip(rows, values, strict=True):
            if column == "local":
                parts = [places.own_of(i, row, np.asarray(part, np.float64)) for i, part in enumerate(value[:3])]
                found.append((*map(plain, parts), value[3]) if value[3] is None else value)
            else:
                found.append(plain(places.own_of(LOCAL_PARTS.index(column), row, np.asarray(value, np.float64))))
        return tuple(found)

    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]:
        if column == "local":
            return tuple(self._local(row) for row in rows)
        if column == "weights":
            return tuple(plain(self._scene.morphs.of_node(row)) for row in rows)
        if column == "skinning":
            return tuple(self._scene.skins.method(int(self._scene.skins.of_nodes(np.array([r]))[0])) for r in rows)
        values = getattr(self._nodes, column)
        return tuple(plain(values[row]) for row in rows)

    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None:
        if column == "local":
            for row, (translation, rotation, scale, matrix) in zip(rows, values, strict=True):
                self._nodes.set_trs([row], [translation], [rotation], [scale])
                if matrix is not None:
                    self._nodes.set_matrix(row, np.array(matrix))
                else:
                    self._stand((0, 1, 2), [row])
            return
        if column == "weights":
            for row, value in zip(rows, values, strict=True):
                self._scene.morphs.set_node(row, value)
            return
        if column == "skinning":
            for row, value in zip(rows, values, strict=True):
                self._scene.skins.set_method(int(self._scene.skins.of_nodes(np.array([row]))[0]), value)
            return
        if column == "name":
            for row, value in zip(rows, values, strict=True):
                self._nodes.name[row] = value
            return
        dtype = np.bool_ if column == "visible" else np.float64
        setter = getattr(self._nodes, f"set_{column}")
        setter(np.asarray(rows, dtype=np.int64), np.asarray(values, dtype=dtype))
        if column in LOCAL_PARTS:
            self._stand((LOCAL_PARTS.index(column),), rows)

    def _stand(self, parts: Sequence[int], rows: Sequence[int]) -> None:
        places = getattr(self._scene, "places", None)
        if places:
            for row in rows:
                for part in parts:
                    places.stand(part, int(row))

    def _local(self, row: int) -> tuple[Any, ...]:
        nodes = self._nodes
        matrix = plain(nodes.local_matrix(row)) if nodes.has_matrix[row] else None
        return plain(nodes.translation[row]), plain(nodes.rotation[row]), plain(nodes.scale[row]), matrix


class AnimationTable:
    """The open animation file, row 0: `text` ("" for none), `drive` (clips | timeline | states), and whether
    `root_motion` carries the character."""

    def __init__(self, runtime: Any) -> None:
        self._runtime = runtime

    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]:
        animation = self._runtime.animation
        if column == "text":
            return tuple("" if animation is None else animation.text for _ in rows)
        if column == "drive":
            return tuple(self._runtime.drive for _ in rows)
        return tuple(bool(self._runtime.deck.root_motion) for _ in rows)

    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None:
        for value in values:
            if column == "drive":
                self._runtime.set_drive(value)
            elif column == "root_motion":
                self._runtime.deck.root_motion = bool(value)
                self._runtime.pose_again()
            elif value:
                name = self._runtime.animation.file if self._runtime.animation is not None else "animation"
                # an edit of the text, or its undo, does not change that the clips play
                stands_by = self._runtime.animation is not None and self._runtime.drive == "clips"
                self._runtime.set_animation(value, name, drive="clips" if stands_by else "")
            else:
                self._runtime.set_drive("clips")
                self._runtime.animation = None


class AssetTable:
    """Lights or cameras: a table that gives a row as an asset record and sets its fields by name, checked."""

    def __init__(self, table: Any) -> None:
        self._table = table

    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]:
        return tuple(plain(getattr(self._table.asset(row), column)) for row in rows)

    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None:
        for row, value in zip(rows, values, strict=True):
            before = self._table.asset(row)
            self._table.set(row, **{column: value})
            after = self._table.asset(row)
            names = [f.name for f in fields(before) if f.name != column]
            moved = [n for n in names if getattr(before, n) != getattr(after, n)]
            if moved and column != "type":  # what cannot be together; undo would bring back one of them only
                self._table.set(row, **{f.name: getattr(before, f.name) for f in fields(before)})
                raise InputError(f"{column} {value} does not go with {moved[0]} {getattr(before, moved[0])}")


class RecordTable:
    """One dataclass as a table of a single row 0 (the environment, the look); `a,b` are two fields at once."""

    def __init__(self, record: Any) -> None:
        self._record = record

    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]:
        if "," in column:
            return tuple(tuple(plain(getattr(self._record, name)) for name in column.split(",")) for _ in rows)
        return tuple(plain(getattr(self._record, column)) for _ in rows)

    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None:
        for value in values:
            names = column.split(",")
            for name, part in zip(names, value if len(names) > 1 else (value,), strict=True):
                setattr(self._record, name, part)


class MaterialTable:
    """What a material says, by material id, through the residency, which updates the GPU's rows and draws."""

    def __init__(self, residency: Any) -> None:
        self._residency = residency

    def base_of(self, row: int) -> int:
        """The material that `row` is a variation of, or `row`."""
        return int(getattr(getattr(self._residency, "materials", None), "base_of", int)(row))

    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]:
        if "," in column:
            names = column.split(",")
            return tuple(tuple(self._read(name, row) for name in names) for row in rows)
        return tuple(self._read(column, row) for row in rows)

    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None:
        for row, value in zip(rows, values, strict=True):
            parts = zip(column.split(","), value, strict=True) if "," in column else [(column, value)]
            self._write(row, dict(parts))

    def _read(self, column: str, row: int) -> Any:
        asset = self._residency.material(row).asset
        if column.startswith(TEXTURE):
            return texture_to_plain(asset.textures.get(column.removeprefix(TEXTURE)))
        if column == FEATURES:
            return tuple(asset.features)
        return asset.queue if column == QUEUE else plain(material_values(self._residency, row)[column])

    def _write(self, row: int, values: Mapping[str, Any]) -> None:
        """All of it, or nothing and a LucarnaError."""
        said = {name: value for name, value in values.items() if name in (FEATURES, QUEUE) or name.startswith(TEXTURE)}
        params = {name: value for name, value in values.items() if name not in said}
        if said:
            record = self._residency.material(row)
            asset = copy.deepcopy(getattr(record, "said", record.asset))
            asset.features = list(said.get(FEATURES, asset.features))
            asset.queue = said.get(QUEUE, asset.queue)
            for name, value in said.items():
                if name.startswith(TEXTURE):
                    asset.textures.pop(name.removeprefix(TEXTURE), None)
                    if value is not None:
                        asset.textures[name.removeprefix(TEXTURE)] = texture_from_plain(value)
            asset.params |= params
            self._residency.restate_material(row, asset)
            return
        for param in self._residency.material(row).effect.params if len(params) > 1 else ():
            if param.name in params:
                param.check(params[param.name])
        for name, value in params.items():
            self._residency.set_material_param(row, name, value)


def texture_to_plain(ref: Any) -> tuple[Any, ...] | None:
    """A TextureRef as a tuple of its fields."""
    return None if ref is None else tuple(plain(getattr(ref, name)) for name in type(ref).__slots__)


def texture_from_plain(value: Sequence[Any]) -> TextureRef:
    """The inverse."""
    fields: Any = dict(zip(TextureRef.__slots__, (tuple(v) if isinstance(v, list) else v for v in value), strict=True))
    return TextureRef(**fields)


class ObjectTable:
    """Parameters of materials that are other on one object; None where it says nothing itself."""

    def __init__(self, runtime: Any) -> None:
        self._runtime = runtime

    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]:
        slot, name = object_column(column)
        return tuple(plain(self._runtime.objects.values(row, slot).get(name)) for row in rows)

    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None:
        slot, name = object_column(column)
        for row, value in zip(rows, values, strict=True):
            self._runtime.objects.set(row, slot, {name: value})


def object_column(column: str) -> tuple[int, str]:
    """`0:roughness` -> the slot and the parameter."""
    slot, _, name = column.partition(":")
    return int(slot), name


class SettingsTable:
    """The render settings of the viewport: one column for all that are set together, their values in one tuple."""

    def __init__(self, settings: Callable[[], Any]) -> None:
        self._settings = settings

    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]:
        now = self._settings()
        return (tuple(plain(getattr(now, name)) for name in column.split(",")),)

    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None:
        now = self._settings()
        for name, value in zip(column.split(","), values[0], strict=True):
            setattr(now, name, value)


def material_values(residency: Any, material: int) -> dict[str, Any]:
    """All parameters of a material: what it sets, over its effect's defaults."""
    info = residency.material(material)
    return {p.name: info.asset.params.get(p.name, p.default) for p in info.effect.params}


def tables_of(runtime: Runtime) -> dict[str, Table]:
    """Every editable table of an open runtime."""
    scene = runtime.scene
    return {
        "nodes": NodeColumns(scene.nodes, scene),
        "lights": AssetTable(scene.lights),
        "cameras": AssetTable(scene.cameras),
        "materials": MaterialTable(runtime.residency),
        "environment": RecordTable(scene.environment),
        "look": RecordTable(scene.look),
        **({"objects": ObjectTable(runtime)} if hasattr(runtime, "objects") else {}),
        **({"animation": AnimationTable(runtime)} if hasattr(runtime, "animation") else {}),
    }


#: columns of the nodes that are no fields of a node in a file, and what they may be
LOCAL_PARTS = ("translation", "rotation", "scale")


def check_value(table: str, column: str, value: Any) -> None:
    """Raise InputError where `value` could be set but not saved."""
    value = plain(value)
    if table == "materials":
        _check_said(column, value)
        return
    if table != "nodes" or column not in ("local", "skinning", "weights"):
        check_field(table, column, value)
        return
    if column == "local":
        for name, part in zip(LOCAL_PARTS, value, strict=False):
            check_field("nodes", name, part)
        if value[3] is not None:
            check_field("nodes", "matrix", np.asarray(value[3], np.float64).ravel())
    elif column == "weights":
        check_field("nodes", "weights", value)


def _check_said(column: str, value: Any) -> None:
    """The columns of the materials that are no parameters; those are checked by the effect."""
    texts = isinstance(value, tuple) and all(isinstance(v, str) for v in value)
    if column == FEATURES and not texts:
        raise InputError(f"features: {value!r} are no names")
    if column == QUEUE and value not in QUEUES:
        raise InputError(f"queue: {value!r} is none", hint=f"choose one of {', '.join(QUEUES)}")
    if column.startswith(TEXTURE) and value is not None:
        try:
            usual = TextureRef("")
            given = texture_from_plain(value)
            fields = [(getattr(given, n), getattr(usual, n)) for n in TextureRef.__slots__]
            fits = all(isinstance(a, type(b)) or (type(a), type(b)) == (int, float) for a, b in fields)
        except (TypeError, ValueError):
            fits = False
        if not fits:
            raise InputError(f"{column.removeprefix(TEXTURE)}: {value!r} is no texture")


def _with_unit_rotation(column: str, value: Any) -> Any:
    """As the table keeps it, so that what is saved does not depend on whether it was undone in between."""
    if column == "rotation":
        return quat.normalize(value)
    translation, rotation, scale, matrix = value
    return translation, quat.normalize(rotation), scale, matrix


def make_command(
    tables: Mapping[str, Table], table: str, column: str, rows: Sequence[int], values: Sequence[Any], label: str = ""
) -> Command:
    """The command that sets `column` of `rows` to `values`, with the present values as its `before`.

    Of a material's variation it is the material itself: what one object has to itself is said in the table `objects`,
    and saved there."""
    bases = getattr(tables[table], "base_of", None)
    if bases is not None:
        of_base = {bases(row): value for row, value in zip(rows, values, strict=True)}
        rows, values = list(of_base), list(of_base.values())
    names = column.split(",")
    for value in values:
        for name, part in zip(names, value if len(names) > 1 else (value,), strict=True):
            check_value(table, name, part)
    if table == "nodes" and column in ("rotation", "scale"):
        now = tables[table].read("local", rows)
        if any(local[3] is not None for local in now):  # a matrix that no rotation and scale can say
            place = LOCAL_PARTS.index(column)
            pairs = zip(now, values, strict=True)
            values = [(*part[:place], value, *part[place + 1 : 3], None) for part, value in pairs]
            column = "local"
    before = tables[table].read(column, rows)
    own = getattr(tables[table], "own", None)
    if own is not None:
        before, values = own(column, rows, before), own(column, rows, values)
    if table == "nodes" and column in ("rotation", "local"):
        values = [_with_unit_rotation(column, value) for value in values]
    return Command(table, column, tuple(int(r) for r in rows), before, tuple(plain(v) for v in values), label)
