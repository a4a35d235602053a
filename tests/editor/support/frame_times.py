"""CPU time of the editor's frames over a scene of N nodes: `frame_times.py N FRAMES`; prints JSON. Run by
tests/bench/editor_frames.py.

On imgui's null platform with the fake engine: what is left is the window's own work. Tree, inspector and history are
open, with a thousand edits made; five states, each a number of frames long.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]

from fake_engine import FakeHost  # noqa: E402  (the path is set above)
from imgui_bundle import hello_imgui  # noqa: E402  (the path is set above)
from ui_harness import _fake_textures  # noqa: E402  (needs the path above)

from editor.app import App  # noqa: E402  (needs the path above)
from editor.builtin_operations import builtin_operations  # noqa: E402  (needs the path above)
from editor.preferences import Preferences  # noqa: E402  (needs the path above)
from editor.session import Session  # noqa: E402  (needs the path above)

EDITS = 1000
WARM_UP = 10


def measure(nodes: int, frames: int) -> dict[str, list[float]]:
    """State -> milliseconds of each of its frames."""
    session = Session(FakeHost(nodes), Preferences(welcome_seen=True))
    session.save_preferences = False
    app = App(session, builtin_operations(), size=(1440, 900), remember_layout=False, null_platform=True)
    session.open(Path("/nowhere/many.glb"))
    tree: Any = next(p for p in app.panels if p.title == "Scene")
    times: dict[str, list[float]] = {}
    script = steps(session, tree, times, frames)
    state = {"start": 0.0, "name": ""}

    def begin() -> None:
        now = time.thread_time()
        if state["name"]:
            times[state["name"]].append(1e3 * (now - state["start"]))
        state["name"] = next(script, "end")
        if state["name"] == "end":
            state["name"], app.params.app_shall_exit = "", True
        _fake_textures()
        state["start"] = time.thread_time()

    app.params.fps_idling.enable_idling = False
    app.params.callbacks.pre_new_frame = begin
    try:
        hello_imgui.run(app.params)
    except RuntimeError as error:
        if "UiContextTarget" not in str(error):
            raise
    return {name: found[WARM_UP:] for name, found in times.items()}


def steps(session: Session, tree: Any, times: dict[str, list[float]], frames: int) -> Any:
    """Before each frame: bring the state about, say its name ('' is not measured)."""
    while session.document is None:
        yield ""
    document = session.document
    session.playback.playing = False
    for i in range(EDITS):
        session.edit("nodes", "translation", (1 + i % 3,), ((float(i), 0.0, 0.0),), label=f"Move part {i}")
    session.ui.focus_panel = "History"  # in front of the assets
    for _ in range(WARM_UP):
        yield ""
    states = {
        "at rest": lambda i: None,
        "one node dragged": lambda i: session.edit(
            "nodes", "translation", (10,), ((float(i), 1.0, 0.0),), gesture="drag"
        ),
        "another node selected": lambda i: document.select(5 + (i * 37) % (len(document.runtime.scene.nodes.name) - 6)),
        "all selected": lambda i: setattr(document, "selection", tuple(range(len(document.runtime.scene.nodes.name)))),
        "tree filtered": lambda i: setattr(tree, "needle", f"part {i % 10}"),
    }
    for name, make in states.items():
        times[name] = []
        for i in range(WARM_UP + frames):
            make(i)
            yield name
        session.end_gesture()
        document.select(-1)


if __name__ == "__main__":
    found = measure(int(sys.argv[1]), int(sys.argv[2]))
    sys.stdout.write("\n" + json.dumps(found) + "\n")
