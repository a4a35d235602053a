"""Experiments for an editor's panel: which of them make sense on what is open, and runs in small steps.

    offers(device=…, scene_open=…)   what can be measured here, and on which thread          -> list[Offer]
    LiveRun(name, device, live)      one run: step() until it says no more, then .result     -> Result (engine.report)
    engine.report.advice.advise      what is dominated, what each change would gain          -> list[Advice]

On the render thread (Offer.thread == "render"), between frames:

    run = LiveRun(offer.name, device=device, live=LiveScene(scene, residency, view, renderer))
    if run.step(budget_s=0.02): …draw run.done (0..1), run.text, run.points…
    else: …run.state is "done" (run.result), "failed" (run.error) or "cancelled"…

In a worker thread (Offer.thread == "worker", no GL is touched): `run.run()`, with `run.cancel()` from any thread.
One part of a run (a setting judged for the first time: shaders are compiled) can take longer than the budget; `step`
never breaks one off. A LiveRun frees what it holds on the device when it ends, however it ends.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field

from engine.core.errors import LucarnaError
from engine.experiments.harness import registry
from engine.experiments.harness.context import Context, Tools
from engine.experiments.harness.references import ReferenceCache
from engine.experiments.harness.scenes import LiveScene
from engine.experiments.harness.sweep import Step, steps
from engine.gpu.types import Device
from engine.report.records import Point, Result


@dataclass(frozen=True, slots=True)
class Offer:
    """An experiment as a panel lists it. `thread`: render (it draws) or worker. `own_scene`: it measures the open
    scene and view. `why_not`: empty where it can run here, else the reason."""

    name: str
    title: str
    method: str
    truth: str
    thread: str
    own_scene: bool
    why_not: str = ""


def offers(*, device: Device | None, scene_open: bool, tools: Tools | None = None) -> list[Offer]:
    """All experiments; those of the open scene first. Without `tools` (importers' help) some cannot run, and say so."""
    from engine.experiments.truth.rays import missing

    found = []
    for name in registry.names():
        e = registry.get(name)
        why = ""
        if "gpu" in e.needs and device is None:
            why = "it needs a graphics device"
        elif "rays" in e.needs and missing():
            why = missing()
        elif "tools" in e.needs and tools is None:
            why = "it needs the importers"
        elif e.own_scene and not scene_open:
            why = "no scene is open"
        thread = "render" if "gpu" in e.needs else "worker"
        found.append(Offer(name, e.title, e.method, e.truth, thread, e.own_scene, why))
    return sorted(found, key=lambda o: (not o.own_scene, bool(o.why_not), o.name))


@dataclass(slots=True)
class LiveRun:
    """A run in steps. `state`: running, done, cancelled, failed. `done` of 1; `points` as far as they are judged
    (`ms` comes at the end). `quick`: as --quick. Raises UsageError for an unknown name."""

    name: str
    device: Device | None = None
    live: LiveScene | None = None
    tools: Tools | None = None
    quick: bool = True
    seed: int = 1
    references: ReferenceCache | None = None
    state: str = field(default="running", init=False)
    done: float = field(default=0.0, init=False)
    text: str = field(default="", init=False)
    points: Sequence[Point] = field(default=(), init=False)
    result: Result | None = field(default=None, init=False)
    error: LucarnaError | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        context = Context(
            device=self.device, quick=self.quick, seed=self.seed, tools=self.tools, live=self.live,
            references=self.references or ReferenceCache(),
        )  # fmt: skip
        self._steps = steps(self.name, registry.get(self.name), context)
        self._stop = threading.Event()

    _steps: Generator[Step, None, Result] = field(init=False, repr=False)
    _stop: threading.Event = field(init=False, repr=False)

    def step(self, budget_s: float = 0.0) -> bool:
        """Go on for about `budget_s` seconds, at least one part. True while there is more. On the thread that owns the
        device, if there is one. What goes wrong is kept in `error`; nothing is raised."""
        started = time.perf_counter()
        while self.state == "running":
            if self._stop.is_set():
                self._end("cancelled")
                break
            try:
                now = next(self._steps)
                self.done, self.text, self.points = now.done, now.text, now.points
            except StopIteration as stop:
                self.result = stop.value
                self.done, self.points = 1.0, stop.value.points
                self._end("done")
            except LucarnaError as error:
                self.error = error
                self._end("failed")
            if time.perf_counter() - started >= budget_s:
                break
        return self.state == "running"

    def run(self) -> Result | None:
        """To the end, or until `cancel`; for worker threads and tests."""
        while self.step(1.0):
            pass
        return self.result

    def cancel(self) -> None:
        """From any thread: stop at the next step, which frees what the run holds."""
        self._stop.set()

    def close(self) -> None:
        """Stop now and free what the run holds; on the thread of `step`. Nothing after its end."""
        if self.state == "running":
            self._end("cancelled")

    def _end(self, state: str) -> None:
        self.state = state
        self._steps.close()
        if self.live is not None:
            self.live.close()
