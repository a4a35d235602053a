"""State graph: states as boxes to be moved, transitions as arrows, parameters beside them; what is now is lit."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.animating.editing import AnimationEditor
from editor.animating.following import animation_of, drive_of, runtime_of
from editor.panels.base import Panel
from editor.ui import Ui
from editor.widgets import cut, em, empty_state, fitted_text, icon_button, text
from engine.core.errors import LucarnaError

BOX = (8.5, 2.6)


class StateGraphPanel(Panel):
    title: ClassVar[str] = "State graph"
    icon: ClassVar[str] = icons.GRAPH
    dock: ClassVar[str] = "Bottom"
    opened: ClassVar[bool] = False

    def __init__(self) -> None:
        self._held = ""
        self._from = ""
        self._count = 0
        self._offset = (0.0, 0.0)
        #: where the field begins, and the states' boxes in the window: for tests
        self.origin = (0.0, 0.0)
        #: how far the graph was moved along, imgui units
        self.shift = (0.0, 0.0)
        self.boxes: dict[str, tuple[float, float]] = {}

    def draw(self, ui: Ui) -> None:
        session = ui.session
        if session.document is None or not getattr(session.document.runtime, "clips", None):
            empty_state(icons.GRAPH, "No clips for states")
            return
        editor = AnimationEditor(session)
        self._bar(ui, editor)
        model = editor.model
        if model is None or not model.states:
            empty_state(icons.GRAPH, "No states yet", "Add one for a clip above")
            return
        side = min(em(13), 0.35 * imgui.get_content_region_avail().x)
        if imgui.begin_child("##side", (side, 0)):
            self._params(ui, editor, model)
            self._chosen(ui, editor, model)
        imgui.end_child()
        imgui.same_line()
        self._graph(ui, editor, model)

    def _bar(self, ui: Ui, editor: AnimationEditor) -> None:
        session = ui.session
        if icon_button(f"{icons.ADD} State", "A state that plays a clip or a blend space"):
            imgui.open_popup("##state")
        if imgui.begin_popup("##state"):
            for clip in runtime_of(session).clips:
                if imgui.menu_item_simple(clip.name):
                    self._try(ui, lambda name=clip.name: editor.add_state(name, name))
            for blend in editor.model.blends if editor.model is not None else ():
                if imgui.menu_item_simple(f"{blend} (blend)"):
                    self._try(ui, lambda blend=blend: editor.add_state(blend, blend=blend))
            imgui.end_popup()
        imgui.same_line()
        if icon_button(f"{icons.ADD} Parameter", "A number, a switch or a trigger that transitions ask for"):
            imgui.open_popup("##param")
        if imgui.begin_popup("##param"):
            for kind, name in (("float", "speed"), ("bool", "armed"), ("trigger", "jump")):
                if imgui.menu_item_simple(kind):
                    default: Any = 0.0 if kind == "float" else False
                    self._try(ui, lambda kind=kind, name=name, default=default: editor.add_param(name, kind, default))
            imgui.end_popup()
        imgui.same_line()
        if editor.model is not None and editor.model.states and drive_of(session) != "states":
            if imgui.small_button("Let the states drive"):
                self._try(ui, lambda: editor.drive("states"))
        else:
            fitted_text("Drag a state; Shift and drag to another: a transition; middle button: move along", theme.FAINT)

    def _params(self, ui: Ui, editor: AnimationEditor, model: Any) -> None:
        animator = animation_of(ui.session).animator
        for name, param in model.params.items():
            value = float(animator.machine.values[animator.machine.param(name), 0]) if animator is not None else 0.0
            if param.type == "float":
                imgui.set_next_item_width(em(6))
                changed, new = imgui.drag_float(name, value, 0.02)
            elif param.type == "bool":
                changed, new = imgui.checkbox(name, value != 0.0)
            else:
                changed = imgui.button(f"{name}##trigger")
                new = 1.0
            if changed:
                self._try(ui, lambda name=name, new=new: editor.set_param(name, float(new)))

    def _chosen(self, ui: Ui, editor: AnimationEditor, model: Any) -> None:
        view = ui.session.animating
        if 0 <= view.transition < len(model.transitions):
            t, number = model.transitions[view.transition], view.transition
            imgui.separator()
            text(f"{t.source} → {t.target}", theme.ACCENT)
            entered = imgui.input_text("when", ", ".join(t.when), imgui.InputTextFlags_.enter_returns_true)
            if entered[0]:
                when = [part.strip() for part in entered[1].split(",") if part.strip()]
                self._try(ui, lambda: editor.set_transition(number, when=when))
            changed, fade = imgui.drag_float("fade", t.fade, 0.01, 0.0, 10.0, "%.2f s")
            if changed:
                self._try(ui, lambda: editor.set_transition(number, fade=float(fade), gesture=("fade", number)))
            changed, sync = imgui.checkbox("start in step", t.sync)
            if changed:
                self._try(ui, lambda: editor.set_transition(number, sync=sync))
            if imgui.small_button("Delete transition"):
                self._try(ui, lambda: editor.remove_transition(number))
                view.transition = -1
        elif view.state in model.states:
            state = model.states[view.state]
            imgui.separator()
            text(view.state, theme.ACCENT)
            changed, speed = imgui.drag_float("speed", state.speed, 0.01, -10.0, 10.0)
            if changed:
                self._try(ui, lambda: editor.set_state(view.state, speed=float(speed), gesture=("speed", view.state)))
            if imgui.small_button("Delete state"):
                self._try(ui, lambda: editor.remove_state(view.state))
                view.state = ""

    def _graph(self, ui: Ui, editor: AnimationEditor, model: Any) -> None:
        at, avail = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
        width, height = max(avail.x, 40.0), max(avail.y, 40.0)
        imgui.invisible_button("##graph", (width, height))
        if imgui.is_item_hovered() and imgui.is_mouse_down(imgui.MouseButton_.middle):
            delta = imgui.get_io().mouse_delta
            self.shift = (self.shift[0] + delta.x, self.shift[1] + delta.y)
        elif imgui.is_item_hovered() and imgui.is_mouse_double_clicked(0) and not self._under(*_mouse()):
            self.shift = (0.0, 0.0)
        self.origin = (at.x + self.shift[0], at.y + self.shift[1])
        lines = imgui.get_window_draw_list()
        lines.push_clip_rect((at.x, at.y), (at.x + width, at.y + height), True)
        lines.add_rect_filled((at.x, at.y), (at.x + width, at.y + height), theme.u32(theme.FRAME), 3)
        self.boxes = {
            name: self._box(i, len(model.states), state) for i, (name, state) in enumerate(model.states.items())
        }
        animation = animation_of(ui.session)
        machine = (
            animation.animator.machine if animation.animator is not None and drive_of(ui.session) == "states" else None
        )
        names = list(model.states)
        now = names[int(machine.state[0])] if machine is not None else ""
        fading = int(machine.transition[0]) if machine is not None and machine.source[0] != -1 else -1
        for i, t in enumerate(model.transitions):
            self._arrow(t, i == ui.session.animating.transition, i == fading)
        for name, state in model.states.items():
            share = float(machine.heads.fraction[0]) if name == now and machine is not None else -1.0
            self._state(name, state, name == now, share, name == ui.session.animating.state, model.start == name)
        if self._from:
            start, mouse = self._middle(self._from), imgui.get_io().mouse_pos
            lines.add_line(start, (mouse.x, mouse.y), theme.u32(theme.ACCENT), 2.0)
        lines.pop_clip_rect()
        self._pointer(ui, editor, model)

    def _box(self, number: int, count: int, state: Any) -> tuple[float, float]:
        """The upper left corner of a state's box in the window; in rows of three where it was never moved."""
        at = (
            state.at
            if state.at is not None
            else (1.0 + (number % 3) * (BOX[0] + 3.0), 1.0 + (number // 3) * (BOX[1] + 2.0))
        )
        return self.origin[0] + em(at[0]), self.origin[1] + em(at[1])

    def _middle(self, name: str) -> tuple[float, float]:
        x, y = self.boxes[name]
        return x + em(BOX[0]) / 2, y + em(BOX[1]) / 2

    def _state(self, name: str, state: Any, now: bool, share: float, chosen: bool, start: bool) -> None:
        lines = imgui.get_window_draw_list()
        x, y = self.boxes[name]
        w, h = em(BOX[0]), em(BOX[1])
        lines.add_rect_filled((x, y), (x + w, y + h), theme.u32((*theme.ACCENT[:3], 0.30) if now else theme.RAISED), 5)
        if now and share >= 0.0:
            lines.add_rect_filled((x + 3, y + h - 5), (x + 3 + (w - 6) * share, y + h - 2), theme.u32(theme.ACCENT))
        lines.add_rect(
            (x, y), (x + w, y + h), theme.u32(theme.ACCENT if chosen else (1, 1, 1, 0.2)), 5, 2.0 if chosen else 1.0
        )
        title, plays = ("▸ " if start else "") + name, state.clip or f"{state.blend} (blend)"
        room, mouse = w - em(0.9), imgui.get_io().mouse_pos
        shown = cut(title, room), cut(plays, room)
        lines.add_text((x + em(0.5), y + em(0.2)), theme.u32(theme.TEXT), shown[0])
        lines.add_text((x + em(0.5), y + em(1.25)), theme.u32(theme.DIM), shown[1])
        if shown != (title, plays) and imgui.is_item_hovered() and x <= mouse.x <= x + w and y <= mouse.y <= y + h:
            imgui.set_tooltip(f"{name}\n{plays}")

    def _ends(self, t: Any) -> tuple[tuple[float, float], tuple[float, float]]:
        """Where an arrow begins and ends; arrows both ways lie side by side."""
        target = self._middle(t.target)
        if t.source == "any":
            return (target[0], target[1] - em(BOX[1])), (target[0], target[1] - em(BOX[1]) / 2)
        source = self._middle(t.source)
        dx, dy = target[0] - source[0], target[1] - source[1]
        length = max(math.hypot(dx, dy), 1e-6)
        side = (-dy / length * em(0.5), dx / length * em(0.5))

        def edge(point: tuple[float, float], sign: float) -> tuple[float, float]:
            reach = min(em(BOX[0]) / 2 / max(abs(dx / length), 1e-6), em(BOX[1]) / 2 / max(abs(dy / length), 1e-6))
            return point[0] + sign * dx / length * reach + side[0], point[1] + sign * dy / length * reach + side[1]

        return edge(source, 1.0), edge(target, -1.0)

    def _arrow(self, t: Any, chosen: bool, now: bool) -> None:
        lines = imgui.get_window_draw_list()
        a, b = self._ends(t)
        color = theme.u32(theme.ACCENT if chosen or now else (0.65, 0.68, 0.72, 0.8))
        lines.add_line(a, b, color, 2.5 if now or chosen else 1.4)
        angle = math.atan2(b[1] - a[1], b[0] - a[0])
        tip = [(b[0] - em(0.6) * math.cos(angle + s), b[1] - em(0.6) * math.sin(angle + s)) for s in (0.4, -0.4)]
        lines.add_triangle_filled(b, tip[0], tip[1], color)
        words = ", ".join(t.when)
        if t.source == "any":
            words = f"any: {words}"
        if words:
            size = imgui.calc_text_size(words)
            under = b[0] < a[0]  # beside its arrow, away from the one that goes back
            middle = ((a[0] + b[0]) / 2 - size.x / 2, (a[1] + b[1]) / 2 - size.y * (1.0 if under else 0.0))
            lines.add_text(middle, theme.u32(theme.TEXT if chosen else theme.DIM), words)

    def _pointer(self, ui: Ui, editor: AnimationEditor, model: Any) -> None:
        io, view = imgui.get_io(), ui.session.animating
        x, y = io.mouse_pos.x, io.mouse_pos.y
        if imgui.is_item_hovered() and imgui.is_mouse_clicked(0):
            under = self._under(x, y)
            view.state, view.transition = under, -1
            if under and io.key_shift:
                self._from = under
            elif under:
                self._held, self._count = under, self._count + 1
                self._offset = (self.boxes[under][0] - x, self.boxes[under][1] - y)
            else:
                near = [(_distance((x, y), *self._ends(t)), i) for i, t in enumerate(model.transitions)]
                view.transition = min(near)[1] if near and min(near)[0] < em(0.6) else -1
        if self._held:
            if imgui.is_mouse_down(0):
                if abs(io.mouse_delta.x) + abs(io.mouse_delta.y) > 0:
                    at = [(x + self._offset[0] - self.origin[0]) / em(), (y + self._offset[1] - self.origin[1]) / em()]
                    self._try(ui, lambda: editor.set_state(self._held, at=[round(max(v, 0.0), 2) for v in at],
                                                           gesture=("state", self._count)))  # fmt: skip
            else:
                self._held = ""
                ui.session.end_gesture()
        if self._from and not imgui.is_mouse_down(0):
            source, target, self._from = self._from, self._under(x, y), ""
            if target and target != source:
                self._try(ui, lambda: editor.add_transition(source, target))
                view.transition, view.state = len(model.transitions), ""

    def _under(self, x: float, y: float) -> str:
        for name, (left, top) in reversed(self.boxes.items()):
            if left <= x <= left + em(BOX[0]) and top <= y <= top + em(BOX[1]):
                return name
        return ""

    def _try(self, ui: Ui, change: Any) -> None:
        try:
            change()
        except LucarnaError as error:
            self._held = self._from = ""
            ui.session.fail(error)


def _distance(p: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    """From a point to a line between two."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dy * dy
    u = min(max(((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return math.hypot(p[0] - a[0] - u * dx, p[1] - a[1] - u * dy)


def _mouse() -> tuple[float, float]:
    at = imgui.get_io().mouse_pos
    return at.x, at.y


PANEL = StateGraphPanel
