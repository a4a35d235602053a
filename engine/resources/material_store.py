"""MaterialStore: a row per material in its effect's table, the texture arrays it reads, its queue.

A draw's *texture group* is the (array, sampler) per slot of its effect; materials that share a group draw together and
differ only in their rows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.material import SAMPLING, MaterialAsset, TextureRef
from engine.core.errors import UsageError
from engine.gpu.types import Buffer, Device, Sampler, SamplerDesc, Texture
from engine.materials.effect import Effect, texture_unit
from engine.materials.fit import Complaint, fitted
from engine.materials.table import MaterialTable
from engine.resources.texture_pool import PooledTexture, TexturePool

#: texture group: (array, sampler id) per slot
GroupKey = tuple[tuple[int, int], ...]


@dataclass(slots=True)
class MaterialRecord:
    """What the renderer needs to know of a material. `row`: its row in the effect's table.

    `folder`: what its texture paths are relative to. `asset`: what the effect takes of it. `whole`: all that the
    material says, where the effect does not take all. `base`: the material that this is a variation of, with the
    parameters `overrides`; -1: it stands by itself."""

    asset: MaterialAsset
    effect: Effect
    row: int
    group: int
    path: str = ""
    folder: Path = Path()
    whole: MaterialAsset | None = None
    base: int = -1
    overrides: dict[str, Any] = field(default_factory=dict)

    @property
    def said(self) -> MaterialAsset:
        """All that the material says."""
        return self.whole or self.asset


@dataclass(slots=True)
class _EffectRows:
    effect: Effect
    table: MaterialTable
    buffer: Buffer | None = None
    uploaded_rev: int = -1


@dataclass(slots=True)
class MaterialStore:
    """All materials of a runtime; ids are indices into `records`."""

    device: Device
    pool: TexturePool
    records: list[MaterialRecord] = field(default_factory=list)
    #: counts every change that can alter a draw's pipeline or group (not mere values)
    structure_rev: int = 0
    _effects: dict[str, _EffectRows] = field(default_factory=dict)
    _groups: dict[GroupKey, int] = field(default_factory=dict)
    _group_list: list[GroupKey] = field(default_factory=list)
    _samplers: list[SamplerDesc] = field(default_factory=list)
    _sampler_ids: dict[SamplerDesc, int] = field(default_factory=dict)
    #: material -> its variations
    _derived: dict[int, list[int]] = field(default_factory=dict)

    def add(
        self, asset: MaterialAsset, effect: Effect, textures: Mapping[str, PooledTexture], path: str = "",
        folder: Path = Path(),
    ) -> int:  # fmt: skip
        """Add a material whose slots read `textures` (every slot of the effect must be there); returns its id."""
        row = self._rows(effect).table.add(asset, _layers(textures))
        group = self._group(asset, effect, textures)
        self.records.append(MaterialRecord(asset, effect, row, group, path, folder))
        self.structure_rev += 1
        return len(self.records) - 1

    def replace(
        self, material: int, asset: MaterialAsset, effect: Effect, textures: Mapping[str, PooledTexture],
        whole: MaterialAsset | None = None,
    ) -> None:  # fmt: skip
        """Put another material in the place of one; its id stays. Raises InputError as `add`, and changes nothing."""
        record, table = self.records[material], self._rows(effect).table
        if record.effect.name == effect.name:
            table.replace(record.row, asset, _layers(textures))
        else:
            record.row = table.add(asset, _layers(textures))
        record.asset, record.effect, record.whole = asset, effect, whole
        record.group = self._group(asset, effect, textures)
        self.structure_rev += 1
        self._follow(material)

    def derive(self, base: int, overrides: Mapping[str, Any]) -> int:
        """A material that is `base` (no variation itself) in all but these parameters, drawn in one batch with it;
        returns its id. What changes of `base` changes here too. Raises UsageError as `set_param`."""
        record = self.records[base]
        checked = _checked(record.effect, overrides)
        row = self._effects[record.effect.name].table.copy(record.row)
        self.records.append(replace(record, row=row, path="", asset=_varied(record.asset, {}), base=base, overrides={}))
        made = len(self.records) - 1
        self._derived.setdefault(base, []).append(made)
        self.override(made, checked)
        self.structure_rev += 1
        return made

    def override(self, material: int, overrides: Mapping[str, Any]) -> None:
        """Let a variation have other parameters of its own. Raises UsageError; then nothing is changed."""
        record, base = self.records[material], self.records[self.records[material].base]
        checked = _checked(record.effect, overrides)
        table = self._effects[record.effect.name].table
        for name in record.overrides.keys() - checked.keys() & record.effect.param_by_name.keys():
            table.set_param(record.row, name, self.get_param(record.base, name))
        for name, value in checked.items():
            table.set_param(record.row, name, value)
        record.overrides = checked
        record.asset = _varied(base.asset, checked)

    def base_of(self, material: int) -> int:
        """The material that a variation is one of; itself for any other."""
        base = self.records[material].base
        return material if base < 0 else base

    def variations(self, base: int) -> Sequence[int]:
        """All that were derived from a material, shown or not."""
        return self._derived.get(base, ())

    def _follow(self, base: int) -> None:
        """The variations of a material take over what is new in it, and what its effect knows of their own."""
        record = self.records[base]
        table = self._effects[record.effect.name].table
        for number in self._derived.get(base, ()):
            mine = self.records[number]
            mine.row = table.copy(record.row) if mine.effect.name != record.effect.name else mine.row
            table.put_copy(record.row, mine.row)
            mine.effect, mine.group, mine.whole = record.effect, record.group, None
            taken = {}
            for name, value in mine.overrides.items():
                if name in record.effect.param_by_name and _fits(record.effect, name, value):
                    taken[name] = value
                    table.set_param(mine.row, name, value)
            mine.asset = _varied(record.asset, taken)

    def adopt(
        self, effect: Effect, textures: Callable[[MaterialAsset, Path], Mapping[str, PooledTexture]]
    ) -> list[tuple[MaterialRecord, list[Complaint]]]:
        """Move all materials of a reloaded effect over to it; `textures` gives a material's textures by slot.

        What the effect no longer takes is remembered (see MaterialRecord.whole) and told in the result."""
        self.structure_rev += 1  # values and pipelines of its draws are new ones
        rows = self._effects.get(effect.name)
        if rows is None or rows.effect is effect:
            return []
        rows.effect, rows.table = effect, rows.table.migrate(effect)
        told: list[tuple[MaterialRecord, list[Complaint]]] = []
        for record in self.records:
            if record.effect.name == effect.name and record.base < 0:
                whole = record.said
                asset, complaints = fitted(effect, whole)
                if complaints:
                    told.append((record, complaints))
                slots = textures(asset, record.folder)
                rows.table.replace(record.row, asset, _layers(slots))
                record.asset, record.effect = asset, effect
                record.whole = whole if complaints else None
                record.group = self._group(asset, effect, slots)
        for base in self._derived:
            if self.records[base].effect is effect:
                self._follow(base)
        return told

    def _rows(self, effect: Effect) -> _EffectRows:
        rows = self._effects.get(effect.name)
        if rows is None:
            rows = self._effects[effect.name] = _EffectRows(effect, MaterialTable(effect))
        return rows

    def _group(self, asset: MaterialAsset, effect: Effect, textures: Mapping[str, PooledTexture]) -> int:
        key = tuple(
            (textures[slot.name].array, self._sampler(asset.textures.get(slot.name), slot.sampler))
            for slot in effect.textures
        )
        group = self._groups.setdefault(key, len(self._group_list))
        if group == len(self._group_list):
            self._group_list.append(key)
        return group

    def set_param(self, material: int, name: str, value: Any) -> None:
        """Set a parameter: the next frame shows it. Raises UsageError for an unknown name or a bad value."""
        record = self.records[material]
        self._effects[record.effect.name].table.set_param(record.row, name, value)
        record.asset.params[name] = value
        if record.whole is not None:
            record.whole.params[name] = value
        followers = [
            r for r in map(self.records.__getitem__, self._derived.get(material, ())) if name not in r.overrides
        ]
        for follower in followers:
            follower.asset.params[name] = value
        rows = np.array([follower.row for follower in followers], np.intp)
        self._effects[record.effect.name].table.set_rows(rows, name, value)

    def put_layer(self, material: int, slot: str, layer: int) -> None:
        """Let a slot read another layer of its array."""
        record = self.records[material]
        self._effects[record.effect.name].table.put_layer(record.row, slot, layer)

    def get_param(self, material: int, name: str) -> Any:
        """The value as the material has it, or the effect's default."""
        record = self.records[material]
        if name in record.asset.params:
            return record.asset.params[name]
        return next(p.default for p in record.effect.params if p.name == name)

    @property
    def values_rev(self) -> int:
        """Counts changes of values, those of structure included."""
        return self.structure_rev + sum(rows.table.rev for rows in self._effects.values())

    def rows_of(self, effect: str) -> NDArray[np.void]:
        """The rows of an effect's materials, a view: do not write to it."""
        return self._effects[effect].table.rows

    def buffer(self, effect: str) -> Buffer:
        """The GPU rows of `effect`, uploaded if they changed."""
        rows = self._effects[effect]
        data = rows.table.rows
        if rows.buffer is None or rows.buffer.size < data.nbytes:
            if rows.buffer is not None:
                rows.buffer.release()
            rows.buffer = self.device.buffer(data.nbytes, label=f"materials {effect}")
            rows.uploaded_rev = -1
        if rows.uploaded_rev != rows.table.rev:
            rows.buffer.write(data)
            rows.uploaded_rev = rows.table.rev
        return rows.buffer

    def bindings(self, group: int, anisotropy: float = 1.0) -> dict[int, tuple[Texture, Sampler]]:
        """Texture unit -> (array, sampler) of a texture group. `anisotropy` holds where the author asked for full
        trilinear filtering; elsewhere it would smooth what is meant to be hard."""
        most = min(anisotropy, self.device.caps.max_anisotropy)
        bound: dict[int, tuple[Texture, Sampler]] = {}
        for index, (array, sampler) in enumerate(self._group_list[group]):
            desc = self._samplers[sampler]
            if desc.anisotropy > 0.0:  # by hand, in a sampler group
                desc = replace(desc, anisotropy=min(desc.anisotropy, self.device.caps.max_anisotropy))
            else:
                full = most > 1.0 and desc.min_filter == "linear_mip_linear"
                desc = replace(desc, anisotropy=most if full else 1.0)
            bound[texture_unit(index)] = (self.pool.texture(array), self.device.sampler(desc))
        return bound

    def slot_texture(self, material: int, slot: str) -> tuple[Texture, int]:
        """The array texture that a slot of a material reads, and the layer in it."""
        record = self.records[material]
        unit = record.effect.slot_by_name[slot].unit
        row = self._effects[record.effect.name].table.rows[record.row]
        return self.bindings(record.group)[unit][0], int(row[f"{slot}_layer"])

    def release(self) -> None:
        for rows in self._effects.values():
            if rows.buffer is not None:
                rows.buffer.release()
        self._effects.clear()
        self.records.clear()

    def _sampler(self, ref: TextureRef | None, group: SamplerDesc | None) -> int:
        """`group`: the effect's sampler group of the slot, for all that the material does not say itself."""
        ref = ref or TextureRef("")
        said = {name: getattr(ref, name) for name in SAMPLING}
        if group is not None:
            plain = TextureRef("")
            said = {n: value for n, value in said.items() if value != getattr(plain, n) or n in ref.stated}
        desc = replace(group or SamplerDesc(anisotropy=0.0), **said)
        if desc not in self._sampler_ids:
            self._sampler_ids[desc] = len(self._samplers)
            self._samplers.append(desc)
        return self._sampler_ids[desc]


def _checked(effect: Effect, values: Mapping[str, Any]) -> dict[str, Any]:
    """Raises UsageError for a parameter that the effect has not, or a value that is none."""
    return {name: effect.param(name).check(value) for name, value in values.items()}


def _fits(effect: Effect, name: str, value: Any) -> bool:
    try:
        effect.param(name).check(value)
    except UsageError:
        return False
    return True


def _varied(asset: MaterialAsset, overrides: Mapping[str, Any]) -> MaterialAsset:
    return replace(asset, params={**asset.params, **overrides})


def _layers(textures: Mapping[str, PooledTexture]) -> dict[str, int]:
    return {slot: pooled.layer for slot, pooled in textures.items()}
