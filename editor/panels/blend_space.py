"""Blend space: the clips at their places, and a puck that says where between them the character is now."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from imgui_bundle import imgui

from editor import icons, theme
from editor.animating.editing import AnimationEditor
from editor.animating.following import animation_of, drive_of, runtime_of
from editor.panels.base import Panel
from editor.ui import Ui
from editor.widgets import em, empty_state, icon_button, text
from engine.animation.blend_space import BlendSpace
from engine.core.errors import LucarnaError

#: the field of weights behind a 2D space has so many cells a side
CELLS = 24


class BlendSpacePanel(Panel):
    title: ClassVar[str] = "Blend space"
    icon: ClassVar[str] = icons.BLEND
    dock: ClassVar[str] = "BottomRight"
    opened: ClassVar[bool] = False

    def __init__(self) -> None:
        #: sample being dragged, or -1 the puck; None nothing
        self._held: int | None = None
        self._count = 0
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
            empty_state(icons.BLEND, "No blend space yet")
            if imgui.button(f"{icons.ADD}  Blend the clips by a speed"):
                self._try(ui, lambda: make_blend(editor))
            return
        view = session.animating
        if view.blend not in model.blends:
            view.blend = next(iter(model.blends))
        self._choice(ui, editor, model)
        blend = model.blends[view.blend]
        animator = animation_of(session).animator
        self._field(ui, editor, blend, animator)

    def _choice(self, ui: Ui, editor: AnimationEditor, model: Any) -> None:
        view = ui.session.animating
        imgui.set_next_item_width(em(9))
        names = list(model.blends)
        changed, chosen = imgui.combo("##blend", names.index(view.blend), names)
        if changed:
            view.blend = names[chosen]
        imgui.same_line()
        if icon_button(f"{icons.ADD}##sample", "Add a clip in the middle"):
            imgui.open_popup("##add")
        if imgui.begin_popup("##add"):
            for clip in runtime_of(ui.session).clips:
                if imgui.menu_item_simple(clip.name):
                    self._try(
                        ui, lambda name=clip.name: add_sample(editor, view.blend, name, (self.low + self.high) / 2)
                    )
            imgui.end_popup()
        imgui.same_line()
        if drive_of(ui.session) != "states":
            if imgui.small_button("Let the states drive"):
                self._try(ui, lambda: editor.drive("states"))
        else:
            text(" × ".join(model.blends[view.blend].params), theme.DIM)

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
        lines.add_rect_filled((x, y), (x + width, y + height), theme.u32(theme.FRAME), 3)
        space = BlendSpace(np.array([s.at for s in blend.samples]))
        if not flat:
            self._weights(space)
        puck = self._puck(blend, animator)
        shares = space.weights(puck[None, : len(blend.params)])[:, 0]
        px = self._px(places)
        for i, (sample, (sx, sy)) in enumerate(zip(blend.samples, px.tolist(), strict=True)):
            radius = em(0.3) + em(0.5) * float(shares[i])
            lines.add_circle_filled((sx, sy), radius, theme.u32((0.36, 0.6, 0.85, 0.35 + 0.6 * float(shares[i]))))
            lines.add_circle((sx, sy), radius, theme.u32(theme.TEXT))
            name = f"{sample.clip}  {shares[i]:.0%}"
            size = imgui.calc_text_size(name)
            lines.add_text(
                (min(max(sx - size.x / 2, x + 2), x + width - size.x - 2), sy + em(0.9)), theme.u32(theme.TEXT), name
            )
        if animator is not None:
            ux, uy = self._px(puck[None])[0].tolist()
            lines.add_circle_filled((ux, uy), em(0.5), theme.u32(theme.ACCENT))
            lines.add_circle((ux, uy), em(0.5), theme.u32((0, 0, 0, 1)), 0, 2.0)
        label = ", ".join(f"{name} {value:.3g}" for name, value in zip(blend.params, puck.tolist(), strict=False))
        lines.add_text((x + em(0.5), y + em(0.3)), theme.u32(theme.DIM), label)
        self._pointer(ui, editor, blend, animator, px, flat)

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

    def _pointer(self, ui: Ui, editor: AnimationEditor, blend: Any, animator: Any, px: Any, flat: bool) -> None:
        io = imgui.get_io()
        x, y, width, height = self.area
        mouse = np.array([io.mouse_pos.x, io.mouse_pos.y])
        share = np.array([(mouse[0] - x) / width, 1.0 - (mouse[1] - y) / height]).clip(0.0, 1.0)
        place = self.low + share * (self.high - self.low)
        if imgui.is_item_hovered() and imgui.is_mouse_clicked(0):
            near = np.linalg.norm(px - mouse, axis=1)
            self._held = int(np.argmin(near)) if io.key_ctrl and near.min() < em(1.2) else -1
            self._count += 1
        if self._held is None:
            return
        if not imgui.is_mouse_down(0):
            self._held = None
            ui.session.end_gesture()
        elif self._held >= 0:
            at = [float(v) for v in (place[:1] if flat else place)]
            view = ui.session.animating
            self._try(ui, lambda: editor.move_sample(view.blend, self._held, at, gesture=("sample", self._count)))
        elif animator is not None:
            for i, name in enumerate(blend.params):
                self._try(ui, lambda i=i, name=name: editor.set_param(name, float(place[i])))

    def _try(self, ui: Ui, change: Any) -> None:
        try:
            change()
        except LucarnaError as error:
            self._held = None
            ui.session.fail(error)


def make_blend(editor: AnimationEditor) -> None:
    """A space of all clips along one parameter, and a state that shows it."""
    clips = [c.name for c in runtime_of(editor.session).clips]
    editor.create()
    param = "speed" if "speed" in editor.model.params else editor.add_param("speed")
    blend = editor.add_blend("blend", [param], [(name, [float(i)]) for i, name in enumerate(clips)])
    editor.add_state("blend", blend=blend)
    editor.drive("states")


def add_sample(editor: AnimationEditor, blend: str, clip: str, place: Any) -> None:
    from editor.animating import edits

    model = editor.model.blends[blend]
    key = next((k for k, c in editor.model.clips.items() if (c.source or k) == clip), clip)
    at = [float(v) for v in place[: len(model.params)]]
    text_ = edits.append(editor.text, ("blends", blend, "samples"), {"clip": key, "at": at})
    editor.apply(text_, f"Add {clip}")


PANEL = BlendSpacePanel
