"""Render settings: every RenderSettings parameter, its widget made from its declaration."""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase
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

#: heading -> names, or what they begin with; what is in none goes under the last
GROUPS: dict[str, tuple[str, ...]] = {
    "Look": ("exposure", "tone_map", "view"),
    "Environment": (
        "environment_intensity", "environment_rotation", "sun_intensity", "background", "background_blur",
    ),
    "Lens": (
        "auto_exposure", "auto_low", "auto_high", "auto_limit", "adapt_darker", "adapt_brighter", "bloom",
        "bloom_radius", "bloom_calm", "depth_of_field", "focus", "f_stop", "sensor", "focus_taps",
    ),
    "Edges": ("samples", "antialias", "smaa_*", "taa_*", "alpha_to_coverage"),
    "Shadows": ("shadows", "shadow_*", "translucent_shadows", "sun_angle", "local_shadow*", "soft_lamps"),
    "Ambient occlusion": ("ambient_occlusion", "ao_*"),
    "Light between surfaces": ("gi", "gi_*", "reflection*"),
    "Quality": (),
}  # fmt: skip


#: names, or what they begin with -> settings with values that want nothing of them: where all have, they are not shown
PARTS_OF: dict[str, dict[str, tuple[object, ...]]] = {
    "taa_*": {"antialias": ("none", "fxaa", "smaa")},
    "smaa_*": {"antialias": ("none", "fxaa", "taa")},
    "ao_*": {"ambient_occlusion": ("off",)},
    "gi_*": {"gi": ("off",), "reflections": (False,)},  # reflections look into the same layers
    "reflection_*": {"reflections": (False,)},
    "auto_l*": {"auto_exposure": (False,)},
    "auto_high": {"auto_exposure": (False,)},
    "adapt_*": {"auto_exposure": (False,)},
    "bloom_*": {"bloom": (0.0,)},
    "focus*": {"depth_of_field": (False,)},
    "f_stop": {"depth_of_field": (False,)},
    "sensor": {"depth_of_field": (False,)},
    "alpha_to_coverage": {"samples": (1,)},
}


class RenderSettingsPanel(Panel):
    title: ClassVar[str] = "Render settings"
    icon: ClassVar[str] = icons.SETTINGS
    dock: ClassVar[str] = "Right"

    def draw(self, ui: Ui) -> None:
        settings = ui.session.settings
        samples = int(getattr(settings, "samples", 1))
        values = settings.values()
        unused = idle(values)
        self._quality(ui)
        for heading, params in grouped(settings.PARAMS).items():
            if params and section(ui, heading):
                with property_grid(heading) as shown:
                    for param in params if shown else ():
                        if not means(param.name, values):
                            continue
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


def means(name: str, values: Mapping[str, object]) -> bool:
    """Whether a parameter says anything beside these settings: those of what is off need no place."""
    wholes = next((of for pattern, of in PARTS_OF.items() if fnmatchcase(name, pattern)), {})
    return not wholes or any(values.get(whole) not in off for whole, off in wholes.items())


def grouped(params: tuple[Param, ...]) -> dict[str, list[Param]]:
    """The parameters under the headings of GROUPS, in declaration order."""
    rows: dict[str, list[Param]] = {heading: [] for heading in GROUPS}
    last = list(GROUPS)[-1]
    for param in params:
        heading = next((h for h, names in GROUPS.items() if any(fnmatchcase(param.name, n) for n in names)), last)
        rows[heading].append(param)
    return rows


PANEL = RenderSettingsPanel
