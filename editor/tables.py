"""The columns that the editor may change, by table name: how to read them as plain values and write them back.

nodes        translation rotation scale visible         rows = node rows
lights       color intensity range inner outer          rows = light rows
cameras      yfov znear                                 rows = camera rows
materials    <parameter of the effect>                  rows = material ids
environment  fields of EnvironmentAsset                 row 0
look         fields of LookAsset                        row 0
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from editor.commands.command import Command
from editor.host import Runtime


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


class ColumnTable:
    """A table whose columns are arrays on one object; `setters` names the columns that have a method of their own."""

    def __init__(self, table: Any, setters: Mapping[str, str] | None = None) -> None:
        self._table = table
        self._setters = setters or {}

    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]:
        values = getattr(self._table, column)
        return tuple(plain(values[row]) for row in rows)

    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None:
        setter = self._setters.get(column)
        if setter is not None:
            current = np.asarray(getattr(self._table, column))
            getattr(self._table, setter)(np.asarray(rows, dtype=np.int64), np.asarray(values, dtype=current.dtype))
            return
        array = getattr(self._table, column)
        for row, value in zip(rows, values, strict=True):
            array[row] = value
        touch = getattr(self._table, "touch", None)
        if touch is not None:
            touch()


class RecordTable:
    """One dataclass as a table of a single row 0 (the environment, the look)."""

    def __init__(self, record: Any) -> None:
        self._record = record

    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]:
        return tuple(plain(getattr(self._record, column)) for _ in rows)

    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None:
        for value in values:
            setattr(self._record, column, value)


class MaterialTable:
    """Material parameters by material id, through the residency, which updates the GPU's rows."""

    def __init__(self, residency: Any) -> None:
        self._residency = residency

    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]:
        return tuple(plain(material_values(self._residency, row)[column]) for row in rows)

    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None:
        for row, value in zip(rows, values, strict=True):
            self._residency.set_material_param(row, column, value)


def material_values(residency: Any, material: int) -> dict[str, Any]:
    """All parameters of a material: what it sets, over its effect's defaults."""
    info = residency.material(material)
    return {p.name: info.asset.params.get(p.name, p.default) for p in info.effect.params}


def tables_of(runtime: Runtime) -> dict[str, Table]:
    """Every editable table of an open runtime."""
    scene = runtime.scene
    return {
        "nodes": ColumnTable(
            scene.nodes,
            {
                "translation": "set_translation",
                "rotation": "set_rotation",
                "scale": "set_scale",
                "visible": "set_visible",
            },
        ),
        "lights": ColumnTable(scene.lights),
        "cameras": ColumnTable(scene.cameras),
        "materials": MaterialTable(runtime.residency),
        "environment": RecordTable(scene.environment),
        "look": RecordTable(scene.look),
    }


def make_command(
    tables: Mapping[str, Table], table: str, column: str, rows: Sequence[int], values: Sequence[Any], label: str = ""
) -> Command:
    """The command that sets `column` of `rows` to `values`, with the present values as its `before`."""
    before = tables[table].read(column, rows)
    return Command(table, column, tuple(int(r) for r in rows), before, tuple(plain(v) for v in values), label)
