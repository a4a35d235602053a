"""What bends a node's mesh, in the inspector: a slider for each morph target, and how its skin is blended."""

from __future__ import annotations

from imgui_bundle import imgui

from editor import icons
from editor.document import Document
from editor.ui import Ui
from editor.widgets import property_grid, property_row, property_text, section
from engine.scene.skins import METHODS


def draw_deforming(ui: Ui, document: Document, row: int) -> None:
    """Sections for the morph targets and the skin of the node `row`, where it has some."""
    scene = document.runtime.scene
    morph, skin = int(scene.morphs.of_nodes([row])[0]), int(scene.skins.of_nodes([row])[0])
    if morph >= 0 and section(ui, f"{icons.BLEND}  Morph targets"):
        weights = [float(w) for w in scene.morphs.of_node(row)]
        with property_grid("morphs") as shown:
            for i, name in enumerate(scene.morphs.names[morph] if shown else ()):
                property_row(name, "Weight; beyond 0 to 1 with Ctrl and a click")
                changed, value = imgui.slider_float(f"##morph{i}", weights[i], 0.0, 1.0)
                if changed:
                    wanted = (*weights[:i], float(value), *weights[i + 1 :])
                    ui.session.edit(
                        "nodes", "weights", [row], [wanted], gesture=("weights", row, i), label=f"Weight of {name}"
                    )
    if skin >= 0 and section(ui, f"{icons.BONE}  Skin", opened=False):
        with property_grid("skin") as shown:
            if not shown:
                return
            property_text("Joints", str(int(scene.skins.count[skin])))
            property_row("Blending", "Linear is faster; dual quaternions keep the volume of what is twisted")
            names = ["linear", "dual quaternions"]
            changed, chosen = imgui.combo("##skinning", METHODS.index(scene.skins.method(skin)), names)
            if changed:
                ui.session.edit("nodes", "skinning", [row], [METHODS[chosen]], label=f"Blend by {names[chosen]}")
