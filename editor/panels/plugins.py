"""Plug-ins: which there are, whether they are on, what went wrong with them, and the parameters of their passes."""

from __future__ import annotations

from typing import ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.panels.base import Panel
from editor.param_widgets import param_row
from editor.plugins.manager import Loaded, PluginManager
from editor.strings import tr
from editor.ui import Ui
from editor.widgets import bold, em, empty_state, fitted_text, property_grid, text, tooltip

COLORS = {"on": "GOOD", "failed": "ERROR", "waits": "WARNING", "off": "FAINT"}
WORDS = {"on": "on", "failed": "failed", "waits": "waits for your word", "off": "off"}


class PluginsPanel(Panel):
    title: ClassVar[str] = "Plug-ins"
    icon: ClassVar[str] = icons.PLUGIN
    dock: ClassVar[str] = "Right"
    opened: ClassVar[bool] = False

    def draw(self, ui: Ui) -> None:
        manager = ui.plugins
        if manager is None or not manager.active:
            empty_state(icons.PLUGIN, tr("Plug-ins are not loaded"), tr("The editor was started with --no-plugins"))
            return
        if not manager.plugins:
            empty_state(
                icons.PLUGIN, tr("No plug-ins"), tr("Files in a project's plugins folder, or installed packages")
            )
            return
        for loaded in list(manager.plugins):
            imgui.push_id(loaded.name)
            self._plugin(ui, manager, loaded)
            imgui.pop_id()
        imgui.spacing()
        if imgui.button(f"{tr('Load again')}##reload"):
            manager.reload()

    def _plugin(self, ui: Ui, manager: PluginManager, loaded: Loaded) -> None:
        changed, wanted = imgui.checkbox("##on", loaded.state in ("on", "failed"))
        if changed and loaded.state == "waits":
            manager.trust()
        elif changed:
            manager.set_wanted(loaded, wanted)
        imgui.same_line()
        with bold(ui):
            text(loaded.name)
        imgui.same_line(0, em(0.8))
        text(tr(WORDS[loaded.state]), theme.named(COLORS[loaded.state]))
        tooltip(loaded.found.source)
        if loaded.error:
            imgui.push_text_wrap_pos(0.0)
            text(loaded.error, theme.ERROR)
            imgui.pop_text_wrap_pos()
        for name in list(loaded.passes):
            self._pass(ui, name)
        for window in manager.windows:
            if window.owner is loaded:
                _, window.opened = imgui.checkbox(window.panel.title, window.opened)

    def _pass(self, ui: Ui, name: str) -> None:
        from engine.render.extra_passes import EXTRA

        params = EXTRA.params.get(name)
        if params is None:
            return
        fitted_text(name, theme.DIM)
        with property_grid(name) as shown:
            for param in params.PARAMS if shown else ():
                changed, value = param_row(param, getattr(params, param.name))
                if changed:
                    setattr(params, param.name, value)
                    ui.session.image.invalidate()


PANEL = PluginsPanel
