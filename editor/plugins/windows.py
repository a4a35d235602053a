"""The windows of plug-ins' panels, and the question before a project's plug-ins run. A panel that raises is closed with
what imgui had open for it, and its plug-in switched off."""

from __future__ import annotations

from imgui_bundle import imgui

from editor import icons, theme
from editor.dialogs.modals import begin_card, center_next_window
from editor.plugins.manager import PluginManager, PluginWindow
from editor.strings import tr
from editor.ui import Ui
from editor.widgets import bold, em, fitted_text, text


def draw_windows(ui: Ui, manager: PluginManager) -> None:
    for window in list(manager.windows):
        if window.opened:
            _draw(ui, manager, window)


def _draw(ui: Ui, manager: PluginManager, window: PluginWindow) -> None:
    state = imgui.internal.ErrorRecoveryState()
    imgui.internal.error_recovery_store_state(state)
    imgui.set_next_window_size((em(22), em(16)), imgui.Cond_.first_use_ever)
    try:
        shown, opened = imgui.begin(window.panel.label, True)
        if shown:
            window.panel.draw(ui)
        imgui.end()
        window.opened = bool(opened)
    except Exception as error:  # a plug-in raises what it likes: its window closes, no other
        _recover(state)
        manager.fail(window.owner, error)


def _recover(state: imgui.internal.ErrorRecoveryState) -> None:
    """Close what the panel left open, without imgui's own complaint."""
    io = imgui.get_io()
    kept = io.config_error_recovery_enable_assert, io.config_error_recovery_enable_tooltip
    io.config_error_recovery_enable_assert = io.config_error_recovery_enable_tooltip = False
    imgui.internal.error_recovery_try_to_recover_state(state)
    io.config_error_recovery_enable_assert, io.config_error_recovery_enable_tooltip = kept


class TrustModal:
    """Asks once for each project; "Not now" leaves its plug-ins listed and off."""

    NAME = "Plug-ins of this project"

    def draw(self, ui: Ui) -> None:
        manager = ui.plugins
        if manager is None:
            return
        if manager.asking is not None and not imgui.is_popup_open(self.NAME):
            imgui.open_popup(self.NAME)
        center_next_window(32)
        if not begin_card(self.NAME, modal=True):
            return
        if manager.asking is None:
            imgui.close_current_popup()
        else:
            with bold(ui):
                imgui.text_unformatted(f"{icons.WARNING}  {tr('This project brings plug-ins')}")
            imgui.push_text_wrap_pos(0.0)
            text(tr("They are programs, and can do what you can do. Run them only if you trust where they come from."))
            imgui.pop_text_wrap_pos()
            for loaded in manager.plugins:
                if loaded.state == "waits":
                    fitted_text(loaded.found.source, theme.DIM)
            imgui.spacing()
            if imgui.button(f"{tr('Run them')}##run", (em(8), 0)):
                manager.trust()
            imgui.same_line()
            if imgui.button(f"{tr('Not now')}##later", (em(8), 0)) or imgui.is_key_pressed(imgui.Key.escape):
                manager.decline()
        imgui.end_popup()
