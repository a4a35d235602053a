"""Render settings: every RenderSettings parameter, its widget made from its declaration."""

from __future__ import annotations

from typing import ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.panels.base import Panel
from editor.param_widgets import param_row
from editor.quality import current
from editor.ui import Ui
from editor.widgets import pretty, property_grid, section, text
from engine.core.param import Param
from engine.render.one_sample import along, idle
from engine.render.presets import NAMES

#: heading -> names; what is in none goes under the last
GROUPS: dict[str, tuple[str, ...]] = {
    "Look": ("exposure", "tone_map", "view"),
    "Environment": (
        "environment_intensity", "environment_rotation", "sun_intensity", "background", "background_blur",
    ),
    "Lens": (
        "auto_exposure", "auto_low", "auto_high", "auto_limit", "adapt_darker", "adapt_brighter", "bloom",
        "bloom_radius", "bloom_calm", "depth_of_field", "focus", "f_stop", "sensor",
    ),
    "Quality": (),
}  # fmt: skip


class RenderSettingsPanel(Panel):
    title: ClassVar[str] = "Render settings"
    icon: ClassVar[str] = icons.SETTINGS
    dock: ClassVar[str] = "Right"

    def draw(self, ui: Ui) -> None:
        settings = ui.session.settings
        samples = int(getattr(settings, "samples", 1))
        unused = idle(settings.values())
        self._quality(ui)
        for heading, params in grouped(settings.PARAMS).items():
            if params and section(ui, heading):
                with property_grid(heading) as shown:
                    for param in params if shown else ():
                        why = unused.get(param.name, "")
                        changed, value = param_row(param, getattr(settings, param.name), more=why)
                        if why:
                            imgui.push_text_wrap_pos(0.0)
                            text(f"{icons.WARNING} {why}", theme.WARNING)
                            imgui.pop_text_wrap_pos()
                        if changed and (more := along({param.name: value}, samples)):
                            ui.session.apply_settings({param.name: value, **more}, pretty(param.name))
                        elif changed:
                            setattr(settings, param.name, value)
                imgui.spacing()

    @staticmethod
    def _quality(ui: Ui) -> None:
        """The presets, as one choice over all that they set."""
        names = list(NAMES)
        now = current(ui.session)
        shown = [*names, *([] if now else ["own values"])]
        changed, at = imgui.combo("Quality", shown.index(now or "own values"), shown)
        if changed and at < len(names):
            ui.operations.run(f"view.quality-{names[at]}", ui.session)
        imgui.spacing()


def grouped(params: tuple[Param, ...]) -> dict[str, list[Param]]:
    """The parameters under the headings of GROUPS, in declaration order."""
    rows: dict[str, list[Param]] = {heading: [] for heading in GROUPS}
    last = list(GROUPS)[-1]
    for param in params:
        heading = next((h for h, names in GROUPS.items() if param.name in names), last)
        rows[heading].append(param)
    return rows


PANEL = RenderSettingsPanel
