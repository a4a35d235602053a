"""BRDF explorer: the lobe of a material, its albedo by angle, its furnace error, its terms. Follows the sliders."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np
from imgui_bundle import imgui, implot
from numpy.typing import NDArray

from editor import icons, theme
from editor.flowing import button_width, flow_field
from editor.material_editing import materials_of
from editor.panels.base import Panel
from editor.panels.report import ensure_context
from editor.strings import tr
from editor.tables import material_values
from editor.ui import Ui
from editor.widgets import em, empty_state, fitted, fitted_text, flow, flow_text, icon_button, text, tooltip
from engine.materials.lobe_plots import DECADES, LobePlots, half_angles, plots_of

F8 = NDArray[np.float64]
WHITE = (0.95, 0.95, 0.95, 1.0)
#: colours of F's channels
CHANNELS = ((0.90, 0.38, 0.34, 1.0), (0.42, 0.76, 0.42, 1.0), (0.40, 0.62, 0.95, 1.0))
PART_COLORS = {"diffuse": 0, "specular": 1, "sheen": 2, "coat": 3, "passes": 5}


class BrdfExplorerPanel(Panel):
    title: ClassVar[str] = "BRDF explorer"
    icon: ClassVar[str] = icons.RULER
    dock: ClassVar[str] = "MainDockSpace"
    opened: ClassVar[bool] = False

    def __init__(self) -> None:
        self.incidence = 45.0
        self.logarithmic = True
        self.across = False
        #: the material that it stays with, or -1: that of the selection
        self.pinned = -1
        self._key: object = None
        self.plots: LobePlots | None = None

    def draw(self, ui: Ui) -> None:
        session = ui.session
        document = session.document
        found = materials_of(document, [document.primary]) if document is not None else []
        if document is None or (not found and not 0 <= self.pinned < len(document.runtime.residency.materials.records)):
            empty_state(icons.MATERIAL, "No material", "Select something that has one")
            return
        residency = document.runtime.residency
        material = self.pinned if 0 <= self.pinned < len(residency.materials.records) else found[0]
        record = residency.material(material)
        self._bar(material, record)
        values = dict(material_values(residency, material))
        self.refresh(record, values)
        if self.plots is None:
            what = "an unlit surface" if "unlit" in record.asset.features else f"effect {record.effect.name!r}"
            empty_state(icons.MATERIAL, "No lobe", f"{what} reflects by none that is known here")
            return
        for wrong, advice in self.plots.pairs:
            fitted_text(f"{icons.WARNING}  {wrong}", theme.WARNING, more=advice)
        self._plots(self.plots)

    def refresh(self, record: Any, values: dict[str, Any]) -> None:
        """Compute the curves again where something they depend on is another."""
        asset = record.asset
        key = (id(record.effect), tuple(asset.features), tuple(asset.textures), repr(sorted(values.items())),
               self.incidence, self.across)  # fmt: skip
        if key != self._key:
            self._key = key
            self.plots = plots_of(record.effect, record.asset, values, math.radians(self.incidence), across=self.across)

    # --- the bar ---

    def _bar(self, material: int, record: Any) -> None:
        if icon_button(
            f"{icons.PIN}###pin", "Stay with this material, or follow the selection", active=self.pinned >= 0
        ):
            self.pinned = -1 if self.pinned >= 0 else material
        imgui.same_line(0, em(0.4))
        imgui.align_text_to_frame_padding()
        name = f"{record.asset.name or 'material'} ({record.effect.name})"
        text(fitted(name, min(em(14), imgui.get_content_region_avail().x)))
        flow_field(9, gap=0.8)
        changed, value = imgui.slider_float("##incidence", self.incidence, 0.0, 89.0, "light at %.0f°")
        tooltip("Angle of the light from the normal; its mirror direction is to the right")
        if changed:
            self.incidence = float(value)
        flow(button_width(tr("Logarithmic")) + em(1.5), 0.6)
        _, self.logarithmic = imgui.checkbox("Logarithmic", self.logarithmic)
        tooltip(f"The lobe over {DECADES:.0f} decades, or linear to its greatest value")
        if "anisotropy" in record.asset.features:
            flow(button_width(tr("Across the grain")) + em(1.5), 0.6)
            _, self.across = imgui.checkbox("Across the grain", self.across)
            tooltip("The slice lies along the bitangent instead of the tangent")
        if self.plots is not None:
            least, most = self.plots.furnace_error
            good = most <= 0.005
            flow_text(f"furnace {least:+.3f} to {most:+.3f}", theme.DIM if good else theme.WARNING, gap=0.8)
            notes = "\n".join(self.plots.notes)
            tooltip("What a white lobe loses, or above 0 makes, of the light it gets" + (f"\n{notes}" if notes else ""))

    # --- plots ---

    def _plots(self, plots: LobePlots) -> None:
        ensure_context()
        room = imgui.get_content_region_avail()
        columns = max(1, min(2, int(room.x / em(15))))
        rows = -(-4 // columns)
        size = imgui.ImVec2(room.x / columns - em(0.4), max(room.y / rows - em(0.3), em(9)))
        for i, draw in enumerate((self._lobe, self._albedo, self._distribution, self._terms)):
            if i % columns:
                imgui.same_line(0, em(0.3))
            draw(plots, size)

    def _lobe(self, plots: LobePlots, size: Any) -> None:
        flags = implot.Flags_.equal | implot.Flags_.no_menus | implot.Flags_.no_box_select | implot.Flags_.no_mouse_text
        if not implot.begin_plot("Lobe", size, flags):
            return
        bare = implot.AxisFlags_.no_decorations
        implot.setup_axes("", "", bare, bare)
        implot.setup_axes_limits(-1.1, 1.1, -0.08, 1.12, implot.Cond_.once)
        implot.setup_legend(implot.Location_.north_west)
        ring = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 91)
        for radius in (0.25, 0.5, 0.75, 1.0):
            implot.plot_line(
                f"##ring{radius}", radius * np.sin(ring), radius * np.cos(ring), spec=_spec(theme.FAINT, 0.6)
            )
        implot.plot_line("##ground", np.array([-1.05, 1.05]), np.zeros(2), spec=_spec(theme.DIM, 1.0))
        light = -plots.incidence
        implot.plot_line(
            "light", np.array([math.sin(light), 0.0]), np.array([math.cos(light), 0.0]), spec=_spec(WHITE, 1.4)
        )
        for part in plots.polar:
            r = plots.radius(part, logarithmic=self.logarithmic)
            implot.plot_line(
                part, _row(r * np.sin(plots.out)), _row(r * np.cos(plots.out)), spec=_spec(_color(part), 2.0)
            )
        implot.end_plot()

    def _albedo(self, plots: LobePlots, size: Any) -> None:
        if not _begin("Albedo", size, "degrees", 90.0, max(1.15, float(plots.total.max()) + 0.05)):
            return
        implot.plot_line("##one", np.array([0.0, 90.0]), np.ones(2), spec=_spec(theme.DIM, 1.0))
        for part, value in plots.albedo.items():
            implot.plot_line(part, plots.theta, _row(value), spec=_spec(_color(part), 1.6))
        implot.plot_line("all", plots.theta, _row(plots.total), spec=_spec(WHITE, 2.0))
        implot.plot_line("furnace", plots.theta, _row(plots.furnace), spec=_spec(theme.SERIES[4], 1.6))
        implot.end_plot()

    def _distribution(self, plots: LobePlots, size: Any) -> None:
        flags = implot.Flags_.no_menus | implot.Flags_.no_box_select
        if not implot.begin_plot("D", size, flags):
            return
        most = max(float(plots.d.max()), 1e-9)
        least = max(most * 1e-5, 0.5 * float(plots.d.min()))
        implot.setup_axes("degrees of h", "")
        implot.setup_axis_scale(implot.ImAxis_.y1, implot.Scale_.log10)
        implot.setup_axes_limits(0.0, 90.0, least, most * 2.0, implot.Cond_.always)
        implot.plot_line("D", half_angles(), _row(np.maximum(plots.d, least)), spec=_spec(theme.SERIES[0], 2.0))
        implot.end_plot()

    def _terms(self, plots: LobePlots, size: Any) -> None:
        if not _begin("F and G", size, "degrees", 90.0, 1.05):
            return
        for i, name in enumerate(("F red", "F green", "F blue")):
            implot.plot_line(name, plots.theta, _row(plots.f[:, i]), spec=_spec(CHANNELS[i], 1.6))
        implot.plot_line("G", plots.theta, _row(plots.g), spec=_spec(WHITE, 1.6))
        implot.end_plot()


def _begin(title: str, size: Any, label: str, x: float, y: float) -> bool:
    if not implot.begin_plot(title, size, implot.Flags_.no_menus | implot.Flags_.no_box_select):
        return False
    implot.setup_axes(label, "")
    implot.setup_axes_limits(0.0, x, 0.0, y, implot.Cond_.always)
    implot.setup_legend(implot.Location_.north_west)
    return True


def _row(values: F8) -> F8:
    """Contiguous, as the plots want it."""
    return np.ascontiguousarray(values)


def _color(part: str) -> theme.Rgba:
    return theme.SERIES[PART_COLORS[part]]


def _spec(color: Any, weight: float) -> Any:
    spec = implot.Spec()
    spec.line_color = imgui.ImVec4(*color)
    spec.line_weight = weight
    return spec


PANEL = BrdfExplorerPanel
