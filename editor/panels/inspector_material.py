"""The inspector's material section: parameters generated from the effect, textures by slot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from imgui_bundle import imgui

from editor import icons, theme
from editor.document import Document
from editor.param_widgets import param_row
from editor.tables import material_values
from editor.ui import Ui
from editor.widgets import em, fitted_text, pretty, property_grid, property_row, property_text, section, text, tooltip


def draw_material(ui: Ui, document: Document, material: int) -> None:
    """One collapsible section for material id `material`. Every change is a command; a drag is one."""
    record = document.runtime.residency.material(material)
    name = record.asset.name or "material"
    if not section(ui, f"{icons.MATERIAL}  {name}###material{material}"):
        return
    imgui.push_id(f"material{material}")
    values = material_values(document.runtime.residency, material)
    with property_grid("params") as shown:
        for param in record.effect.params if shown else ():
            changed, value = param_row(param, values[param.name])
            if changed:
                ui.session.edit(
                    "materials", param.name, [material], [value], gesture=("materials", param.name, material),
                    label=f"{pretty(param.name)} of {name}",
                )  # fmt: skip
    _textures(ui, material, record)
    with property_grid("about") as shown:
        if shown:
            property_text("Effect", record.effect.name)
            property_text("Queue", record.asset.queue)
            if record.asset.features:
                property_text("Features", ", ".join(record.asset.features))
            if record.path:
                property_text("File", Path(record.path).name, record.path)
    imgui.pop_id()
    imgui.spacing()


def _textures(ui: Ui, material: int, record: Any) -> None:
    """Each slot of the effect: the file in it, or that it is empty."""
    with property_grid("textures") as shown:
        for slot in record.effect.textures if shown else ():
            ref = record.asset.textures.get(slot.name)
            property_row(pretty(slot.name.removesuffix("_map")), getattr(slot, "doc", ""), changed=ref is not None)
            imgui.align_text_to_frame_padding()
            if ref is None:
                text("none", theme.FAINT)
            elif not ref.path:
                text(f"{icons.WARNING} missing", theme.WARNING)
                tooltip("The source names a texture that is not there; it is drawn in magenta")
            else:
                _thumbnail(ui, material, slot.name)
                imgui.same_line(0, em(0.4))
                fitted_text(Path(ref.path).name, more=_describe(ref))


def _thumbnail(ui: Ui, material: int, slot: str) -> None:
    """A small picture of the texture, large while the pointer is on it; an icon where there can be none."""
    native = ui.session.thumbnail(material, slot)
    if not native:
        text(icons.PICTURE, theme.INFO)
        return
    size = imgui.get_frame_height()
    imgui.image(imgui.ImTextureRef(native), (size, size))
    if imgui.is_item_hovered():
        imgui.begin_tooltip()
        imgui.image(imgui.ImTextureRef(native), (em(12), em(12)))
        imgui.end_tooltip()


def _describe(ref: Any) -> str:
    lines = [ref.path, f"UV set {ref.uv_set}, wrap {ref.wrap_u} × {ref.wrap_v}"]
    lines.append(f"{ref.mag_filter} / {ref.min_filter}".replace("_", " "))
    if ref.scale != (1.0, 1.0) or ref.offset != (0.0, 0.0) or ref.rotation:
        lines.append(f"offset {ref.offset}, scale {ref.scale}, rotation {ref.rotation:g} rad")
    return "\n".join(lines)
