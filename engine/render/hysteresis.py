"""Hysteresis: a fact that flickers stays on for a while, so that graphs, programs and histories do not come and go.

A fact that goes off is off at once, and what depends on it is left out in that very frame. Only when it comes back
within `hold` frames does it count as flickering; from then on it is taken for needed until it was not for `hold` frames
in a row. So a lamp that blinks costs two compilations, not two a blink, and a scene that really changed pays nothing.

Only facts that change no pixel when they are on for nothing may be held: those of which the forced frame, in which
every branch runs, is equal to the bit.

    facts of the scene --> Hysteresis(view) --> facts of the frame (the same, or some off ones on)
"""

from __future__ import annotations

import weakref
from collections import OrderedDict
from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Any

from engine.render.facts import SceneFacts
from engine.scene.scene import Scene

#: facts that are neutral when on for nothing: a pass that draws no batch, a loop over no light
NEUTRAL = ("opaque", "transparent", "suns", "local_lights", "moving")
#: frames without need after which a flickering fact goes off: half a second at 60 a second
HOLD = 30
#: views that are remembered, as many as the frame graph keeps compiled
VIEWS = 8


@dataclass(slots=True)
class _Fact:
    """`needed`: when it was last needed, `since`: since when without a gap, `off`: when it last went off; frames."""

    needed: int = -1
    since: int = -1
    off: int = -1
    on: bool = False
    flickers: bool = False

    def step(self, frame: int, wanted: bool, hold: int) -> bool:
        if wanted:
            if not self.on and self.off >= 0 and frame - self.off <= hold:
                self.flickers = True
            if self.needed != frame - 1:
                self.since = frame
            elif frame - self.since >= hold:
                self.flickers = False  # it has settled
            self.needed, self.on = frame, True
        elif self.on and not (self.flickers and frame - self.needed < hold):
            self.on, self.flickers, self.off = False, False, frame
        return self.on


class Hysteresis:
    """Of one renderer. `held`: the facts of the last frame that are on although its scene does not need them."""

    def __init__(self, names: tuple[str, ...] = NEUTRAL, hold: int = HOLD) -> None:
        self.names, self.hold = names, hold
        self.held: tuple[str, ...] = ()
        self._scene: weakref.ref[Scene] | None = None
        self._views: OrderedDict[Hashable, tuple[list[int], dict[str, _Fact]]] = OrderedDict()

    def __call__(self, scene: Scene, view: Hashable, facts: SceneFacts) -> SceneFacts:
        """The facts to make this frame of `view` with. Another scene starts anew."""
        if self._scene is None or self._scene() is not scene:
            self._scene = weakref.ref(scene)
            self._views.clear()
        clock, states = self._views.setdefault(view, ([0], {name: _Fact() for name in self.names}))
        self._views.move_to_end(view)
        while len(self._views) > VIEWS:
            self._views.popitem(last=False)
        clock[0] += 1
        shown = {name: states[name].step(clock[0], getattr(facts, name), self.hold) for name in self.names}
        self.held = tuple(name for name, on in shown.items() if on and not getattr(facts, name))
        on: dict[str, Any] = dict.fromkeys(self.held, True)
        return replace(facts, **on) if on else facts
