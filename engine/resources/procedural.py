"""ProceduralTextures: texture slots that an effect fills itself, by the compute stages of its technique `texture`.

    slot without a file, computed by the effect ──► pooled(): an array of the pool, 1 x 1 until something draws with it
    update(): materials that are drawn ──► a layer each ──► pipelines, size or a parameter that they name changed?
              no: nothing at all          yes: one dispatch a pass, then one a mip

Layers stay with their material. What never compiled shows magenta; after a bad edit the last good pipeline goes on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.core.findings import Findings
from engine.core.paths import shaders_dir
from engine.gpu.preprocess import flatten
from engine.gpu.types import Bindings, Buffer, ComputePass, ComputePipelineDesc, Device, Pipeline, Texture, TextureDesc
from engine.materials.effect import Effect
from engine.materials.glsl import GROUP, JOB, JOB_BINDING, MATERIAL_BINDING
from engine.materials.library import EffectLibrary
from engine.materials.requirements import AUTO
from engine.materials.roles import PROCEDURAL
from engine.materials.technique import Technique
from engine.materials.variant import Variant, VariantRequest
from engine.resources.material_store import MaterialRecord, MaterialStore
from engine.resources.texture_pool import PooledTexture, TexturePool

MAGENTA = (255, 0, 255, 255)
#: what the check of numbers calls the place where these textures are written
PLACE = "computed textures"


@dataclass(slots=True)
class _Filled:
    """Of one effect: slot -> array of the pool; material -> its layer; material -> what its layer was computed from."""

    arrays: dict[str, int] = field(default_factory=dict)
    layers: dict[int, int] = field(default_factory=dict)
    known: dict[int, tuple[object, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Job:
    material: int
    row: int
    layer: int
    pipelines: tuple[Pipeline, ...]


class ProceduralTextures:
    """`quality`: the level of techniques that is wanted; all renderers of a residency share these textures. `computed`:
    how many materials' textures were computed so far."""

    def __init__(self, device: Device, pool: TexturePool, effects: EffectLibrary, findings: Findings) -> None:
        self._device = device
        self._pool = pool
        self._effects = effects
        self._findings = findings
        self._filled: dict[str, _Filled] = {}
        self._seen: dict[int, tuple[object, ...]] = {}
        self._halve: dict[tuple[str, bool], Pipeline] = {}
        self.quality = AUTO
        self.computed = 0

    def pooled(self, effect: Effect, slot: str) -> PooledTexture:
        """What a material's slot reads until `update` gives it a layer of its own."""
        arrays = self._filled.setdefault(effect.name, _Filled()).arrays
        if slot not in arrays:
            arrays[slot] = self._pool.own(self._plain((255, 255, 255, 255)))
        return PooledTexture(arrays[slot], 0)

    def requests(self, records: Iterable[MaterialRecord]) -> list[VariantRequest]:
        """What these materials ask of the effect library, each once."""
        found: dict[VariantRequest, None] = {}
        for record in records:
            if _slots(record):
                found |= dict.fromkeys(self._requests(record))
        return list(found)

    def update(self, materials: MaterialStore, drawn: Callable[[], Iterable[int]], who: int, built: int) -> bool:
        """Compute what these materials read and is not up to date; whether anything was. `who` draws them, `built`
        grows when it draws others. Between the device's begin_frame and end_frame."""
        if not self._filled:
            return False
        key = (built, self._effects.revision, self.quality)
        if self._seen.get(who) == (*key, materials.values_rev):
            return False
        before, shown = self.computed, sorted(drawn())
        records = materials.records
        for name, filled in self._filled.items():
            ids = [m for m in shown if records[m].effect.name == name and _slots(records[m])]
            if ids:
                self._fill(materials, filled, ids)
        self._seen[who] = (built, self._effects.revision, self.quality, materials.values_rev)
        return self.computed > before

    def textures(self) -> list[tuple[str, Texture]]:
        """(slot of an effect, texture) of all that is filled, for the check of numbers."""
        found = [
            (f"{name}.{slot}", self._pool.texture(array))
            for name, filled in self._filled.items()
            for slot, array in filled.arrays.items()
        ]
        return [(name, texture) for name, texture in found if texture.desc.mips > 1]

    def forget(self, who: int) -> None:
        """A renderer is released."""
        self._seen.pop(who, None)

    def release(self) -> None:
        """The pool releases the textures."""
        for pipeline in self._halve.values():
            pipeline.release()
        self._halve.clear()
        self._filled.clear()

    # --- inside ---

    def _requests(self, record: MaterialRecord) -> list[VariantRequest]:
        effect = record.effect
        technique, _ = effect.techniques[PROCEDURAL].at(self.quality, self._device.caps)
        features = frozenset(record.asset.features) & effect.features.keys()
        features = effect.active(PROCEDURAL, frozenset(features))
        return [
            VariantRequest(effect.name, PROCEDURAL, features, (), targets=0, level=self.quality, index=index)
            for index in range(len(technique.passes) if technique is not None else 1)
        ]

    def _fill(self, materials: MaterialStore, filled: _Filled, ids: list[int]) -> None:
        effect = materials.records[ids[0]].effect
        variants = {m: self._variants(materials.records[m]) for m in ids}
        technique, _ = effect.techniques[PROCEDURAL].at(self.quality, self._device.caps)
        good = [m for m in ids if all(v.pipeline is not None for v in variants[m])]
        if technique is None or not good:
            for array in filled.arrays.values():
                self._pool.exchange(array, self._plain(MAGENTA))
            filled.layers.clear()
            filled.known.clear()
            return
        good = self._make_room(effect, technique, filled, good)
        jobs: list[_Job] = []
        for m in good:
            record, layer = materials.records[m], filled.layers[m]
            for slot in _slots(record):
                materials.put_layer(m, slot, layer)
            row = materials.rows_of(effect.name)[record.row]
            pipelines = tuple(v.pipeline for v in variants[m] if v.pipeline is not None)
            reads = sorted(frozenset[str]().union(*(v.reads for v in variants[m])))
            key = (pipelines, tuple((name, row[name].tobytes()) for name in reads))
            if filled.known.get(m) != key:
                filled.known[m] = key
                jobs.append(_Job(m, record.row, layer, pipelines))
        if jobs:
            self._dispatch(effect, technique, filled, jobs, materials.buffer(effect.name))

    def _variants(self, record: MaterialRecord) -> list[Variant]:
        return [self._effects.computing(self._device, r, record.effect) for r in self._requests(record)]

    def _make_room(self, effect: Effect, technique: Technique, filled: _Filled, ids: list[int]) -> list[int]:
        """Layers for all of these that the device has room for; textures as the technique says now."""
        most = self._device.caps.max_array_layers
        for m in ids:
            if m not in filled.layers and len(filled.layers) < most:
                filled.layers[m] = len(filled.layers)
        if any(m not in filled.layers for m in ids):
            text = f"effect {effect.name!r} computes textures for {most} materials at most; the rest shows the first's"
            self._findings.warn("texture.too_many", text)
        width, height = technique.size
        for slot, array in filled.arrays.items():
            if slot not in technique.outputs:
                continue
            old = self._pool.texture(array)
            mips = int(math.log2(max(width, height))) + 1
            wanted = TextureDesc(
                technique.outputs[slot], width, height, "2d-array", max(len(filled.layers), 1), mips=mips,
                label=f"{effect.name} {slot}",
            )  # fmt: skip
            if old.desc == wanted:
                continue
            new = self._device.texture(wanted)
            same = (old.desc.format, old.desc.width, old.desc.height, old.desc.mips) == (
                wanted.format, width, height, mips,
            )  # fmt: skip
            if same:
                self._device.copy_texture(old, new, min(old.desc.layers, wanted.layers))
            else:
                filled.known.clear()
            self._pool.exchange(array, new)
        return [m for m in ids if m in filled.layers]

    def _dispatch(self, effect: Effect, technique: Technique, filled: _Filled, jobs: list[_Job], rows: Buffer) -> None:
        width, height = technique.size
        levels = int(math.log2(max(width, height))) + 1
        stride, blocks = self._blocks(jobs, width, height, levels)
        buffer = self._device.buffer(blocks, label="texture jobs")
        arrays = {slot: self._pool.texture(filled.arrays[slot]) for slot in technique.outputs if slot in filled.arrays}
        images = {
            unit: (arrays[slot], 0, "read_write") for unit, slot in enumerate(technique.outputs) if slot in arrays
        }
        with self._device.compute_pass(f"textures of {effect.name}") as encoder:
            for number, job in enumerate(jobs):
                first = number * levels
                bindings = Bindings(
                    uniforms={JOB_BINDING: (buffer, first * stride, JOB.size)},
                    storage={MATERIAL_BINDING: rows}, images=images,
                )  # fmt: skip
                for pipeline in job.pipelines:
                    encoder.set_pipeline(pipeline)
                    encoder.set_bindings(bindings)
                    encoder.dispatch(width // GROUP, height // GROUP)
                for slot, texture in arrays.items():
                    normal = effect.slot_by_name[slot].space == "normal"
                    self._mips(encoder, texture, normal, buffer, first, stride)
        buffer.release()
        self.computed += len(jobs)

    @staticmethod
    def _blocks(jobs: list[_Job], width: int, height: int, levels: int) -> tuple[int, NDArray[np.uint8]]:
        """Rows of JOB, `levels` a job: the whole texture, then each mip. Their stride suits every device."""
        stride = 256
        blocks = np.zeros((len(jobs) * levels, stride), np.uint8)
        row = np.zeros((), JOB.dtype)
        for number, job in enumerate(jobs):
            row["material"], row["layer"] = job.row, job.layer
            for level in range(levels):
                row["size"] = max(width >> level, 1), max(height >> level, 1)
                blocks[number * levels + level, : JOB.size] = np.frombuffer(row.tobytes(), np.uint8)
        return stride, blocks

    def _mips(
        self, encoder: ComputePass, texture: Texture, normal: bool, buffer: Buffer, first: int, stride: int
    ) -> None:  # fmt: skip
        encoder.set_pipeline(self._halving(texture.desc.format, normal))
        for level in range(1, texture.desc.mips):
            encoder.set_bindings(
                Bindings(
                    uniforms={JOB_BINDING: (buffer, (first + level) * stride, JOB.size)},
                    images={0: (texture, level - 1, "read"), 1: (texture, level, "write")},
                )
            )
            wide, high = max(texture.desc.width >> level, 1), max(texture.desc.height >> level, 1)
            encoder.dispatch(-(-wide // GROUP), -(-high // GROUP))

    def _halving(self, form: str, normal: bool) -> Pipeline:
        if (form, normal) not in self._halve:
            root = shaders_dir()
            source = flatten(
                root / "textures/halve.comp", "compute", search=[root],
                prelude=JOB.block_glsl("JobBlock", JOB_BINDING, "job"),
                defines={"FORMAT": form, "NORMAL": int(normal and form not in ("r8", "r16f", "r32f"))},
            )  # fmt: skip
            self._halve[form, normal] = self._device.compute_pipeline(ComputePipelineDesc("halve texture", source))
        return self._halve[form, normal]

    def _plain(self, texel: tuple[int, int, int, int]) -> Texture:
        texture = self._device.texture(TextureDesc("rgba8", 1, 1, "2d-array", label="texture to compute"))
        texture.write(bytes(texel))
        return texture


def _slots(record: MaterialRecord) -> list[str]:
    """The slots of a material that its effect computes: those without a file."""
    textures = record.asset.textures
    return [slot for slot in record.effect.computed if slot not in textures or not textures[slot].path]
