"""Ahead: what a frame needs of new programs, compiled in slices while the last picture stays.

    follow(scene, view, patience)
        not begun ──► begin every program the scene wants; drivers with KHR_parallel_shader_compile work aside ──► wait
        begun ─────► draw; each pipeline that was not drawn yet costs its share of `patience`; when that is spent,
                     Enough ends the frame, what was warmed is left out of the next one ──► last picture
        all warm ──► draw everything ──► new picture

One thread and one context: a second context that shares objects is not to be had on every window system, and would not
help where it is slowest. Software Mesa makes machine code at a pipeline's first draw, per context, for exactly the
attachments and samplers that are bound, so only a real draw warms it. Every slice gets one pipeline done at least, so
it always ends. Headless pictures are not made this way: they wait.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, field

from engine.gpu.types import Device
from engine.materials.library import EffectLibrary
from engine.materials.variant import VariantRequest

#: sets of facts whose pipelines are remembered as warm
REMEMBERED = 64


class Enough(Exception):
    """The time that a frame may spend on new programs is over; the frame is not to be shown."""


@dataclass(slots=True)
class Ahead:
    """`patience`: seconds a frame may spend on what is new; None: it waits for everything. `skipping`: what is warm is
    left out of this frame. `done`, `total`: how far it is, while there is something to wait for."""

    patience: float | None = None
    skipping: bool = False
    done: int = 0
    total: int = 0
    #: facts -> what was drawn with them; of several, so that facts that come and go do not begin again each time
    _known: dict[Hashable, set[Hashable]] = field(default_factory=dict)
    _warm: set[Hashable] = field(default_factory=set)
    _warm_for: Hashable = None
    #: key -> what is wanted and not to be had without a wait yet
    _waiting: dict[Hashable, list[VariantRequest]] = field(default_factory=dict)
    _spent: float = 0.0
    _since: float = 0.0
    _fresh: int = 0

    @property
    def waiting(self) -> bool:
        """Whether the last frame was not finished."""
        return self.total > 0

    def forget(self) -> None:
        """Pipelines were let go."""
        self._known.clear()
        self._warm, self._warm_for = set(), None
        self._waiting.clear()

    def start(self, patience: float | None, facts: Hashable) -> None:
        """A frame begins."""
        self.patience = patience
        self._spent = self._since = 0.0
        self._fresh = 0
        if self._warm_for != facts:
            self._warm = self._known.setdefault(facts, set())
            while len(self._known) > REMEMBERED:
                del self._known[next(iter(self._known))]
            self._warm_for, self.skipping = facts, False

    def begun(
        self, key: Hashable, wanted: Callable[[], Iterable[VariantRequest]], device: Device, effects: EffectLibrary
    ) -> bool:
        """Begin `wanted`, asked for once per `key`; True when none of them would be waited for."""
        if self.patience is None or self._waiting.get(key) == []:
            return True
        if key not in self._waiting:
            self._waiting[key] = list(wanted())
            self.total = len(self._waiting[key])
            while len(self._waiting) > REMEMBERED:
                if self._waiting.pop(next(iter(self._waiting))):
                    effects.abandon()
        start = time.perf_counter()
        left: list[VariantRequest] = []
        for number, request in enumerate(self._waiting[key]):
            late = number > 0 and time.perf_counter() - start > self.patience
            if late or not effects.begin(device, request):
                left.append(request)
        self._waiting[key] = left
        self.total = max(self.total, len(left))
        self.done = self.total - len(left)
        return not left

    def wants(self, key: Hashable) -> bool:
        """Asked before something is drawn: whether to. Raises Enough."""
        if self.patience is None:
            return True
        now = time.perf_counter()
        if self._since:
            self._spent += now - self._since
            self._since = 0.0
        if key in self._warm:
            return not self.skipping
        if self._fresh and self._spent >= self.patience:
            self.done = len(self._warm)
            self.total = max(self.total, self.done + 1)
            raise Enough
        self._fresh += 1
        self._since = now
        self._warm.add(key)
        return True

    def forget_frame(self) -> None:
        """What was drawn last was for nobody: the next frame begins by itself."""
        self.skipping, self._warm_for = False, None
        self.done = self.total = 0

    def whole(self) -> None:
        """A frame was finished with nothing left out."""
        self.skipping = False
        self.done = self.total = 0
