"""UI test in a real window that is left alone: `idle_window_ui.py FOLDER`; run by test_idle_window.py.

A thread watches how many frames the window draws, and does from outside what should wake it; in the end it sends the
process Ctrl+C."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

from animated_scene import write_animated_scene  # noqa: E402  (needs the path above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)

from editor import idling, journal, waking  # noqa: E402  (needs the path above)
from editor.app import App  # noqa: E402  (needs the path above)
from editor.builtin_operations import builtin_operations  # noqa: E402  (needs the path above)
from editor.host import EngineHost  # noqa: E402  (needs the path above)
from editor.preferences import Preferences  # noqa: E402  (needs the path above)
from editor.session import Session  # noqa: E402  (needs the path above)

#: seconds: left alone; at most until something happens, which a busy machine may take its time for
ALONE, PATIENCE = 2.0, 60.0


class Watcher:
    """`seen`: what it saw. `do` runs a job on the window's thread, which it wakes for it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.seen: dict[str, Any] = {"error": ""}
        self.session = Session(EngineHost(), Preferences(welcome_seen=True))
        self.session.save_preferences = False
        self.session.recovery_folder = folder / "recovery"
        self.app = App(self.session, builtin_operations(), size=(900, 600), remember_layout=False)
        self.app.on_shown = lambda: self.session.open(write_small_scene(folder))
        self._jobs: list[Callable[[], object]] = []
        end_frame = self.app.params.callbacks.post_render_dockable_windows

        def work() -> None:
            while self._jobs:
                self._jobs.pop(0)()
            end_frame()

        self.app.params.callbacks.post_render_dockable_windows = work

    def do(self, job: Callable[[], object]) -> None:
        self._jobs.append(job)
        waking.wake()
        self.until(lambda: not self._jobs)

    def until(self, what: Callable[[], object]) -> bool:
        end = time.monotonic() + PATIENCE
        while not what() and time.monotonic() < end:
            time.sleep(0.02)
        return bool(what())

    @property
    def frames(self) -> int:
        return self.app.ui.drawn

    def rest(self) -> None:
        """Until the window has drawn nothing for as long as its last look takes to come."""
        since, frames, end = time.monotonic(), self.frames, time.monotonic() + PATIENCE
        while time.monotonic() - since < idling.LOOK_AGAIN[-1] + 0.2 and time.monotonic() < end:
            time.sleep(0.05)
            if self.frames != frames:
                since, frames = time.monotonic(), self.frames

    def alone(self, seconds: float = ALONE) -> tuple[int, float]:
        """(frames drawn, share of one processor) while nobody does anything."""
        frames, spent = self.frames, time.process_time()
        time.sleep(seconds)
        return self.frames - frames, (time.process_time() - spent) / seconds

    def watch(self) -> None:
        try:
            self._steps()
        except BaseException:  # the window must end whatever went wrong
            self.seen["error"] = traceback.format_exc()
        os.kill(os.getpid(), signal.SIGINT)

    def _steps(self) -> None:
        session, seen = self.session, self.seen
        assert self.until(lambda: session.image.frame is not None), session.ui.error_bar
        self.rest()
        seen["alone"] = self.alone()
        renders = session.image.renders

        red = self.folder / "boxes.red.material.toml"
        red.write_text(red.read_text("utf-8").replace("roughness = 0.5", "roughness = 0.25"), "utf-8")
        seen["reloaded"] = self.until(lambda: session.image.renders > renders)
        self.rest()
        seen["after_reload"] = self.alone(1.0)[0]

        renders = session.image.renders
        gathered = {"samples": 1, "antialias": "taa", "taa_frames": 4, "auto_exposure": True}
        self.do(lambda: session.apply_settings(gathered))
        self.until(lambda: session.image.settling)
        seen["settles"] = self.until(lambda: not session.image.settling)
        seen["gathered"] = session.image.renders - renders
        self.rest()
        seen["after_settling"] = self.alone(1.0)[0]

        text = self.folder / "boxes.grey.material.toml"
        self.do(lambda: session.open_code(text))
        self.rest()
        text.write_text(text.read_text("utf-8").replace("roughness = 0.5", "roughness = 0.75"), "utf-8")
        front = session.code.front
        assert front is not None
        seen["text_followed"] = self.until(lambda: "0.75" in front.text)

        assert session.journal is not None
        journal.SNAPSHOT_SECONDS = 1.0
        session.journal._snapshot_after = time.monotonic() + 1.0
        kept = session.journal
        self.do(lambda: session.set_visible((2,), False))
        seen["kept"] = self.until(lambda: kept.due is None and journal.snapshot_of(kept.path).is_file())

        self.do(lambda: session.open(write_animated_scene(self.folder / "figure")))
        self.until(lambda: session.playback.available)
        self.rest()
        self.do(session.playback.toggle)
        frames = self.frames
        seen["plays"] = self.until(lambda: self.frames > frames + 20)
        self._stand("away")
        time.sleep(1.0)
        played = session.playback.elapsed
        seen["away"] = self.alone(1.5)[0], session.playback.elapsed - played
        self._stand("behind")
        frames = self.frames
        seen["behind_goes_on"] = self.until(lambda: self.frames > frames + 3)
        seen["behind"] = self.alone(1.5)[0]
        session.preferences.in_background = "stop"
        time.sleep(1.0)
        seen["stopped"] = self.alone(1.5)[0]
        self._stand("front")
        frames = self.frames
        seen["plays_again"] = self.until(lambda: self.frames > frames + 20)
        self.do(session.playback.toggle)
        self.rest()

    def _stand(self, sight: str) -> None:
        """As the window's library would say that it stands."""
        self.do(lambda: setattr(self.app, "_sight", lambda: sight))


def run(folder: Path) -> dict[str, Any]:
    idling.LOOK_AGAIN = (0.7,)  # what is looked at less often is no part of this
    watcher = Watcher(folder)
    threading.Thread(target=watcher.watch, daemon=True).start()
    try:
        watcher.app.run()
    except KeyboardInterrupt:
        watcher.seen["interrupted"] = True
    watcher.seen["recoveries"] = len(journal.pending(folder / "recovery"))
    return watcher.seen


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in a job of a script's background
    found = run(Path(sys.argv[1]))
    sys.stdout.write("\n" + json.dumps(found) + "\n")
    sys.stdout.flush()
