"""Lights: scatter many over the selection or the scene, and repeat what is selected in an array."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from imgui_bundle import imgui

from editor import icons, theme
from editor.commands import lights
from editor.document import Document
from editor.panels.base import Panel
from editor.param_widgets import param_row
from editor.ui import Ui
from editor.widgets import em, empty_state, property_grid, property_row, section, text
from engine.core.errors import LucarnaError
from engine.scene.scatter import ScatterSettings

#: settings that only some choices have
ONLY_WITH = {"size": {"rectangle", "disk"}, "aim": {"spot", "rectangle", "disk"}}


class LightsPanel(Panel):
    title: ClassVar[str] = "Lights"
    icon: ClassVar[str] = icons.LIGHT
    dock: ClassVar[str] = "Right"

    def __init__(self) -> None:
        self.settings = ScatterSettings()
        self.counts = [3, 1, 1]
        self.step = [1.0, 1.0, 1.0]

    def draw(self, ui: Ui) -> None:
        document = ui.session.document
        if document is None:
            empty_state(icons.LIGHT, "No scene to light")
            return
        self._present(document)
        if section(ui, "Scatter"):
            self._scatter(ui, document)
        if section(ui, "Array"):
            self._array(ui, document)

    def _present(self, document: Document) -> None:
        table = document.runtime.scene.lights
        shining = len(table.shining())
        text(f"{table.alive_count:,} lights, {shining:,} of them shining", theme.DIM)
        imgui.spacing()

    def _scatter(self, ui: Ui, document: Document) -> None:
        with property_grid("scatter") as shown:
            for field in self.settings.PARAMS if shown else ():
                value = getattr(self.settings, field.name)
                if field.name in ONLY_WITH and self.settings.kind not in ONLY_WITH[field.name]:
                    continue
                if field.name == "last_color" and self.settings.all_hues:
                    continue
                if field.name == "count":  # a slider to a hundred thousand hits no number
                    property_row("Count", field.doc, changed=value != field.default)
                    changed, new = imgui.drag_int(
                        "##count", value, max(value * 0.005, 0.2), int(field.min), int(field.max), "%d",
                        imgui.SliderFlags_.always_clamp,
                    )  # fmt: skip
                else:
                    changed, new = param_row(field, value, id="scatter")
                if changed:
                    setattr(self.settings, field.name, new)
        where = "the selection" if document.selection else "the whole scene"
        if imgui.button(f"{icons.LIGHT}  Scatter over {where}###scatter", (-1, em(2.0))):
            try:
                lights.scatter(document, self.settings)
            except LucarnaError as error:
                ui.session.fail(error)
        imgui.spacing()

    def _array(self, ui: Ui, document: Document) -> None:
        with property_grid("array") as shown:
            if shown:
                property_row("Count", "How many along X, Y and Z, the original being the first")
                _changed, counts = imgui.drag_int3("##counts", self.counts, 0.1, 1, 1000)
                self.counts = [min(max(int(c), 1), 1000) for c in counts]
                property_row("Step", "Metres from one to the next along X, Y and Z")
                _changed, step = imgui.drag_float3("##step", self.step, 0.02, 0, 0, "%.2f")
                self.step = [float(s) if np.isfinite(s) else 0.0 for s in step]
        imgui.begin_disabled(not document.selection)
        copies = int(np.prod(self.counts))
        if imgui.button(f"Make {copies:,} of the selection###array", (-1, em(2.0))):
            try:
                lights.array(document, document.selection, self.counts, self.step)
            except LucarnaError as error:
                ui.session.fail(error)
        imgui.end_disabled()


PANEL = LightsPanel
