"""MaterialTable: the materials of one effect as rows, in the very bytes that the GPU's storage buffer takes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.material import MaterialAsset, TextureRef
from engine.core.errors import InputError, UsageError
from engine.core.param import Param, Value
from engine.materials.effect import Effect
from engine.materials.features import FeatureSet, resolve_features
from engine.materials.suggest import hint

__all__ = ["FeatureSet", "MaterialTable", "resolve_features", "uv_rows"]


def uv_rows(ref: TextureRef) -> tuple[tuple[float, float, float, float], tuple[float, float, float, float]]:
    """The two rows of uv' = T R S uv, each (a, b, offset, 0).

    KHR_texture_transform: counter-clockwise as seen with v downwards, so u' = c sx u + s sy v, v' = -s sx u + c sy v.
    """
    c, s = math.cos(ref.rotation), math.sin(ref.rotation)
    (sx, sy), (ox, oy) = ref.scale, ref.offset
    return (c * sx, s * sy, ox, 0.0), (-s * sx + 0.0, c * sy, oy, 0.0)


class MaterialTable:
    """Rows of `effect.row_layout`; a row index stays valid. `rev` grows with every change."""

    def __init__(self, effect: Effect) -> None:
        self.effect = effect
        self.rev = 0
        self._count = 0
        self._data: NDArray[np.void] = np.zeros(16, effect.row_layout.dtype)
        self._dirty: tuple[int, int] | None = None
        self._default = self._default_row()

    @property
    def rows(self) -> NDArray[np.void]:
        """The rows, [n] of the layout's dtype, C-contiguous: a view, do not write to it."""
        return self._data[: self._count]

    @property
    def dirty(self) -> tuple[int, int] | None:
        """The rows [first, end) changed since `clean`, or None."""
        return self._dirty

    def clean(self) -> None:
        """The changed rows have been uploaded."""
        self._dirty = None

    def __len__(self) -> int:
        return self._count

    def add(self, material: MaterialAsset, layers: Mapping[str, int]) -> int:
        """Add a row and return its index. `layers`: texture slot -> layer of the array bound for it (absent: 0).

        Raises InputError with all unknown names and bad values of the material.
        """
        return self._append(self._row(material, layers))

    def _append(self, row: Any) -> int:
        if self._count == len(self._data):
            grown = np.zeros(2 * len(self._data), self._data.dtype)
            grown[: self._count] = self._data
            self._data = grown
        self._data[self._count] = row
        self._count += 1
        self._touch(self._count - 1)
        return self._count - 1

    def copy(self, row: int) -> int:
        """Add a row like another and return its index."""
        self._check_row(row)
        return self._append(self._data[row].copy())

    def set_rows(self, rows: NDArray[np.intp], name: str, value: Any) -> None:
        """As `set_param`, of many rows at once."""
        if len(rows):
            self._check_row(int(rows.min()))
            self._check_row(int(rows.max()))
            self._data[name][rows] = self._stored(self.effect.param(name), value)
            self._touch(int(rows.min()))
            self._touch(int(rows.max()))

    def replace(self, row: int, material: MaterialAsset, layers: Mapping[str, int]) -> None:
        """Put another material into a row; see `add`. On an error the row stays as it is."""
        self._check_row(row)
        self._data[row] = self._row(material, layers)
        self._touch(row)

    def _row(self, material: MaterialAsset, layers: Mapping[str, int]) -> Any:
        row = self._default.copy()
        mistakes = []
        for name, value in material.params.items():
            try:
                row[name] = self._stored(self.effect.param(name), value)
            except UsageError as error:
                mistakes.append(str(error))
        for kind, names in (("texture", material.textures), ("layer for the texture", layers)):
            mistakes += [
                f"unknown {kind} {name!r} ({hint(name, self.effect.slot_by_name)})"
                for name in names
                if name not in self.effect.slot_by_name
            ]
        if mistakes:
            raise InputError(f"material {material.name!r}: {'; '.join(mistakes)}")
        for slot in self.effect.textures:
            row[f"{slot.name}_layer"] = layers.get(slot.name, 0)
            self._put_uv(row, slot.name, material.textures.get(slot.name))
        return row

    def set_param(self, row: int, name: str, value: Any) -> None:
        """Raises UsageError for an unknown name (did you mean) or a value out of range; then nothing is changed."""
        self._check_row(row)
        self._data[row][name] = self._stored(self.effect.param(name), value)
        self._touch(row)

    def put_copy(self, source: int, target: int) -> None:
        """Let a row be like another."""
        self._check_row(source)
        self._check_row(target)
        self._data[target] = self._data[source]
        self._touch(target)

    def put_layer(self, row: int, slot: str, layer: int) -> None:
        """Let a slot read another layer; nothing where it does."""
        self._check_row(row)
        if self._data[row][f"{slot}_layer"] != layer:
            self._data[row][f"{slot}_layer"] = layer
            self._touch(row)

    def get_param(self, row: int, name: str) -> Value:
        """The value as the GPU has it (float32). Raises UsageError for an unknown name."""
        self._check_row(row)
        param = self.effect.param(name)
        stored = self._data[row][name]
        if param.type == "enum":
            return param.choices[int(stored)]
        if param.type == "bool":
            return bool(stored)
        return tuple(stored.tolist()) if np.ndim(stored) else stored.item()

    def set_texture(self, row: int, slot: str, ref: TextureRef | None, layer: int) -> None:
        """Put another texture in a slot: its layer, uv set and transform. Raises UsageError for an unknown slot."""
        self._check_row(row)
        if slot not in self.effect.slot_by_name:
            raise UsageError(
                f"effect {self.effect.name!r} has no texture {slot!r}", hint=hint(slot, self.effect.slot_by_name)
            )
        self._data[row][f"{slot}_layer"] = layer
        self._put_uv(self._data[row], slot, ref)
        self._touch(row)

    def migrate(self, effect: Effect) -> MaterialTable:
        """The same rows for a reloaded effect: what both have in equal form is kept, the rest is the default."""
        table = MaterialTable(effect)
        table._count = self._count
        table._data = np.repeat(table._default[None], max(16, len(self._data)))
        old = dict(self.effect.row_layout.dtype.fields or {})
        new = dict(effect.row_layout.dtype.fields or {})
        params = self.effect.param_by_name
        for name in new:
            same = name in old and old[name][0] == new[name][0]
            if same and name in effect.param_by_name:
                same = name in params and _meaning(params[name]) == _meaning(effect.param_by_name[name])
            if same:
                table._data[name][: self._count] = self._data[name][: self._count]
        table.rev = self.rev + 1
        table._dirty = (0, self._count) if self._count else None
        return table

    def _default_row(self) -> NDArray[np.void]:
        row = np.zeros((), self.effect.row_layout.dtype)
        for param in self.effect.params:
            row[param.name] = self._stored(param, param.default)
        for slot in self.effect.textures:
            self._put_uv(row, slot.name, None)
        return row

    @staticmethod
    def _stored(param: Param, value: Any) -> Any:
        """The checked value as the row holds it. Raises UsageError."""
        checked = param.check(value)
        return param.choices.index(str(checked)) if param.type == "enum" else checked

    @staticmethod
    def _put_uv(row: Any, slot: str, ref: TextureRef | None) -> None:
        ref = ref or TextureRef("")
        row[f"{slot}_uv"] = ref.uv_set
        row[f"{slot}_row0"], row[f"{slot}_row1"] = uv_rows(ref)

    def _touch(self, row: int) -> None:
        low, high = self._dirty or (row, row + 1)
        self._dirty = (min(low, row), max(high, row + 1))
        self.rev += 1

    def _check_row(self, row: int) -> None:
        if not 0 <= row < self._count:
            raise UsageError(f"there is no material row {row}; the table has {self._count}")


def _meaning(param: Param) -> tuple[object, ...]:
    """What a stored value depends on: if this changes, old values mean something else or do not fit."""
    return param.type, param.choices, param.min, param.max
