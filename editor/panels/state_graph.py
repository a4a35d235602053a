"""State graph: states as boxes to be moved, transitions as arrows, parameters beside them; what is now is lit.

Drag a state to move it, Shift and drag from one to another for a transition, right click for more; the wheel zooms, the
middle button moves along, a double click on nothing brings the graph back.
"""

from __future__ import annotations

import math
from typing import Any, ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.animating.editing import AnimationEditor
from editor.animating.following import animation_of, drive_of, runtime_of
from editor.panels.base import Panel
from editor.panels.state_graph_side import draw_side
from editor.ui import Ui
from editor.widgets import cut, em, empty_state, fitted_text, icon_button
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
        self.zoom = 1.0
        # boxes beside one another where they were never moved
        self._columns = 3
        # the number of states that the zoom was chosen for
        self._fitted_for = -1
        self._menu_of: tuple[str, int] = ("", -1)
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
        side = min(em(14), 0.4 * imgui.get_content_region_avail().x)
        if imgui.begin_child("##side", (side, 0)):
            draw_side(ui, editor)
        imgui.end_child()
        imgui.same_line()
        if editor.model is not None and editor.model.states:
            self._graph(ui, editor, editor.model)

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
            fitted_text("Drag a state to move it; Shift and drag to another: a transition", theme.FAINT,
                        more="Right click: more. Wheel: zoom. Middle button: move along")  # fmt: skip

    def _graph(self, ui: Ui, editor: AnimationEditor, model: Any) -> None:
        at, avail = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
        width, height = max(avail.x, 40.0), max(avail.y, 40.0)
        imgui.invisible_button("##graph", (width, height))
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        if len(model.states) != self._fitted_for:
            self._fit(model, width, height)
        wheel = imgui.get_io().mouse_wheel
        if imgui.is_item_hovered() and wheel:
            self._zoom_at(at.x, at.y, wheel)
        if imgui.is_item_hovered() and imgui.is_mouse_down(imgui.MouseButton_.middle):
            delta = imgui.get_io().mouse_delta
            self.shift = (self.shift[0] + delta.x, self.shift[1] + delta.y)
        elif imgui.is_item_hovered() and imgui.is_mouse_double_clicked(0) and not self._under(*_mouse()):
            self._fitted_for = -1
        self.origin = (at.x + self.shift[0], at.y + self.shift[1])
        lines = imgui.get_window_draw_list()
        lines.push_clip_rect((at.x, at.y), (at.x + width, at.y + height), True)
        lines.add_rect_filled((at.x, at.y), (at.x + width, at.y + height), theme.u32(theme.FRAME), 3)
        self.boxes = {name: self._box(i, state) for i, (name, state) in enumerate(model.states.items())}
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

    def _em(self, count: float = 1.0) -> float:
        """`count` times the height of the graph's font, which the zoom scales."""
        return em(count) * self.zoom

    def _fit(self, model: Any, width: float, height: float) -> None:
        """The whole graph in the field, at most as large as text elsewhere."""
        self._fitted_for, self.shift = len(model.states), (0.0, 0.0)
        self.zoom, self._columns = 1.0, 1
        for columns in range(1, len(model.states) + 1):  # the arrangement of what was never moved that shows it largest
            ends = [self._at(i, state, columns) for i, state in enumerate(model.states.values())]
            right, low = max(x for x, _ in ends) + BOX[0] + 1.0, max(y for _, y in ends) + BOX[1] + 1.0
            zoom = min(max(min(width / em(right), height / em(low)), 0.3), 1.0)
            if columns == 1 or zoom > self.zoom:
                self.zoom, self._columns = zoom, columns

    def _zoom_at(self, left: float, top: float, wheel: float) -> None:
        """Larger or smaller; what is under the pointer stays there."""
        x, y = _mouse()
        zoom = min(max(self.zoom * 1.15**wheel, 0.3), 2.5)
        by = zoom / self.zoom
        self.shift = (x - left - by * (x - left - self.shift[0]), y - top - by * (y - top - self.shift[1]))
        self.zoom = zoom

    def _box(self, number: int, state: Any) -> tuple[float, float]:
        """The upper left corner of a state's box in the window; in rows where it was never moved."""
        at = self._at(number, state, self._columns)
        return self.origin[0] + self._em(at[0]), self.origin[1] + self._em(at[1])

    @staticmethod
    def _at(number: int, state: Any, columns: int) -> tuple[float, float]:
        """Where a state's box is, in em of the graph: where it was put, else in its row."""
        row, column = divmod(number, columns)
        if state.at is None:
            return 1.0 + column * (BOX[0] + 6.5), 2.0 + row * (BOX[1] + 2.4)
        return float(state.at[0]), float(state.at[1])

    def _text(self, x: float, y: float, color: int, value: str) -> None:
        imgui.get_window_draw_list().add_text(imgui.get_font(), em(self.zoom), (x, y), color, value)

    def _middle(self, name: str) -> tuple[float, float]:
        x, y = self.boxes[name]
        return x + self._em(BOX[0]) / 2, y + self._em(BOX[1]) / 2

    def _state(self, name: str, state: Any, now: bool, share: float, chosen: bool, start: bool) -> None:
        lines = imgui.get_window_draw_list()
        x, y = self.boxes[name]
        w, h = self._em(BOX[0]), self._em(BOX[1])
        lines.add_rect_filled((x, y), (x + w, y + h), theme.u32((*theme.ACCENT[:3], 0.30) if now else theme.RAISED), 5)
        if now and share >= 0.0:
            lines.add_rect_filled((x + 3, y + h - 5), (x + 3 + (w - 6) * share, y + h - 2), theme.u32(theme.ACCENT))
        lines.add_rect(
            (x, y), (x + w, y + h), theme.u32(theme.ACCENT if chosen else (1, 1, 1, 0.2)), 5, 2.0 if chosen else 1.0
        )
        title, plays = ("▸ " if start else "") + name, state.clip or f"{state.blend} (blend)"
        room, mouse = (w - self._em(0.9)) / self.zoom, imgui.get_io().mouse_pos
        shown = cut(title, room), cut(plays, room)
        self._text(x + self._em(0.5), y + self._em(0.2), theme.u32(theme.TEXT), shown[0])
        self._text(x + self._em(0.5), y + self._em(1.25), theme.u32(theme.DIM), shown[1])
        if shown != (title, plays) and imgui.is_item_hovered() and x <= mouse.x <= x + w and y <= mouse.y <= y + h:
            imgui.set_tooltip(f"{name}\n{plays}")

    def _ends(self, t: Any) -> tuple[tuple[float, float], tuple[float, float]]:
        """Where an arrow begins and ends; arrows both ways lie side by side."""
        target = self._middle(t.target)
        if t.source == "any":
            return (target[0], target[1] - self._em(BOX[1])), (target[0], target[1] - self._em(BOX[1]) / 2)
        source = self._middle(t.source)
        dx, dy = target[0] - source[0], target[1] - source[1]
        length = max(math.hypot(dx, dy), 1e-6)
        side = (-dy / length * self._em(0.5), dx / length * self._em(0.5))

        def edge(point: tuple[float, float], sign: float) -> tuple[float, float]:
            reach = min(
                self._em(BOX[0]) / 2 / max(abs(dx / length), 1e-6), self._em(BOX[1]) / 2 / max(abs(dy / length), 1e-6)
            )
            return point[0] + sign * dx / length * reach + side[0], point[1] + sign * dy / length * reach + side[1]

        return edge(source, 1.0), edge(target, -1.0)

    def _arrow(self, t: Any, chosen: bool, now: bool) -> None:
        lines = imgui.get_window_draw_list()
        a, b = self._ends(t)
        color = theme.u32(theme.ACCENT if chosen or now else (0.65, 0.68, 0.72, 0.8))
        lines.add_line(a, b, color, 2.5 if now or chosen else 1.4)
        angle = math.atan2(b[1] - a[1], b[0] - a[0])
        tip = [
            (b[0] - self._em(0.6) * math.cos(angle + s), b[1] - self._em(0.6) * math.sin(angle + s))
            for s in (0.4, -0.4)
        ]
        lines.add_triangle_filled(b, tip[0], tip[1], color)
        words = ", ".join(t.when)
        if t.source == "any":
            words = f"any: {words}"
        if words:
            words = cut(words, max(abs(b[0] - a[0]), self._em(6)) / self.zoom)
            size = imgui.calc_text_size(words)
            wide, high = size.x * self.zoom, size.y * self.zoom
            under = b[0] < a[0]  # beside its arrow, away from the one that goes back
            x, y = (a[0] + b[0]) / 2 - wide / 2, (a[1] + b[1]) / 2 - high * (1.0 if under else 0.0)
            if t.source == "any":  # its arrow is short and upright: beside it
                x, y = a[0] + self._em(0.5), a[1] - self._em(0.2)
            self._text(x, y, theme.u32(theme.TEXT if chosen else theme.DIM), words)

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
                view.transition = self._arrow_under(x, y, model)
        elif imgui.is_item_hovered() and imgui.is_mouse_clicked(1):
            self._menu_of = (self._under(x, y), self._arrow_under(x, y, model))
            if self._menu_of[0]:
                view.state, view.transition = self._menu_of[0], -1
            elif self._menu_of[1] >= 0:
                view.state, view.transition = "", self._menu_of[1]
            imgui.open_popup("##graph-menu")
        self._menu(ui, editor, model)
        if self._held:
            if imgui.is_mouse_down(0):
                if abs(io.mouse_delta.x) + abs(io.mouse_delta.y) > 0:
                    at = [
                        (x + self._offset[0] - self.origin[0]) / self._em(),
                        (y + self._offset[1] - self.origin[1]) / self._em(),
                    ]
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

    def _arrow_under(self, x: float, y: float, model: Any) -> int:
        near = [(_distance((x, y), *self._ends(t)), i) for i, t in enumerate(model.transitions)]
        return min(near)[1] if near and min(near)[0] < em(0.6) else -1

    def _menu(self, ui: Ui, editor: AnimationEditor, model: Any) -> None:
        """What a right click opened: on a state, an arrow, or nothing."""
        if not imgui.begin_popup("##graph-menu"):
            return
        view, (state, arrow) = ui.session.animating, self._menu_of
        animation = animation_of(ui.session)
        if state in model.states:
            if imgui.menu_item("Start here", "", model.start == state)[0]:
                self._try(ui, lambda: editor.put((("start",), state), label=f"Start in {state}"))
            steered = animation.animator is not None and drive_of(ui.session) == "states"
            if imgui.menu_item("Go there now", "", False, steered)[0]:
                animation.animator.enter(state)
                ui.session.seek(ui.session.playback.time)
            if imgui.menu_item_simple("Transition here from any state"):
                self._try(ui, lambda: editor.add_transition("any", state))
                view.state, view.transition = "", len(model.transitions)
            if imgui.menu_item_simple("Delete state"):
                self._try(ui, lambda: editor.remove_state(state))
                view.state = ""
        elif 0 <= arrow < len(model.transitions):
            if imgui.menu_item_simple("Delete transition"):
                self._try(ui, lambda: editor.remove_transition(arrow))
                view.transition = -1
        elif imgui.menu_item_simple("Show the whole graph"):
            self._fitted_for = -1
        imgui.end_popup()

    def _under(self, x: float, y: float) -> str:
        for name, (left, top) in reversed(self.boxes.items()):
            if left <= x <= left + self._em(BOX[0]) and top <= y <= top + self._em(BOX[1]):
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
