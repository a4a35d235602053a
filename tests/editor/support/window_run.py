"""A scripted run in a real window: steps on the test engine's thread, work on the window's, a screenshot after each.

run = WindowRun(folder)                 the app, not yet open
run.play(steps)                         steps(run): run.do(job), run.until(what), run.shot("opened"), run.picture()
"""

from __future__ import annotations

import os
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from imgui_bundle import hello_imgui, immapp
from imgui_bundle.immapp import testing

from editor.app import App
from editor.builtin_operations import builtin_operations
from editor.host import EngineHost
from editor.preferences import Preferences
from editor.session import Session
from engine.report.image import save_png

PATIENCE = 30.0


#: seconds after which the test engine ends a run: a busy machine is slow
WATCHDOG = 600.0


class WindowRun:
    """`shots`: names of the screenshots, in order; they lie in `folder` as NN-name.png. `error`: what went wrong."""

    def __init__(self, folder: Path, *, size: tuple[int, int] = (1200, 750)) -> None:
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        self.session = Session(EngineHost(), Preferences(welcome_seen=True, adaptive_resolution=False))
        self.session.save_preferences = False
        self.app = App(self.session, builtin_operations(), size=size, remember_layout=False)
        self.shots: list[str] = []
        self.error = ""
        self.ctx: Any = None
        self._jobs: list[Callable[[], None]] = []  # what must run where the GL context is
        self._wanted = ""
        end_frame = self.app.params.callbacks.post_render_dockable_windows

        def work() -> None:
            end_frame()
            while self._jobs:
                self._jobs.pop(0)()

        self.app.params.callbacks.post_render_dockable_windows = work
        self.app.params.callbacks.after_swap = self._take

    def play(self, steps: Callable[[WindowRun], None]) -> None:
        """Run the window through `steps`."""

        def guarded(ctx: Any) -> None:
            self.ctx = ctx
            ctx.engine_io.config_watchdog_warning = ctx.engine_io.config_watchdog_kill_test = WATCHDOG
            try:
                steps(self)
            except BaseException:  # an exception must not unwind into the engine's coroutine
                self.error = traceback.format_exc()
            # a window at rest sleeps until something happens: nobody would tell it that the script is done
            self.app.idling.pause = lambda *_, **__: 0.0  # type: ignore[method-assign]  # from here on it is ending

        try:
            testing.run(test_function=guarded, runner_params=self.app.params, add_ons_params=immapp.AddOnsParams())
        except RuntimeError as error:
            self.error = f"{self.error}\n{error}"

    def do(self, job: Callable[[], object]) -> None:
        """Run `job` on the window's thread, between two frames."""
        self._jobs.append(lambda: (job(), None)[1])
        self.ctx.yield_(2)

    def until(self, what: Callable[[], object]) -> bool:
        end = time.monotonic() + PATIENCE
        while not what() and time.monotonic() < end:
            self.ctx.yield_()
        return bool(what())

    def picture(self) -> Any:
        """The viewport's pixels u1[h,w,4]."""
        found: list[Any] = []
        self.ctx.yield_(3)
        self.do(lambda: found.append(np.array(self.session.image.pixels())))
        assert found
        return found[0]

    def shot(self, name: str) -> Path:
        """Save what the whole window shows as NN-name.png."""
        self.ctx.yield_(2)
        self._wanted = name
        assert self.until(lambda: not self._wanted), "no frame came"
        return self.path(name)

    def path(self, name: str) -> Path:
        return self.folder / f"{self.shots.index(name) + 1:02d}-{name}.png"

    def write(self, path: Path, text: str) -> None:
        """Save a file as another program would, so that the change is seen whatever the clock's grain."""
        path.write_text(text, encoding="utf-8")
        info = path.stat()
        os.utime(path, ns=(info.st_atime_ns, info.st_mtime_ns + 1_000_000))

    def panel(self, title: str) -> Any:
        return next(p for p in self.app.panels if p.title == title)

    def _take(self) -> None:
        """The window as it was just shown."""
        if not self._wanted:
            return
        import moderngl

        context = moderngl.get_context()
        size = hello_imgui.get_runner_params().app_window_params.window_geometry.size
        data = context.screen.read((0, 0, *size), components=3, alignment=1)
        pixels = np.frombuffer(data, np.uint8).reshape(size[1], size[0], 3)[::-1]
        self.shots.append(self._wanted)
        save_png(self.path(self._wanted), np.ascontiguousarray(pixels))
        self._wanted = ""
