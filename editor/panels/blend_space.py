"""Blend space: the clips at their places, and a puck that says where between them the character is now.

Drag anywhere: the puck. Ctrl and drag a clip: its place. Right click a clip: what stands there, where, or away with it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from imgui_bundle import imgui

from editor import icons, theme
from editor.animating import edits
from editor.animating.editing import AnimationEditor
from editor.animating.following import animation_of, drive_of, runtime_of
from editor.panels.base import Panel
from editor.panels.timeline_menus import attempt
from editor.ui import Ui
from editor.widgets import em, empty_state, flow, icon_button, text
from engine.animation.blend_space import BlendSpace
from engine.core.errors import InputError

#: the field of weights behind a 2D space has so many cells a side
CELLS = 24
#: what spaces are first spanned by
PARAMS = ("speed", "turn")


class BlendSpacePanel(Panel):
    title: ClassVar[str] = "Blend space"
    icon: ClassVar[str] = icons.BLEND
    dock: ClassVar[str] = "BottomRight"
    opened: ClassVar[bool] = False

    def __init__(self) -> None:
        # sample being dragged, or -1 the puck; None nothing
        self._held: int | None = None
        self._count = 0
        # what a new space is to be made of
        self._wanted: list[str] = []
        self._flat = True
        self._name = ""
        self._menu_of = -1
        #: x, y, width, height of the field, imgui units, and the places at its corners: for tests
        self.area = (0.0, 0.0, 1.0, 1.0)
        self.low = self.high = np.zeros(2)

    def draw(self, ui: Ui) -> None:
        session = ui.session
        editor = AnimationEditor(session)
        model = editor.model
        if session.document is None or not getattr(session.document.runtime, "clips", None):
            empty_state(icons.BLEND, "No clips to blend")
            return
        if model is None or not model.blends:
            if imgui.button(f"{icons.ADD}  New blend space…"):
                self._begin_new(ui)
            self._new(ui, editor)
            empty_state(icons.BLEND, "No blend space yet", "It mixes clips by one or two parameters")
            return
        view = session.animating
        if view.blend not in model.blends:
            view.blend = next(iter(model.blends))
        self._choice(ui, editor, model)
        if view.blend not in editor.model.blends:  # renamed or deleted just now
            return
        self._field(ui, editor, editor.model.blends[view.blend], animation_of(session).animator)

    # -- the bar ------------------------------------------------------------------------------------------------------

    def _choice(self, ui: Ui, editor: AnimationEditor, model: Any) -> None:
        view = ui.session.animating
        imgui.set_next_item_width(em(7))
        names = list(model.blends)
        changed, chosen = imgui.combo("##blend", names.index(view.blend), names)
        if changed:
            view.blend = names[chosen]
        imgui.same_line(0, em(0.3))
        if icon_button(f"{icons.ADD}##sample", "Add a clip in the middle"):
            imgui.open_popup("##add")
        if imgui.begin_popup("##add"):
            for clip in runtime_of(ui.session).clips:
                if imgui.menu_item_simple(clip.name):
                    middle = ((self.low + self.high) / 2)[: len(model.blends[view.blend].params)]
                    attempt(ui, lambda name=clip.name, at=middle: editor.add_sample(view.blend, name, at.tolist()))
            imgui.end_popup()
        imgui.same_line(0, em(0.3))
        if icon_button(f"{icons.BLEND}##new", "New blend space"):
            self._begin_new(ui)
        self._new(ui, editor)
        imgui.same_line(0, em(0.3))
        if icon_button(f"{icons.RENAME}##rename", "Rename the blend space"):
            self._name = view.blend
            imgui.open_popup("##rename")
        self._rename(ui, editor)
        imgui.same_line(0, em(0.3))
        if icon_button(f"{icons.TRASH}##delete", "Delete the blend space"):
            attempt(ui, lambda: editor.remove_blend(view.blend))
        if drive_of(ui.session) != "states":
            flow(em(9), 0.5)
            if imgui.small_button("Let the states drive"):
                attempt(ui, lambda: editor.drive("states"))

    def _rename(self, ui: Ui, editor: AnimationEditor) -> None:
        if not imgui.begin_popup("##rename"):
            return
        view = ui.session.animating
        _changed, self._name = imgui.input_text("Name", self._name)
        wanted = self._name.strip()
        if imgui.is_item_deactivated_after_edit() and wanted not in ("", view.blend):
            attempt(ui, lambda: editor.rename("blends", view.blend, wanted))
            if wanted in editor.model.blends:
                view.blend = wanted
            imgui.close_current_popup()
        imgui.end_popup()

    def _begin_new(self, ui: Ui) -> None:
        runtime = runtime_of(ui.session)
        self._wanted = [runtime.clips[i].name for i in runtime.deck.active][:1] or [runtime.clips[0].name]
        imgui.open_popup("##new-blend")

    def _new(self, ui: Ui, editor: AnimationEditor) -> None:
        """Which clips, along one parameter or over two."""
        if not imgui.begin_popup("##new-blend"):
            return
        text("Blend these clips", theme.DIM)
        clips = runtime_of(ui.session).clips
        line = imgui.get_text_line_height_with_spacing() * 1.25
        if imgui.begin_child("##clips", (em(15), min(len(clips), 9) * line + em(0.3))):
            for i, clip in enumerate(clips):
                changed, on = imgui.checkbox(f"{clip.name}##{i}", clip.name in self._wanted)
                if changed:
                    self._wanted = [*self._wanted, clip.name] if on else [n for n in self._wanted if n != clip.name]
        imgui.end_child()
        if imgui.radio_button("Along one parameter", self._flat):
            self._flat = True
        if imgui.radio_button("Over two parameters", not self._flat):
            self._flat = False
        if imgui.button("Make it", (em(6), 0)):
            attempt(ui, lambda: make_blend(editor, self._wanted, 1 if self._flat else 2))
            imgui.close_current_popup()
        imgui.end_popup()

    # -- the field ----------------------------------------------------------------------------------------------------

    def _field(self, ui: Ui, editor: AnimationEditor, blend: Any, animator: Any) -> None:
        places = np.array([(*s.at, 0.0)[:2] for s in blend.samples], np.float64)
        flat = len(blend.params) == 1
        if self._held is None:  # while something is dragged the frame stands still
            room = 0.12 * np.maximum(np.ptp(places, axis=0), 0.5)
            self.low, self.high = places.min(axis=0) - room, places.max(axis=0) + room
        at, avail = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
        self.area = (at.x, at.y, max(avail.x, 40.0), max(avail.y, 40.0))
        imgui.invisible_button("##field", self.area[2:])
        lines = imgui.get_window_draw_list()
        x, y, width, height = self.area
        lines.push_clip_rect((x, y), (x + width, y + height), True)
        lines.add_rect_filled((x, y), (x + width, y + height), theme.u32(theme.FRAME), 3)
        space = BlendSpace(np.array([s.at for s in blend.samples]))
        if not flat:
            self._weights(space)
        puck = self._puck(blend, animator)
        shares = space.weights(puck[None, : len(blend.params)])[:, 0]
        px = self._px(places)
        if flat:
            lines.add_line((x, float(px[0, 1])), (x + width, float(px[0, 1])), theme.u32((1, 1, 1, 0.12)))
        for share, (sx, sy) in zip(shares.tolist(), px.tolist(), strict=True):
            radius = em(0.3) + em(0.5) * share
            lines.add_circle_filled((sx, sy), radius, theme.u32((0.36, 0.6, 0.85, 0.35 + 0.6 * share)))
            lines.add_circle((sx, sy), radius, theme.u32(theme.TEXT))
        self._names(blend, shares, px)
        if animator is not None:
            ux, uy = self._px(puck[None])[0].tolist()
            lines.add_circle_filled((ux, uy), em(0.5), theme.u32(theme.ACCENT))
            lines.add_circle((ux, uy), em(0.5), theme.u32((0, 0, 0, 1)), 0, 2.0)
        self._axes(blend, puck)
        lines.pop_clip_rect()
        self._pointer(ui, editor, blend, animator, px, flat)

    def _names(self, blend: Any, shares: Any, px: Any) -> None:
        """Names of the clips, the loudest first; those that would lie on another's are for the tooltip."""
        lines, mouse = imgui.get_window_draw_list(), imgui.get_io().mouse_pos
        x, y, width, height = self.area
        taken: list[tuple[float, float, float, float]] = []
        for i in np.argsort(-np.asarray(shares), kind="stable").tolist():
            name = f"{blend.samples[i].clip}  {shares[i]:.0%}"
            size, (sx, sy) = imgui.calc_text_size(name), px[i].tolist()
            left = min(max(sx - size.x / 2, x + 2), x + width - size.x - 2)
            if imgui.is_item_hovered() and math.hypot(mouse.x - sx, mouse.y - sy) < em(0.7):
                at = ", ".join(f"{p} {v:g}" for p, v in zip(blend.params, blend.samples[i].at, strict=True))
                imgui.set_tooltip(f"{name}\n{at}\nCtrl and drag moves it, right click for more")
            for top in (sy + em(0.9), sy - em(2.0)):
                box = (left - 3, top, left + size.x + 3, top + size.y)
                free = not any(box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in taken)
                if free and y <= top and top + size.y <= y + height:
                    taken.append(box)
                    lines.add_text((left, top), theme.u32(theme.TEXT if shares[i] > 0.005 else theme.DIM), name)
                    break

    def _axes(self, blend: Any, puck: Any) -> None:
        """The parameters along the edges, with their values at the puck, and what the edges stand for."""
        lines = imgui.get_window_draw_list()
        x, y, width, height = self.area
        dim, foot = theme.u32(theme.DIM), y + height - em(1.2)
        across = f"{blend.params[0]} {puck[0]:.3g}"
        lines.add_text((x + (width - imgui.calc_text_size(across).x) / 2, foot), dim, across)
        lines.add_text((x + em(0.4), foot), theme.u32(theme.FAINT), f"{self.low[0]:.3g}")
        end = f"{self.high[0]:.3g}"
        lines.add_text((x + width - imgui.calc_text_size(end).x - em(0.4), foot), theme.u32(theme.FAINT), end)
        if len(blend.params) == 2:
            up = f"{blend.params[1]} {puck[1]:.3g}"
            lines.add_text((x + em(0.4), y + em(0.2)), dim, f"{up}   up to {self.high[1]:.3g}")
            lines.add_text((x + em(0.4), foot - em(1.2)), theme.u32(theme.FAINT), f"from {self.low[1]:.3g}")

    def _weights(self, space: BlendSpace) -> None:
        """The field of the largest weight: darker where clips are mixed."""
        lines = imgui.get_window_draw_list()
        x, y, width, height = self.area
        u = (np.arange(CELLS) + 0.5) / CELLS
        grid = np.stack(np.meshgrid(u, u, indexing="ij"), axis=-1).reshape(-1, 2)
        at = self.low + grid * (self.high - self.low)
        weights = space.weights(at).max(axis=0).reshape(CELLS, CELLS)
        for i in range(CELLS):
            for j in range(CELLS):
                a = (x + width * i / CELLS, y + height * (1 - (j + 1) / CELLS))
                b = (x + width * (i + 1) / CELLS, y + height * (1 - j / CELLS))
                lines.add_rect_filled(a, b, theme.u32((0.36, 0.6, 0.85, 0.04 + 0.16 * float(weights[i, j]))))

    def _puck(self, blend: Any, animator: Any) -> Any:
        puck = np.zeros(2)
        if animator is not None:
            for i, name in enumerate(blend.params):
                puck[i] = float(animator.machine.values[animator.machine.param(name), 0])
        return puck

    def _px(self, places: Any) -> Any:
        x, y, width, height = self.area
        share = (places - self.low) / np.maximum(self.high - self.low, 1e-9)
        return np.stack([x + share[:, 0] * width, y + (1.0 - share[:, 1]) * height], axis=1)

    # -- the pointer --------------------------------------------------------------------------------------------------

    def _pointer(self, ui: Ui, editor: AnimationEditor, blend: Any, animator: Any, px: Any, flat: bool) -> None:
        io = imgui.get_io()
        x, y, width, height = self.area
        mouse = np.array([io.mouse_pos.x, io.mouse_pos.y])
        share = np.array([(mouse[0] - x) / width, 1.0 - (mouse[1] - y) / height]).clip(0.0, 1.0)
        place = self.low + share * (self.high - self.low)
        near = np.linalg.norm(px - mouse, axis=1)
        if imgui.is_item_hovered() and imgui.is_mouse_clicked(0):
            self._held = int(np.argmin(near)) if io.key_ctrl and near.min() < em(1.2) else -1
            self._count += 1
        elif imgui.is_item_hovered() and imgui.is_mouse_clicked(1) and near.min() < em(1.2):
            self._menu_of = int(np.argmin(near))
            imgui.open_popup("##sample-menu")
        self._sample_menu(ui, editor, blend)
        if self._held is None:
            return
        if not imgui.is_mouse_down(0):
            self._held = None
            ui.session.end_gesture()
        elif self._held >= 0:
            at = [float(v) for v in (place[:1] if flat else place)]
            view = ui.session.animating
            attempt(ui, lambda: editor.move_sample(view.blend, self._held or 0, at, gesture=("sample", self._count)))
        elif animator is not None:
            for i, name in enumerate(blend.params):
                attempt(ui, lambda i=i, name=name: editor.set_param(name, float(place[i])))

    def _sample_menu(self, ui: Ui, editor: AnimationEditor, blend: Any) -> None:
        if not imgui.begin_popup("##sample-menu"):
            return
        number, view = self._menu_of, ui.session.animating
        if not 0 <= number < len(blend.samples):
            imgui.end_popup()
            return
        sample = blend.samples[number]
        imgui.set_next_item_width(em(9))
        if imgui.begin_combo("Clip", sample.clip):
            for clip in runtime_of(ui.session).clips:
                if imgui.selectable(clip.name, clip.name == sample.clip)[0]:
                    attempt(ui, lambda name=clip.name: editor.set_sample(view.blend, number, name))
            imgui.end_combo()
        for i, param in enumerate(blend.params):
            imgui.set_next_item_width(em(9))
            changed, value = imgui.drag_float(f"{param}##at{i}", sample.at[i], 0.01)
            if changed:
                at = [*sample.at[:i], float(value), *sample.at[i + 1 :]]
                attempt(ui, lambda at=at: editor.move_sample(view.blend, number, at, gesture=("place", number)))
        if imgui.menu_item_simple("Take it out"):
            attempt(ui, lambda: editor.remove_sample(view.blend, number))
        imgui.end_popup()


