"""The light of the selected node: kind, colour, how bright in a unit of the user's choice, reach, shape, profile."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from imgui_bundle import imgui

from editor import icons, theme
from editor.document import Document
from editor.param_widgets import param_row
from editor.requests import ChooseFile
from editor.ui import Ui
from editor.widgets import em, icon_button, property_grid, property_row, property_text, section, text
from engine.assets.ies import PhotometricProfile, read_ies
from engine.assets.scene import LightAsset
from engine.core.errors import InputError
from engine.core.param import Param
from engine.math.photometry import NATIVE_UNIT, UNITS, from_native, to_native
from engine.scene.lights import LIGHT_TYPES

_PI = math.pi
_FIELDS = (
    Param("type", "enum", "point", choices=LIGHT_TYPES, doc="What the light is; its brightness keeps its number"),
    Param("color", "color3", (1.0, 1.0, 1.0), 0.0, 1.0, doc="Scene-linear Rec.709"),
    Param(
        "temperature", "float", 0.0, 0.0, 40_000.0, 10.0, "K", doc="Colour of a black body, times the colour; 0 = none"
    ),
    Param("range", "float", 0.0, 0.0, unit="m", doc="Where the light ends, from its nearest point; 0 = never"),
    Param("inner_angle", "float", 0.0, 0.0, _PI / 2, unit="rad", doc="Half angle of the full brightness"),
    Param("outer_angle", "float", _PI / 4, 0.0, _PI / 2, unit="rad", doc="Half angle where the light ends"),
    Param("width", "float", 1.0, 0.0, unit="m", doc="Along the node's X; the node's scale changes nothing"),
    Param("height", "float", 1.0, 0.0, unit="m", doc="Along the node's Y"),
    Param("two_sided", "bool", False, doc="Shine to the back, too"),
    Param("casts_shadow", "bool", False, doc="Things hide its light (costs a depth map, six but for a spot)"),
    Param("radius", "float", 0.0, 0.0, unit="m", doc="Of what shines: the larger, the softer its shadows"),
)
FIELDS = {f.name: dataclasses.replace(f, default=getattr(LightAsset(), f.name)) for f in _FIELDS}
FIELDS["type"] = dataclasses.replace(FIELDS["type"], default="point")
#: what each kind has besides its brightness
OF_KIND: dict[str, tuple[str, ...]] = {
    "directional": (),
    "point": ("range", "casts_shadow", "radius", "profile"),
    "spot": ("range", "inner_angle", "outer_angle", "casts_shadow", "radius", "profile"),
    "rectangle": ("range", "width", "height", "two_sided", "casts_shadow"),
    "disk": ("range", "width", "height", "two_sided", "casts_shadow"),
}
#: unit -> what it says
UNIT_DOCS = {
    "candela": "cd: how bright it looks from where it shines", "lumen": "lm: all the light it gives",
    "watt": "W of an LED lamp of 110 lm/W", "lux at 1 m": "lx on a surface one metre away",
    "lux": "lx on a surface that faces it", "nit": "cd/m²: how bright its surface looks",
}  # fmt: skip


class LightEditor:
    """`unit` remembers, by kind, in what brightness is shown."""

    def __init__(self) -> None:
        self.unit = dict(NATIVE_UNIT)
        self._profiles: dict[tuple[Path, float], PhotometricProfile | str] = {}

    def draw(self, ui: Ui, document: Document, row: int) -> None:
        """All fields of light `row`; all selected lights get what is edited."""
        table = document.runtime.scene.lights
        light: LightAsset = table.asset(row)
        if not section(ui, f"{icons.LIGHT}  {light.type.capitalize()} light"):
            return
        selected = np.flatnonzero(table.alive & np.isin(table.node, document.selection)).tolist()
        rows = [row, *(r for r in selected if r != row)]
        with property_grid(f"light{row}") as shown:
            if shown:
                for name in ("type", "color", "temperature"):
                    self._field(ui, rows, light, name)
                self._brightness(ui, rows, light)
                for name in OF_KIND[light.type]:
                    if name == "profile":
                        self._profile(ui, document, rows, light)
                    else:
                        self._field(ui, rows, light, name)
        imgui.spacing()

    def _field(self, ui: Ui, rows: Sequence[int], light: LightAsset, name: str) -> None:
        field = FIELDS[name]
        label = "Kind" if name == "type" else "Width" if name == "width" else ""
        if name == "type":
            field = dataclasses.replace(field, default=light.type)  # a kind is no departure from a default
        changed, new = param_row(field, getattr(light, name), id=f"light{rows[0]}", label=label,
                                 degrees=field.unit == "rad")  # fmt: skip
        if changed:
            _set(ui, rows, name, new)

    def _brightness(self, ui: Ui, rows: Sequence[int], light: LightAsset) -> None:
        """The intensity in the unit chosen; where the light has no extent for it, in its own unit."""
        unit = self.unit[light.type]
        try:
            value = from_native(light.intensity, unit, light.type, **shape_of(light))
        except InputError:
            unit = NATIVE_UNIT[light.type]
            value = light.intensity
        property_row(
            "Brightness", f"{UNIT_DOCS[unit]}\nKept in {NATIVE_UNIT[light.type]}", changed=light.intensity != 1.0
        )
        imgui.push_id(f"brightness{rows[0]}")
        room = imgui.get_content_region_avail().x
        imgui.set_next_item_width(max(room - em(6.6), 0.45 * room))  # the number before its unit, where both are short
        changed, new = imgui.drag_float(
            "##value", value, max(value * 0.01, 0.001), 0.0, 1e12, "%.4g", imgui.SliderFlags_.always_clamp
        )
        if changed and math.isfinite(new):
            _set(ui, rows, "intensity", to_native(max(float(new), 0.0), unit, light.type, **shape_of(light)))
        imgui.same_line(0, em(0.3))
        imgui.set_next_item_width(-1)
        units = UNITS[light.type]
        picked, index = imgui.combo("##unit", units.index(unit), list(units))
        if picked:
            self.unit[light.type] = units[index]
        imgui.pop_id()

    def _profile(self, ui: Ui, document: Document, rows: Sequence[int], light: LightAsset) -> None:
        property_row(
            "Profile", "An IES file that shapes the light: its path, relative to the scene", changed=bool(light.profile)
        )
        imgui.push_id(f"profile{rows[0]}")
        imgui.set_next_item_width(-em(4.6 if light.profile else 2.3))
        flags = imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.auto_select_all
        _entered, path = imgui.input_text_with_hint("##path", "file.ies", light.profile, flags)
        if imgui.is_item_deactivated_after_edit() and path.strip() != light.profile:
            _set(ui, rows, "profile", path.strip().replace("\\", "/"))
        folder = Path(document.runtime.scene.folder)
        imgui.same_line(0, em(0.2))
        if icon_button(f"{icons.FOLDER_OPEN}###choose", "Choose an IES file…"):
            ui.session.ui.choose = ChooseFile(
                "Choose an IES file", (".ies",), folder / light.profile,
                lambda path: _set(ui, rows, "profile", _from(path, folder)),
            )  # fmt: skip
        if light.profile:
            imgui.same_line(0, em(0.2))
            if icon_button(f"{icons.RESET}###none", "No profile: shine evenly"):
                _set(ui, rows, "profile", "")
        imgui.pop_id()
        if not light.profile:
            return
        found = self._read(folder / light.profile)
        if isinstance(found, str):
            property_row("", found)
            imgui.push_text_wrap_pos(0.0)
            text(f"{icons.WARNING}  {found}", theme.ERROR)
            imgui.pop_text_wrap_pos()
            return
        property_text("Of the file", f"{found.peak:.4g} cd, {found.lumens or found.flux():.4g} lm", _labels(found))
        property_row("", "Take the brightness that the maker measured")
        if imgui.button(f"Use its {found.peak:.4g} cd##absolute", (-1, 0)):
            _set(ui, rows, "intensity", found.peak)

    def _read(self, path: Path) -> PhotometricProfile | str:
        """The profile, or what is wrong with it; read again when the file changes."""
        try:
            key = (path, path.stat().st_mtime)
        except OSError as error:
            return f"{path.name}: {error.strerror}"
        if key not in self._profiles:
            try:
                self._profiles[key] = read_ies(path)
            except InputError as error:
                self._profiles[key] = str(error).replace(str(path), path.name)
        return self._profiles[key]


def _from(path: Path, folder: Path) -> str:
    """How a scene in `folder` names a file: relative where it can; saving copies what lies elsewhere."""
    try:
        return path.resolve().relative_to(folder.resolve()).as_posix()
    except ValueError:
        return path.resolve().as_posix()


def shape_of(light: LightAsset) -> dict[str, Any]:
    """What photometry needs to know of a light."""
    return {
        "inner": light.inner_angle, "outer": light.outer_angle, "width": light.width, "height": light.height,
        "two_sided": light.two_sided,
    }  # fmt: skip


def _labels(profile: PhotometricProfile) -> str:
    return "\n".join(f"{key}: {value}" for key, value in profile.labels.items()) or "No labels"


def _set(ui: Ui, rows: Sequence[int], name: str, value: Any) -> None:
    ui.session.edit("lights", name, rows, [value] * len(rows), gesture=("lights", name, rows[0]))
