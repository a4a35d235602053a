"""How soon the editor's window is there: `start_times.py T0 [PATH]` opens the sample (or PATH) as a first start does.

Prints seconds since T0 (time.time() of who started this), and those of the processor, as JSON and leaves. Run by
tests/bench/editor_start.py."""

from __future__ import annotations

import json
import sys
import time
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))

from editor import welcome  # noqa: E402  (the path is set above)
from editor.app import App  # noqa: E402  (the path is set above)
from editor.builtin_operations import builtin_operations  # noqa: E402  (the path is set above)
from editor.host import EngineHost  # noqa: E402  (the path is set above)
from editor.preferences import Preferences  # noqa: E402  (the path is set above)
from editor.session import Session  # noqa: E402  (the path is set above)
from editor.viewport_image import PATIENCE  # noqa: E402  (the path is set above)

#: seconds after which a start has failed
LIMIT = 120.0


def main(begun: float, path: Path | None) -> dict[str, float]:
    found = {"imported": time.time() - begun}
    session = Session(EngineHost(), Preferences())
    session.save_preferences = False
    session.image.patience = PATIENCE
    app = App(session, builtin_operations(), remember_layout=False)
    app.on_shown = partial(welcome.greet, session) if path is None else partial(session.open, path)

    def shown() -> None:
        """After each swap: what of it the user sees by now."""
        found.setdefault("window", time.time() - begun)
        found.setdefault("window_cpu", time.process_time())
        if session.image.frame is not None:
            found.setdefault("picture", time.time() - begun)
            found.setdefault("picture_cpu", time.process_time())
        if "picture" in found or time.time() - begun > LIMIT:
            app.params.app_shall_exit = True

    app.params.callbacks.after_swap = shown
    app.run()
    return found


if __name__ == "__main__":
    seen = main(float(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
    sys.stdout.write("\n" + json.dumps(seen) + "\n")
