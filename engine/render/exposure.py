"""How bright a picture is taken to be: the histogram of its luminance on the device, and what an eye has got used to.

pass auto_exposure: picture ─► histogram ─► target ─► adapted value (kept here between frames) ─► tone map
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Hashable
from typing import TYPE_CHECKING

import numpy as np

from engine.gpu.types import Buffer, Device

if TYPE_CHECKING:
    from engine.render.settings import RenderSettings

#: of the histogram (shaders/passes/exposure_*.comp): a quarter of a stop each, from 2^-16 on
BINS = 128
#: frames after which what was written is read without waiting for the device
LATENCY = 3
#: stops off its target at which nothing moves any more that could be seen
SETTLED = 0.01
#: views that are remembered, as many as the frame graph keeps compiled
VIEWS = 8
#: at most so many seconds count as one frame: a picture that stood still did not get used to the next one
LONGEST = 0.1


class ExposureState:
    """What is kept from frame to frame. Takes nothing from the device before its first `begin`."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._histogram: Buffer | None = None
        self._state: Buffer | None = None
        self._results: list[Buffer] = []
        self._pending = [False] * LATENCY
        self._frame = 0
        self._subject: object = None
        #: stops that the last known picture was brightened by, and would be in the end
        self.stops = self.target = 0.0

    def begin(self, subject: object, *, cut: bool = False) -> bool:
        """A frame is metered now. Returns whether what was adapted to holds: not for another `subject`, nor after a
        cut."""
        if self._histogram is None:
            self._histogram = self._device.buffer(8 * BINS, label="luminance histogram")
            self._state = self._device.buffer(16, label="adapted exposure")
            self._results = [self._device.buffer(16, label="exposure") for _ in range(LATENCY)]
        self._histogram.write(np.zeros(2 * BINS, np.uint32))
        self._frame += 1
        self._pending[self._frame % LATENCY] = True
        known, self._subject = self._subject == subject and not cut, subject
        return known

    @property
    def buffers(self) -> tuple[Buffer, Buffer, Buffer]:
        """The histogram, what is adapted to, and what is told of this frame."""
        assert self._histogram is not None, "begin comes first"
        assert self._state is not None, "made with the histogram"
        return self._histogram, self._state, self._results[self._frame % LATENCY]

    def read(self, *, wait: bool) -> None:
        """Bring `stops` and `target` up to date: of this frame if `wait`, else of one that is done by now."""
        slot = self._frame % LATENCY if wait else (self._frame + 1) % LATENCY
        if self._pending[slot]:
            values = np.frombuffer(self._results[slot].read(), np.float32)
            self.stops, self.target = float(values[0]), float(values[1])
            self._pending[slot] = False

    @property
    def settled(self) -> bool:
        return abs(self.stops - self.target) < SETTLED

    def release(self) -> None:
        for buffer in (self._histogram, self._state, *self._results):
            if buffer is not None:
                buffer.release()
        self._histogram = self._state = None
        self._results = []


class Exposures:
    """Of one renderer: a state for each of its views, by View.key; those longest unused are forgotten."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._states: OrderedDict[Hashable, ExposureState] = OrderedDict()

    def of(self, key: Hashable) -> ExposureState:
        state = self._states.pop(key, None)
        self._states[key] = state = state or ExposureState(self._device)
        while len(self._states) > VIEWS:
            self._states.popitem(last=False)[1].release()
        return state

    def release(self) -> None:
        for state in self._states.values():
            state.release()
        self._states.clear()


def adaptation(settings: RenderSettings, seconds: float | None) -> tuple[float, float]:
    """(towards darker, towards brighter pictures): the part of the way to the target that a frame goes.

    Krawczyk, Myszkowski, Seidel 2005, "Perceptual effects in real-time tone mapping", eq. 5: 1 - exp(-t / T).
    `seconds` since the last frame; None: all of the way."""
    if seconds is None:
        return 1.0, 1.0
    t = min(max(seconds, 0.0), LONGEST)
    wanted = (float(settings.adapt_darker), float(settings.adapt_brighter))
    darker, brighter = (1.0 if constant <= 0.0 else 1.0 - math.exp(-t / constant) for constant in wanted)
    return darker, brighter
