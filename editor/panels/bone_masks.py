"""Masks: how much each bone follows a layer; by subtree, by bone, picked in the list or in the picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from imgui_bundle import imgui

from editor import icons, theme
from editor.animating.editing import AnimationEditor
from editor.animating.following import animation_of
from editor.panels.base import Panel
from editor.param_widgets import filled_slider
from editor.ui import Ui
from editor.widgets import em, empty_state, fitted_text, icon_button, search_field, text, tooltip
from engine.animation import mask as masks
from engine.core.errors import LucarnaError


class MasksPanel(Panel):
    title: ClassVar[str] = "Masks"
    icon: ClassVar[str] = icons.MASK
    dock: ClassVar[str] = "Right"
    opened: ClassVar[bool] = False

    def __init__(self) -> None:
        self._name = ""

    def draw(self, ui: Ui) -> None:
        session = ui.session
        if session.document is None or not getattr(session.document.runtime, "clips", None):
            empty_state(icons.MASK, "No bones to mask")
            return
        editor = AnimationEditor(session)
        view, model = session.animating, editor.model
        if model is None or not model.masks:
            empty_state(icons.MASK, "No masks yet", "A mask lets a track or layer move part of the body")
            if imgui.button(f"{icons.ADD}  New mask"):
                self._try(ui, lambda: setattr(view, "mask", editor.add_mask()))
            return
        if view.mask not in model.masks:
            view.mask = next(iter(model.masks))
        self._choice(ui, editor, model)
        weights = mask_weights(session, view.mask)
        self._uncovered(ui, model, weights)
        view.bone_search = search_field("##bones", view.bone_search, "Find bones")
        self._subtrees(ui, editor, model)
        if imgui.begin_child("##list"):
            self._bones(ui, editor, model, weights)
        imgui.end_child()

    def _choice(self, ui: Ui, editor: AnimationEditor, model: Any) -> None:
        view, names = ui.session.animating, list(model.masks)
        imgui.set_next_item_width(em(6))
        changed, chosen = imgui.combo("##mask", names.index(view.mask), names)
        if changed:
            view.mask = names[chosen]
        imgui.same_line(0, em(0.1))
        if icon_button(f"{icons.ADD}##mask-add", "New mask"):
            self._try(ui, lambda: setattr(view, "mask", editor.add_mask()))
        imgui.same_line(0, em(0.1))
        if icon_button(f"{icons.SELECT}##pick", "Click bones in the picture", active=view.picking_bone):
            view.picking_bone = not view.picking_bone
            view.skeleton = view.skeleton or view.picking_bone
        imgui.same_line(0, em(0.1))
        if icon_button(f"{icons.RENAME}##rename-mask", "Rename the mask, wherever it is used"):
            self._name = view.mask
            imgui.open_popup("##rename")
        self._rename(ui, editor)
        imgui.same_line(0, em(0.1))
        folder = mask_folder(ui.session)
        if icon_button(f"{icons.SAVE}##save-mask", f"Save as {view.mask}.mask.toml in {folder.name}"):
            path = folder / f"{view.mask}.mask.toml"
            self._try(ui, lambda: editor.save_mask(view.mask, path))
            ui.session.ui.notice = f"Saved {path.name}"
        imgui.same_line(0, em(0.1))
        self._files(ui, editor)
        imgui.same_line(0, em(0.1))
        if icon_button(f"{icons.TRASH}##mask-delete", "Delete the mask"):
            self._try(ui, lambda: editor.remove_mask(view.mask))

    def _subtrees(self, ui: Ui, editor: AnimationEditor, model: Any) -> None:
        """The fall-off of what is clicked next, and what each subtree was given."""
        view = ui.session.animating
        imgui.set_next_item_width(em(6))
        view.fall_off = int(imgui.slider_int("Fall-off", view.fall_off, 0, 8, "%d bones")[1])
        tooltip("Over how many bones the mask rises from a bone that is clicked, here or in the picture")
        for part in model.masks[view.mask].subtrees:
            imgui.push_id(part.node)
            for key, value, width, unit in (
                ("weight", part.weight, 4.0, "%.2f"),
                ("fall_off", part.fall_off, 4.0, "%d"),
            ):
                imgui.set_next_item_width(em(width))
                if key == "weight":
                    changed, new = imgui.drag_float("##weight", value, 0.01, 0.0, 1.0, unit)
                else:
                    changed, new = imgui.drag_int("##fall", value, 0.1, 0, 50, unit)
                tooltip("Weight of the whole subtree" if key == "weight" else "Bones over which it rises")
                if changed:
                    wanted = {"weight": part.weight, "fall_off": part.fall_off, key: new}
                    self._try(ui, lambda part=part, w=wanted: editor.mask_subtree(
                        view.mask, part.node, round(float(w["weight"]), 3), int(w["fall_off"]),
                        gesture=("subtree", part.node)))  # fmt: skip
                imgui.same_line(0, em(0.3))
            if icon_button(f"{icons.CLEAR}##out", "Take this subtree out of the mask"):
                self._try(ui, lambda part=part: editor.unmask_subtree(view.mask, part.node))
            imgui.same_line(0, em(0.3))
            imgui.align_text_to_frame_padding()
            fitted_text(part.node)
            imgui.pop_id()

    def _rename(self, ui: Ui, editor: AnimationEditor) -> None:
        view = ui.session.animating
        if imgui.begin_popup("##rename"):
            _changed, self._name = imgui.input_text("Name", self._name)
            if imgui.is_item_deactivated_after_edit() and self._name.strip() not in ("", view.mask):
                self._try(ui, lambda: editor.rename("masks", view.mask, self._name.strip()))
                if self._name.strip() in editor.model.masks:
                    view.mask = self._name.strip()
                imgui.close_current_popup()
            imgui.end_popup()

    def _files(self, ui: Ui, editor: AnimationEditor) -> None:
        """The mask files of the project, or beside the scene, to be taken over."""
        if icon_button(f"{icons.FOLDER_OPEN}##load-mask", "Load a saved mask"):
            imgui.open_popup("##masks")
        if imgui.begin_popup("##masks"):
            files = sorted(mask_folder(ui.session).glob("*.mask.toml"))
            for path in files:
                if imgui.menu_item_simple(path.name.removesuffix(".mask.toml")):
                    self._try(ui, lambda path=path: setattr(ui.session.animating, "mask", editor.load_mask(path)))
            if not files:
                text("None saved yet", theme.FAINT)
            imgui.end_popup()

    def _uncovered(self, ui: Ui, model: Any, weights: Any) -> None:
        """Bones that the mask lets follow and no clip of its tracks and layers moves."""
        animation, name = animation_of(ui.session), ui.session.animating.mask
        used = [model.clips[b.clip].source or b.clip for t in model.tracks if t.mask == name for b in t.blocks]
        used += [model.clips[la.clip].source or la.clip for la in model.layers if la.mask == name and la.clip]
        uses = animation.sequence.clips if animation.sequence is not None else animation.graph.clips
        samplers = [u.sampler for u in uses if u.sampler.name in used]
        if not used:
            text("No track or layer uses it yet", theme.FAINT)
            return
        free = masks.uncovered(animation.rig, weights, samplers)
        if free:
            text(f"{icons.WARNING} {len(free)} bones are not moved by its clips", theme.WARNING)
            tooltip("There the rest pose is held:\n" + ", ".join(free))

    def _bones(self, ui: Ui, editor: AnimationEditor, model: Any, weights: Any) -> None:
        view = ui.session.animating
        rig = animation_of(ui.session).rig
        chosen = {s.node: s for s in model.masks[view.mask].subtrees}
        own = model.masks[view.mask].nodes
        depth = np.zeros(len(rig), np.int64)
        for i in range(len(rig)):
            depth[i] = depth[rig.parent[i]] + 1 if rig.parent[i] >= 0 else 0
        for i in tree_order(rig.parent):
            name = rig.names[i]
            if view.bone_search.lower() not in name.lower():
                continue
            imgui.push_id(i)
            imgui.align_text_to_frame_padding()
            self._bar(float(weights[i]))
            imgui.same_line(0, em(0.4) + (em(0.7) * int(depth[i]) if not view.bone_search else 0.0))
            mark = f"{icons.TREE} " if name in chosen else ""
            if imgui.selectable(f"{mark}{name}", name in chosen, 0, (imgui.get_content_region_avail().x - em(5), 0))[0]:
                self._try(ui, lambda name=name: toggle(editor, view.mask, name, view.fall_off))
            tooltip("Click: it and all below follow, or no longer. The slider sets this bone alone")
            imgui.same_line()
            imgui.set_next_item_width(em(4.5))
            changed, value = filled_slider("##weight", float(weights[i]), 0.0, 1.0, "%.2f")
            if changed:
                self._try(ui, lambda name=name, value=value: editor.mask_bone(
                    view.mask, name, round(float(value), 3), gesture=("bone", name)))  # fmt: skip
            tooltip("This bone alone. Right click: as its subtree says" if name in own else "This bone alone")
            if name in own and imgui.is_item_clicked(imgui.MouseButton_.right):
                self._try(ui, lambda name=name: editor.mask_bone(view.mask, name, None))
            imgui.pop_id()

    def _bar(self, weight: float) -> None:
        at, size = imgui.get_cursor_screen_pos(), em(0.7)
        imgui.dummy((size, imgui.get_text_line_height()))
        lines = imgui.get_window_draw_list()
        top = at.y + imgui.get_style().frame_padding.y
        low = top + imgui.get_text_line_height()
        lines.add_rect_filled((at.x, top), (at.x + size, low), theme.u32(theme.FRAME))
        lines.add_rect_filled((at.x, low - (low - top) * weight), (at.x + size, low), theme.u32(theme.ACCENT))

    def _try(self, ui: Ui, change: Any) -> None:
        try:
            change()
        except LucarnaError as error:
            ui.session.fail(error)


def tree_order(parents: Any) -> list[int]:
    """The nodes of a rig, each before what hangs on it and that before the next: as a tree is read."""
    children: dict[int, list[int]] = {}
    for i, up in enumerate(parents):
        children.setdefault(int(up), []).append(i)
    order: list[int] = []
    waiting = list(reversed(children.get(-1, [])))
    while waiting:
        node = waiting.pop()
        order.append(node)
        waiting += reversed(children.get(node, []))
    return order


def mask_folder(session: Any) -> Path:
    """Where masks are kept: `masks/` of the project, else beside the opened file."""
    document = session.document
    if document.project_root is not None:
        return Path(document.project_root) / "masks"
    source = Path(document.source)
    return source if source.is_dir() else source.parent


def mask_weights(session: Any, mask: str) -> Any:
    """f8[n]: the weights of a mask of the open animation, by rig node."""
    animation = animation_of(session)
    model = animation.model.masks[mask]
    parts = [masks.subtree(animation.rig, s.node, s.weight, s.fall_off) for s in model.subtrees]
    return masks.combine(animation.rig, parts, model.nodes)


def toggle(editor: AnimationEditor, mask: str, bone: str, fall_off: int = 0) -> None:
    """Let a bone's subtree follow, or take it out again."""
    if bone in {s.node for s in editor.model.masks[mask].subtrees}:
        editor.unmask_subtree(mask, bone)
    else:
        editor.mask_subtree(mask, bone, 1.0, fall_off)


PANEL = MasksPanel
