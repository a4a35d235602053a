"""Compare: state A against the present one in numbers, and what can be done with the two."""

from __future__ import annotations

from typing import ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.comparing.comparing import DIFFERENCE, ONLY_A, WIPE
from editor.flowing import flow_button
from editor.panels.base import Panel
from editor.ui import Ui
from editor.widgets import empty_state, property_grid, property_row, property_text, text, tooltip, wrapped_text
from engine.render.lighting import PATH_CHOICES

MODES = ((WIPE, "Wipe"), (ONLY_A, "A alone"), (DIFFERENCE, "Difference"))


class ComparePanel(Panel):
    title: ClassVar[str] = "Compare"
    icon: ClassVar[str] = icons.COMPARE
    dock: ClassVar[str] = "BottomRight"
    opened: ClassVar[bool] = False

    def draw(self, ui: Ui) -> None:
        session = ui.session
        if session.document is None:
            empty_state(icons.COMPARE, "Nothing open")
            return
        a = session.comparing.moment(session)
        if _button(ui, "compare.take", "Take A", first=True):
            return
        if a is not None:
            for mode, label in MODES:
                id = "compare.flip" if mode == ONLY_A else f"compare.{mode}"
                _button(ui, id, label, active=session.comparing.showing(session) == mode)
            _button(ui, "compare.go-back", "Go back to A")
            _button(ui, "compare.measure", "Measure")
            _button(ui, "compare.clear", "Forget")
        imgui.spacing()
        self._numbers(ui)
        imgui.spacing()
        text("This path against", theme.DIM)
        for path in PATH_CHOICES:
            if path != "auto":
                _button(ui, f"compare.path-{path}", path, first=path == PATH_CHOICES[1])

    def _numbers(self, ui: Ui) -> None:
        session = ui.session
        comparing, a = session.comparing, session.comparing.moment(session)
        if a is None:
            wrapped_text(
                "A is a state to look back at: edits, render settings, path. Take it, change something, wipe.",
                theme.DIM,
            )
            return
        difference, times = comparing.difference, comparing.times()
        with property_grid("numbers") as shown:
            if not shown:
                return
            property_text("A", a.label + ("  (its last picture)" if a.frozen else ""))
            changed = sorted(n for n, v in session.settings.values().items() if a.settings.get(n) != v)
            property_text("Settings that differ", ", ".join(changed) or "none")
            if times[0] and times[1]:
                how = "in turn" if comparing.measured else "last pictures"
                property_text("Milliseconds", f"{times[0]:.2f} → {times[1]:.2f}  ({times[1] / times[0]:.2f} ×, {how})")
            if difference is None:
                property_text("Difference", "shown once A is looked at")
                return
            if difference.equal:
                property_text("Difference", "none: equal in every pixel")
                return
            flip = comparing.flip
            property_row("FLIP", "Mean over the picture: 0 nothing to be seen, 1 black against white")
            if flip is None:
                text("…", theme.DIM)
            elif isinstance(flip, float):
                imgui.text_unformatted(f"{flip:.5f}")
            else:
                text("not to be had", theme.DIM)
                tooltip(flip)
            x, y = difference.worst
            property_text("Largest difference", f"{difference.largest} of 255, at {x}, {y}")
            property_text("RMSE", f"{difference.rmse:.3f} of 255")
            share = 100 * difference.differing
            property_text("Pixels that differ", f"{share:.3g} % of {difference.width} × {difference.height}")


def _button(ui: Ui, id: str, label: str, *, active: bool = False, first: bool = False) -> bool:
    """The operation as a button; True when it ran."""
    operation = ui.operations[id]
    key = f" ({operation.shortcuts[0]})" if operation.shortcuts else ""
    hint = f"{operation.label}{key}\n{operation.doc}".strip()
    enabled = operation.enabled(ui.session)
    pressed = flow_button(f"{label}##{id}", hint, first=first, active=active, enabled=enabled)
    return pressed and ui.operations.run(id, ui.session)


PANEL = ComparePanel
