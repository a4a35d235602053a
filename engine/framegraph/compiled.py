"""CompiledGraph: the passes that run for one key, the textures they use, and what was left out."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field

from engine.core.errors import UsageError
from engine.framegraph.builder import Declaration, did_you_mean
from engine.framegraph.passes import Pass, PassContext
from engine.framegraph.planning import Lifetime
from engine.framegraph.pool import History, HistoryStore, Pooled, TransientPool
from engine.framegraph.resources import texture_bytes
from engine.gpu.types import Device, Texture, TextureDesc

OnPass = Callable[[str], contextlib.AbstractContextManager[object]]


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A pass that does not run. `saved`: bytes of the textures it would have written, an estimate of the saving."""

    name: str
    reason: str
    saved: int


@dataclass(slots=True)
class Plan:
    """What compiling found. `slots`: of each aliased resource; `slot_descs`: the texture of each slot."""

    passes: list[Pass]
    declarations: list[Declaration]
    left_out: list[LeftOut]
    descs: dict[str, TextureDesc]
    spans: dict[str, Lifetime]
    slots: dict[str, int]
    slot_descs: list[TextureDesc]
    owned: frozenset[str]
    histories: frozenset[str]
    imported: dict[str, Texture] = field(default_factory=dict)


class CompiledGraph:
    """Runs its passes in order. Made by `FrameGraph.compile`; textures are made at the first execution.

    Presented and kept textures belong to this graph and stay until its next execution; transient ones are shared with
    the other graphs of the device, so their content is only there while this graph executes.
    """

    def __init__(
        self, device: Device, facts: Hashable, size: tuple[int, int], view: Hashable, plan: Plan,
        pool: TransientPool, store: HistoryStore,
    ) -> None:  # fmt: skip
        self.device = device
        self.facts = facts
        self.size = size
        self.view = view
        self.plan = plan
        self.accesses: Mapping[str, frozenset[str]] = {d.name: d.used for d in plan.declarations}
        self._pool = pool
        self._store = store
        self._generation = -1
        self._leased: list[Pooled] = []
        self._owned: dict[str, Texture] = {}
        self._pairs: dict[str, History] = {}
        self._textures: dict[str, Texture] = dict(plan.imported)

    @property
    def passes(self) -> Sequence[Pass]:
        """The passes that run, in order."""
        return self.plan.passes

    @property
    def left_out(self) -> list[LeftOut]:
        return self.plan.left_out

    @property
    def transient_bytes(self) -> int:
        """Bytes of the shared textures, after aliasing."""
        return sum(map(texture_bytes, self.plan.slot_descs))

    @property
    def unaliased_bytes(self) -> int:
        """Bytes that the same resources would take with a texture each."""
        return sum(texture_bytes(self.plan.descs[name]) for name in self.plan.slots)

    def execute(self, make_context: Callable[[Pass], PassContext] | None = None, on_pass: OnPass | None = None) -> None:
        """Run the passes. `on_pass(name)` gives a context to run each pass in: timers, debug groups."""
        self._begin()
        for item in self.plan.passes:
            context = (
                PassContext(self.device, self, item.name, self.facts) if make_context is None else make_context(item)
            )
            if on_pass is None:
                item.execute(context)
            else:
                with on_pass(item.name):
                    item.execute(context)

    def texture(self, name: str) -> Texture:
        """The texture of a resource. Raises UsageError with did-you-mean for a name that this graph has not."""
        found = self._textures.get(name)
        if found is None:
            if name not in self.plan.descs:
                raise UsageError(f"the frame graph has no texture {name!r}", hint=did_you_mean(name, self.plan.descs))
            assert name not in self.plan.histories, f"{name!r} swaps every frame; it is there after the first execute"
            self._lease()
            found = self._textures[name]
        return found

    def history(self, name: str) -> Texture:
        return self._pairs[name].previous

    def history_reset(self, name: str) -> bool:
        return self._pairs[name].reset

    def bind(self, name: str, texture: Texture) -> None:
        """Put another texture in the place of an imported one. Raises UsageError when `name` is not imported."""
        if name not in self.plan.imported:
            raise UsageError(f"{name!r} is not an imported texture", hint=did_you_mean(name, self.plan.imported))
        self._textures[name] = texture

    def dump(self) -> str:
        """The graph as text: passes, textures with their lifetimes and aliases, what was left out and why."""
        from engine.framegraph.dump import dump  # here, since the drawing needs this module

        return dump(self)

    def release(self) -> None:
        """Free the textures that only this graph has. It may be executed again; they are then made anew."""
        for name, texture in self._owned.items():
            texture.release()
            del self._textures[name]
        self._owned.clear()
        self._generation = -1

    def _begin(self) -> None:
        self._pool.clock += 1
        if self._generation != self._pool.generation:
            self._lease()
        for entry in self._leased:
            entry.used = self._pool.clock
        self._store.begin_frame(self.view)
        for name in self.plan.histories:
            pair = self._store.swap(self.view, name, self.plan.descs[name])
            self._pairs[name] = pair
            self._textures[name] = pair.current

    def _lease(self) -> None:
        self._leased = self._pool.acquire(self.plan.slot_descs)
        self._generation = self._pool.generation
        for name, slot in self.plan.slots.items():
            self._textures[name] = self._leased[slot].texture
        for name in self.plan.owned - self._owned.keys():
            self._owned[name] = self._textures[name] = self.device.texture(self.plan.descs[name])
