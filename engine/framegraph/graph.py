"""FrameGraph: a list of passes, and the cache of what they compile to."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import Any

from engine.core.errors import LucarnaError
from engine.framegraph import planning
from engine.framegraph.builder import Builder, Declaration, Resource
from engine.framegraph.compiled import CompiledGraph, LeftOut, Plan
from engine.framegraph.passes import Pass
from engine.framegraph.pool import HistoryStore, TransientPool
from engine.framegraph.resources import texture_bytes
from engine.gpu.types import Device, TextureDesc


class FrameGraph:
    """Passes in their order of execution. `compiles` counts the compilations, `capacity` bounds the kept ones."""

    def __init__(self, passes: Sequence[Pass], *, capacity: int = 8) -> None:
        names = [item.name for item in passes]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise LucarnaError(f"two passes have the same name: {', '.join(twice)}", hint="give each pass its own")
        self.passes = tuple(passes)
        self.capacity = capacity
        self.compiles = 0
        self._structured = tuple(p for p in passes if type(p).structure_key is not Pass.structure_key)
        self._cache: OrderedDict[Hashable, CompiledGraph] = OrderedDict()
        self._devices: list[tuple[Device, TransientPool, HistoryStore]] = []

    def compile(
        self, device: Device, facts: Hashable, size: tuple[int, int], *, force_all: bool = False, key: Hashable = None
    ) -> CompiledGraph:
        """The graph for these facts and this view size (pixels); cached, one dict look-up when nothing changed.

        `key` tells views apart: each has its own results and histories. `force_all` leaves nothing out.
        Raises LucarnaError with all mistakes of the passes' declarations.
        """
        structure = tuple([item.structure_key() for item in self._structured])
        full_key = (id(device), facts, size, force_all, key, structure)
        found = self._cache.get(full_key)
        if found is not None:
            self._cache.move_to_end(full_key)
            return found
        plan = make_plan(self.passes, facts, size, force_all=force_all)
        self.compiles += 1
        pool, store = self._textures_of(device)
        graph = CompiledGraph(device, facts, size, key, plan, pool, store)
        self._cache[full_key] = graph
        while len(self._cache) > self.capacity:
            self._cache.popitem(last=False)[1].release()
        pool.trim()
        store.keep_only(cached.view for cached in self._cache.values())
        return graph

    def reset_history(self, device: Device, key: Hashable = None) -> None:
        """The histories of that view hold nothing useful any more (a cut of the camera)."""
        self._textures_of(device)[1].reset(key)

    def release(self) -> None:
        """Free all textures and forget all compiled graphs."""
        for graph in self._cache.values():
            graph.release()
        self._cache.clear()
        for _, pool, store in self._devices:
            pool.trim(0)
            store.keep_only(())
        self._devices.clear()

    def pool(self, device: Device) -> TransientPool:
        """The transient textures on that device."""
        return self._textures_of(device)[0]

    def _textures_of(self, device: Device) -> tuple[TransientPool, HistoryStore]:
        for known, pool, store in self._devices:
            if known is device:
                return pool, store
        self._devices.append((device, TransientPool(device), HistoryStore(device)))
        return self._devices[-1][1:]


def make_plan(passes: Sequence[Pass], facts: Any, size: tuple[int, int], *, force_all: bool = False) -> Plan:
    """Compile without a device. Raises LucarnaError with all mistakes."""
    resources: dict[str, Resource] = {}
    phantoms: dict[str, Resource] = {}  # what passes without need would create: for estimates and messages
    absent: dict[str, tuple[str, str]] = {}
    errors: list[str] = []
    wanted: list[tuple[Pass, Declaration]] = []
    unneeded: list[tuple[Declaration, str]] = []
    for item in passes:
        answer = True if force_all else item.needs(facts)
        if answer is True:
            builder = Builder(item.name, resources, errors, facts, size)
            item.declare(builder)
            wanted.append((item, builder.declaration))
            continue
        reason = answer if isinstance(answer, str) and answer else "the scene does not need it"
        builder = Builder(item.name, {**phantoms, **resources}, [], facts, size)
        item.declare(builder)
        unneeded.append((builder.declaration, reason))
        for name in builder.declaration.creates + builder.declaration.imports:
            phantoms.setdefault(name, builder.resources[name])
            absent.setdefault(name, (item.name, reason))
    declarations = [declaration for _, declaration in wanted]
    errors += planning.check(declarations, resources, absent)
    if errors:
        _raise(errors)

    everything = range(len(wanted))
    kept = set(everything)
    if not force_all:
        kept = planning.reachable(planning.dependencies(declarations), planning.roots(declarations, resources))
    sizes = {name: _desc(resource, size) for name, resource in {**phantoms, **resources}.items()}
    reasons = {d.name: (d, reason) for d, reason in unneeded}
    reasons |= {declarations[i].name: (declarations[i], _unread(declarations[i])) for i in everything if i not in kept}
    left_out = [
        LeftOut(item.name, reasons[item.name][1], _bytes_written(reasons[item.name][0], sizes))
        for item in passes
        if item.name in reasons
    ]
    order = sorted(kept)
    return _allocate([wanted[i][0] for i in order], [declarations[i] for i in order], left_out, resources, sizes)


def _allocate(
    passes: list[Pass], declarations: list[Declaration], left_out: list[LeftOut], resources: dict[str, Resource],
    descs: dict[str, TextureDesc],
) -> Plan:  # fmt: skip
    spans = planning.lifetimes(declarations)
    histories = frozenset(name for d in declarations for name in d.histories)
    held = frozenset(name for d in declarations for name in (*d.presents, *d.keeps))
    imported = {n: r.imported for n, r in resources.items() if n in spans and r.imported is not None}
    alive = {n: resources[n] for n in spans if n not in imported}
    owned = (held & alive.keys()) - histories
    kinds = {n: replace(descs[n], label="") for n in alive if n not in owned and n not in histories}
    slots = planning.alias(spans, kinds)
    slot_descs = {slot: kinds[name] for name, slot in slots.items()}
    return Plan(
        passes=passes, declarations=declarations, left_out=left_out, descs={n: descs[n] for n in spans}, spans=spans,
        slots=slots, slot_descs=[slot_descs[i] for i in range(len(slot_descs))], owned=owned,
        histories=histories, imported=imported,
    )  # fmt: skip


def _desc(resource: Resource, size: tuple[int, int]) -> TextureDesc:
    if resource.imported is not None:
        return resource.imported.desc
    assert resource.spec is not None
    return resource.spec.resolve(size, resource.name)


def _unread(declaration: Declaration) -> str:
    if declaration.writes:
        return f"nothing reads its outputs: {', '.join(declaration.writes)}"
    return "it has no outputs and no side effect"


def _bytes_written(declaration: Declaration, descs: dict[str, TextureDesc]) -> int:
    return sum(texture_bytes(descs[name]) for name in declaration.writes if name in descs)


def _raise(errors: list[str]) -> None:
    if len(errors) == 1:
        raise LucarnaError(f"frame graph: {errors[0]}")
    lines = "".join(f"\n  {error}" for error in errors)
    raise LucarnaError(f"frame graph: {len(errors)} mistakes{lines}")
