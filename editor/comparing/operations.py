"""Operations that compare: take a state, hold it, wipe, see the difference, path against path."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from editor import work
from editor.comparing.comparing import DIFFERENCE, ONLY_A, WIPE
from editor.comparing.measuring import MeasureBoth
from editor.operations import Operation, Operations
from editor.session import Session
from engine.render.lighting import PATH_CHOICES


def add_compare_operations(ops: Operations) -> None:
    """Add them all to the registry."""

    def add(
        id: str, label: str, run: Callable[[Session], None], *keys: str, about: str,
        enabled: Callable[[Session], bool] = _has_document, checked: Callable[[Session], bool] | None = None,
        menu: str = "Compare",
    ) -> None:  # fmt: skip
        ops.add(Operation(f"compare.{id}", label, run, menu, keys, enabled, checked, id in FIRST, about))

    add("take", "Take this state as A", lambda s: s.comparing.take(s), "Ctrl+\\",
        about="Edits, render settings and path as they are now; the camera stays free")  # fmt: skip
    add("hold", "Hold to see A", lambda s: s.comparing.hold(s), "\\",
        about="While the key is down; without an A, the state before the last edit")  # fmt: skip
    for mode, label, key, about in (
        (WIPE, "Wipe A over the picture", "Shift+\\", "A on the left of a line that is dragged"),
        (ONLY_A, "Show A alone", "", "Again for the present state"),
        (DIFFERENCE, "Show where they differ", "Alt+\\", "The largest difference of each pixel, 32 times as bright"),
    ):
        add(mode if mode != ONLY_A else "flip", label, _shower(mode), *([key] if key else []), about=about,
            checked=_shows(mode))  # fmt: skip
    add("go-back", "Go back to A", lambda s: s.comparing.go_back(s), enabled=_has_a,
        about="And take what is there now as A: again brings it back")  # fmt: skip
    add("clear", "Forget A", lambda s: s.comparing.clear(), enabled=_has_a, about="Show the present state alone")
    add("measure", "Measure A and B", _measure, enabled=_has_a, about="Milliseconds of both, rendered in turn")
    for path in PATH_CHOICES:
        if path != "auto":
            add(f"path-{path}", f"This path against {path}", _against(path), enabled=_has_paths,
                about="Both with one sample a pixel: they should give one picture")  # fmt: skip
    add("panel", "Comparison", _panel, about="The numbers of the two")


#: operations that a line of the menu goes before
FIRST = ("wipe", "go-back", "path-forward", "panel")


def _has_document(session: Session) -> bool:
    return session.document is not None


def _has_paths(session: Session) -> bool:
    return session.document is not None and {"path", "samples"} <= session.settings.values().keys()


def _has_a(session: Session) -> bool:
    return session.comparing.moment(session) is not None


def _shower(mode: str) -> Callable[[Session], None]:
    return lambda session: session.comparing.show(session, mode)


def _shows(mode: str) -> Callable[[Session], bool]:
    return lambda session: session.comparing.showing(session) == mode


def _against(path: str) -> Callable[[Session], None]:
    def run(session: Session) -> None:
        settings = session.settings.values()
        drawn: Any = getattr(session.image.frame, "path", None)
        name = drawn.path if drawn is not None else str(settings["path"])
        comparing = session.comparing
        comparing.take(session, f"Path: {name}")
        assert comparing.a is not None
        comparing.a.settings["samples"] = 1
        if settings["path"] == "auto":
            comparing.a.settings["path"] = name
        session.apply_settings({"path": path, "samples": 1}, label=f"Render path: {path}")
        comparing.mode = WIPE
        work.start(session, MeasureBoth())  # the first pictures of a path have its programs made

    return run


def _measure(session: Session) -> None:
    if work.start(session, MeasureBoth()):
        session.ui.focus_panel = "Compare"


def _panel(session: Session) -> None:
    session.ui.focus_panel = "Compare"