def make_blend(editor: AnimationEditor, clips: Sequence[str] = (), dimensions: int = 1) -> None:
    """A space of the clips (of all without) along one parameter or over two, and a state that shows it: one entry.

    Along one they stand a unit apart; over two the first stands in the middle and the others around it.
    Raises InputError for no clips."""
    names = list(clips) or [c.name for c in runtime_of(editor.session).clips]
    if not names:
        raise InputError("a blend space needs clips", hint="tick some")
    editor.create()
    gesture = "new blend"
    params = [name for name in PARAMS[:dimensions] if name in editor.model.params]
    body = editor.text
    for name in PARAMS[:dimensions]:
        if name not in params:
            body = edits.put(body, (("params", name), {"type": "float", "default": 0.0}))
    if body != editor.text:
        editor.apply(body, "Add blend", gesture)
    places: list[list[float]] = [[float(i)] for i in range(len(names))]
    if dimensions == 2:
        turn = 2.0 * math.pi / max(len(names) - 1, 1)
        around = [[math.sin(turn * i), math.cos(turn * i)] for i in range(len(names) - 1)]
        places = [[0.0, 0.0], *([round(v, 4) for v in at] for at in around)]
    blend = editor.add_blend("blend", PARAMS[:dimensions], list(zip(names, places, strict=True)), gesture=gesture)
    editor.add_state(blend, blend=blend, gesture=gesture)
    editor.session.end_gesture()
    editor.session.animating.blend = blend
    editor.drive("states")


PANEL = BlendSpacePanel
