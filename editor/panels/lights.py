"""Lights: scatter many over the selection or the scene, and repeat what is selected in a line, grid or ring."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from editor import icons, theme
from editor.commands import lights
from editor.document import Document
from editor.flowing import wide_button
from editor.panels.base import Panel
from editor.param_widgets import param_row
from editor.ui import Ui
from editor.widgets import empty_state, pretty, property_grid, property_row, section, wrapped_text
from engine.core.errors import LucarnaError
from engine.core.param import Param
from engine.scene.arrays import OF_SHAPE, ArraySettings
from engine.scene.scatter import ScatterSettings

#: settings that only some choices have
ONLY_WITH = {"size": {"rectangle", "disk"}, "aim": {"spot", "rectangle", "disk"}}


class LightsPanel(Panel):
    title: ClassVar[str] = "Lights"
    icon: ClassVar[str] = icons.LIGHT
    dock: ClassVar[str] = "Right"

    def __init__(self) -> None:
        self.settings = ScatterSettings()
        self.array = ArraySettings()

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
        wrapped_text(f"{table.alive_count:,} lights, {shining:,} of them shining", theme.DIM)
        imgui.spacing()

    def _scatter(self, ui: Ui, document: Document) -> None:
        settings = self.settings
        with property_grid("scatter") as shown:
            for field in settings.PARAMS if shown else ():
                if not _scatter_has(settings, field.name):
                    continue
                changed, new = _row(field, getattr(settings, field.name), "scatter")
                if changed:
                    setattr(settings, field.name, new)
                    if field.name == "box" and new:  # begin with what it would have been
                        settings.box_low, settings.box_high = (_round(v) for v in lights.box_of(document))
        where = "the box" if settings.box else "the selection" if document.selection else "the whole scene"
        if wide_button(f"{icons.LIGHT}  Scatter over {where}###scatter"):
            try:
                lights.scatter(document, settings)
                if settings.drift > 0.0 and not ui.session.playback.playing:
                    ui.session.ui.notice = "They drift while time plays: Space"
            except LucarnaError as error:
                ui.session.fail(error)
        imgui.spacing()

    def _array(self, ui: Ui, document: Document) -> None:
        array = self.array
        with property_grid("array") as shown:
            for field in array.PARAMS if shown else ():
                if field.name == "shape" or field.name in OF_SHAPE[array.shape]:
                    changed, new = _row(field, getattr(array, field.name), "array")
                    if changed:
                        setattr(array, field.name, new)
        if wide_button(f"Make {array.total:,} of the selection###array", enabled=bool(document.selection)):
            try:
                lights.array(document, document.selection, array)
            except LucarnaError as error:
                ui.session.fail(error)
        if not document.selection:
            wrapped_text("Select what is to be repeated", theme.DIM)


def _scatter_has(settings: ScatterSettings, name: str) -> bool:
    if name in ONLY_WITH:
        return settings.kind in ONLY_WITH[name]
    if name in ("box_low", "box_high"):
        return bool(settings.box)
    return name != "last_color" or not settings.all_hues


def _row(field: Param, value: Any, id: str) -> tuple[bool, Any]:
    """As param_row; counts are dragged: a slider to a hundred thousand hits no number."""
    if not field.name.startswith("count"):
        return param_row(field, value, id=id)
    property_row(pretty(field.name), field.doc, changed=value != field.default)
    changed, new = imgui.drag_int(
        f"##{field.name}", value, max(value * 0.005, 0.1), int(field.min), int(field.max), "%d",
        imgui.SliderFlags_.always_clamp,
    )  # fmt: skip
    return bool(changed), int(new)


def _round(corner: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = (round(float(np.clip(v, -1e9, 1e9)), 3) for v in corner)
    return x, y, z


PANEL = LightsPanel
