"""Operations on the window's arrangement: workspaces, slots, themes. No imgui."""

from __future__ import annotations

from collections.abc import Callable

from editor.operations import Operation, Operations
from editor.preferences import THEMES
from editor.session import Session

#: as layout.WORKSPACES, which imports imgui; a test holds them together
WORKSPACES = ("Edit", "Animate", "Shade", "Review")
SLOTS = (1, 2, 3)


def add_layout_operations(ops: Operations) -> None:
    """Add them all to the registry."""

    def add(id: str, label: str, run: Callable[[Session], None], *keys: str, first: bool = False, about: str = "",
            checked: Callable[[Session], bool] | None = None) -> None:  # fmt: skip
        ops.add(Operation(id, label, run, "Window", keys, checked=checked, separator=first, doc=about))

    for i, name in enumerate(WORKSPACES):
        add(f"layout.{name.lower()}", f"Workspace: {name}", _workspace(name), f"Ctrl+F{i + 1}", first=i == 0,
            checked=_in(name), about="Each is remembered as you arrange it")  # fmt: skip
    add("view.reset-layout", "Reset layout", _reset, first=True, about="This workspace as it came")
    for slot in SLOTS:
        add(f"layout.save-{slot}", f"Save layout {slot}", _slot("save", slot), first=slot == 1)
    for slot in SLOTS:
        add(f"layout.load-{slot}", f"Load layout {slot}", _slot("load", slot))
    for i, theme in enumerate(THEMES):
        add(
            f"view.theme-{theme}", f"Theme: {theme.replace('-', ' ')}", _theme(theme), first=i == 0, checked=_has(theme)
        )


def _workspace(name: str) -> Callable[[Session], None]:
    def run(session: Session) -> None:
        session.ui.workspace = name

    return run


def _in(name: str) -> Callable[[Session], bool]:
    return lambda session: session.preferences.workspace == name


def _reset(session: Session) -> None:
    session.ui.reset_layout = True


def _slot(what: str, slot: int) -> Callable[[Session], None]:
    def run(session: Session) -> None:
        session.ui.layout_slot = (what, slot)

    return run


def _theme(name: str) -> Callable[[Session], None]:
    def run(session: Session) -> None:
        session.preferences.theme = name
        session.ui.scale_changed = True
        session.remember()

    return run


def _has(name: str) -> Callable[[Session], bool]:
    return lambda session: session.preferences.theme == name
