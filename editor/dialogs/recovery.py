"""Asks, after a session that died, what becomes of its unsaved edits."""

from __future__ import annotations

import time

from imgui_bundle import imgui

from editor import icons, theme
from editor.dialogs.modals import begin_card, center_next_window
from editor.journal import discard
from editor.recovering import recover
from editor.strings import tr
from editor.ui import Ui
from editor.widgets import bold, em, fitted_text, text


class RecoveryModal:
    """One question per journal, the newest first. "Later" keeps the files for the next start."""

    NAME = "Unsaved edits"

    def draw(self, ui: Ui) -> None:
        waiting = ui.session.ui.recoveries
        if waiting and ui.session.job is None and not imgui.is_popup_open(self.NAME):
            imgui.open_popup(self.NAME)
        center_next_window(30)
        if not begin_card(self.NAME, modal=True):
            return
        if not waiting:
            imgui.close_current_popup()
        else:
            recovery = waiting[0]
            with bold(ui):
                imgui.text_unformatted(f"{icons.WARNING}  Lucarna did not close in good order")
            edits = f"{recovery.edits} unsaved edit{'s' if recovery.edits != 1 else ''}"
            text(f"{recovery.name}: {tr(edits)}, {tr(_ago(time.time() - recovery.modified))}", theme.TEXT)
            fitted_text(str(recovery.source), theme.DIM)
            imgui.spacing()
            if imgui.button("Restore", (em(6), 0)):
                waiting.pop(0)
                recover(ui.session, recovery)
            imgui.same_line()
            if imgui.button("Later", (em(6), 0)) or imgui.is_key_pressed(imgui.Key.escape):
                waiting.pop(0)
            imgui.same_line()
            if imgui.button("Discard", (em(6), 0)):
                waiting.pop(0)
                discard(recovery.path)
        imgui.end_popup()


def _ago(seconds: float) -> str:
    for limit, unit in ((86400.0, "day"), (3600.0, "hour"), (60.0, "minute")):
        if seconds >= limit:
            count = int(seconds / limit)
            return f"{count} {unit}{'s' if count != 1 else ''} ago"
    return "a moment ago"
