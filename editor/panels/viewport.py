"""Viewport: the picture, the pointer's gestures in it, and what is drawn over it."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

from imgui_bundle import imgui

from editor import (
    axis_widget,
    camera_controls,
    focusing,
    icons,
    legend_overlay,
    light_outlines,
    markers,
    overlay,
    skeleton_overlay,
    theme,
)
from editor.camera_controls import OrbitCamera
from editor.compare_overlay import CompareOverlay
from editor.gizmo_widget import GizmoWidget
from editor.navigation import motion_for, wheel_motion
from editor.panels import document_tabs, timeline, viewport_drop, viewport_strip
from editor.panels.base import Panel
from editor.panels.timings import short_count
from editor.physical_keys import letter_at
from editor.ui import Ui
from editor.widgets import cut, em, fitted, text, tooltip

#: a press that moves less than this, in em, is a click
CLICK_SLOP = 0.25
WHEEL_STEP = 0.88
FLY_KEYS = {"w": (0, 0, 1), "s": (0, 0, -1), "a": (-1, 0, 0), "d": (1, 0, 0), "q": (0, -1, 0), "e": (0, 1, 0)}
BUTTONS = ("left", "right", "middle")
#: stands for the button of a flight that needs none
HANDS_FREE = -1


class ViewportPanel(Panel):
    title: ClassVar[str] = "Viewport"
    icon: ClassVar[str] = icons.APP
    dock: ClassVar[str] = "MainDockSpace"
    padded: ClassVar[bool] = False
    closable: ClassVar[bool] = False

    def __init__(self) -> None:
        self.motion = ""
        self._button = 0
        self._travel = 0.0
        #: while flying, bare keys belong to the camera
        self.flying = False
        self.gizmo = GizmoWidget()
        self.compare = CompareOverlay()
        #: node row of the light or camera whose sign is under the pointer, or -1
        self.marker = self._pressed = -1
        #: node row of the bone under the pointer, or -1
        self.bone = self._pressed_bone = -1
        #: the picture in the window: x, y, width, height, imgui units
        self.area = (0.0, 0.0, 1.0, 1.0)
        #: where a drag began, imgui units
        self._start = (0.0, 0.0)

    def draw(self, ui: Ui) -> None:
        session = ui.session
        if session.document is None:
            self.motion, self.flying = "", False
            _start_page(ui)
            return
        document_tabs.draw(ui)
        viewport_strip.draw(ui)
        imgui.set_cursor_pos((0, imgui.get_cursor_pos_y() + em(0.1)))
        avail = imgui.get_content_region_avail()
        bar = imgui.get_frame_height() + em(0.55) if session.playback.available else 0.0
        width, height = max(avail.x, 1.0), max(avail.y - bar, 1.0)
        self._picture(ui, width, height)
        if session.playback.available:
            timeline.draw(ui)

    def _picture(self, ui: Ui, width: float, height: float) -> None:
        session = ui.session
        origin = imgui.get_cursor_screen_pos()
        self.area = ui.viewport_area = (origin.x, origin.y, width, height)
        ui.viewport_at = ui.drawn
        scale = ui.pixel_scale * session.image.resolution(session)
        size = round(width * scale), round(height * scale)
        self.compare.release(ui)
        session.comparing.update(session, *size)
        frame = session.image.update(session, *size)
        session.comparing.after(session)
        if self.gizmo.busy and not self.motion:  # its handles want a press that no other item takes
            imgui.dummy((width, height))
        else:
            imgui.invisible_button(
                "##picture",
                (width, height),
                imgui.ButtonFlags_.mouse_button_left
                | imgui.ButtonFlags_.mouse_button_right
                | imgui.ButtonFlags_.mouse_button_middle,
            )
        hovered, active = bool(imgui.is_item_hovered()), bool(imgui.is_item_active())
        viewport_drop.accept(ui, origin.x, origin.y, width, height)
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        lines = imgui.get_window_draw_list()
        end = (origin.x + width, origin.y + height)
        lines.push_clip_rect((origin.x, origin.y), end, True)
        native = frame.color.native if frame is not None else 0
        if native:
            lines.add_image(imgui.ImTextureRef(native), (origin.x, origin.y), end, (0, 0), (1, 1))
        else:  # the null device has no picture
            lines.add_rect_filled((origin.x, origin.y), end, theme.u32(theme.FRAME))
        free = hovered and not self.motion
        over_axes = self.compare.draw(ui, origin.x, origin.y, width, height, hoverable=free)
        over_axes |= self._overlays(ui, origin.x, origin.y, width, height, free and not over_axes)
        blocked = bool(self.motion) or over_axes or bool(imgui.get_io().key_alt) or session.tools.measuring
        blocked |= session.tools.focusing
        self.gizmo.draw(ui, origin.x, origin.y, width, height, blocked=blocked)
        if self.motion == "select" and self._travel > em(CLICK_SLOP):
            overlay.draw_rectangle(self._start, (imgui.get_io().mouse_pos.x, imgui.get_io().mouse_pos.y))
        lines.pop_clip_rect()
        self._gestures(ui, origin.x, origin.y, width, height, hovered and not over_axes, active)

    def _overlays(self, ui: Ui, x: float, y: float, width: float, height: float, hoverable: bool) -> bool:
        session, document = ui.session, ui.session.document
        assert document is not None
        if session.preferences.show_outline:
            for row in document.selection[-16:]:
                overlay.draw_box(session.camera, *document.bounds((row,)), (x, y), width, height)
        self.bone = skeleton_overlay.draw(session, (x, y), width, height, hoverable)
        light_outlines.draw(session, (x, y), width, height)
        self.marker = markers.draw(document, session.camera, (x, y), width, height, hoverable=hoverable)
        overlay.draw_measure(session.camera, session.tools, (x, y), width, height)
        over_axes = False
        if session.preferences.show_axes and width > em(12) and height > em(10):
            over_axes, view = axis_widget.draw(session.camera, x + width, y, hoverable=hoverable)
            if view:
                ui.operations.run(f"view.{view}", session)
        left, bottom = x + em(0.6), y + height - em(0.6)
        legend = getattr(session.image.frame, "legend", None)
        if legend is not None:
            bottom -= legend_overlay.draw(legend, left, bottom, width - em(1.2)) + em(0.4)
        if session.preferences.show_stats and session.image.frame is not None:
            counters = session.image.frame.stats.counters
            parts = [f"{short_count(counters[n])} {n}" for n in ("triangles", "draws") if n in counters]
            if session.camera.orthographic:
                parts.append("orthographic")
            if parts:
                height_used = imgui.get_text_line_height() + 2 * imgui.get_style().frame_padding.y
                overlay.chip(left, bottom - height_used, "   ".join(parts), theme.DIM)
        self._look_card(ui, x + width - em(0.6), y + height - em(0.6), width)
        over_badge = self._badge(ui, left, y + em(0.6), width - em(6.5), hoverable)
        return over_axes or over_badge

    def _look_card(self, ui: Ui, right: float, bottom: float, room: float) -> None:
        """Grey, chrome and a colour chart in the corner, under the scene's surroundings and this look."""
        from engine.app.look_card import ASPECT

        height = em(5.2)
        if not ui.session.preferences.show_look_card or room < 2.0 * ASPECT * height:
            return
        scale = ui.pixel_scale
        native = ui.session.look_card.native(ui.session, round(ASPECT * height * scale), round(height * scale))
        low, high = (right - ASPECT * height, bottom - height), (right, bottom)
        lines = imgui.get_window_draw_list()
        if native:
            lines.add_image_rounded(imgui.ImTextureRef(native), low, high, (0, 0), (1, 1), 0xFFFFFFFF, em(0.3))
        lines.add_rect(low, high, theme.u32(theme.BORDER), em(0.3))

    def _badge(self, ui: Ui, x: float, y: float, width: float, hoverable: bool) -> bool:
        """What is wrong with the picture; a click goes to the shader's line. True when the pointer is on it."""
        session = ui.session
        line = session.shaders.badge or session.image.error
        if not line:
            return False
        w, h = overlay.chip(x, y, cut(f"{icons.ERROR}  {line}", width), theme.ERROR)
        over = hoverable and bool(imgui.is_mouse_hovering_rect((x, y), (x + w, y + h)))
        if over and session.shaders.problems:
            imgui.set_mouse_cursor(imgui.MouseCursor_.hand)
            imgui.set_tooltip(f"{session.shaders.problems[0].text}\n\nClick to go there (F8)")
            if imgui.is_mouse_clicked(imgui.MouseButton_.left):
                ui.operations.run("shader.next-error", session)
        return over

    # --- gestures ---

    def _gestures(self, ui: Ui, x: float, y: float, width: float, height: float, hovered: bool, active: bool) -> None:
        io, session = imgui.get_io(), ui.session
        if hovered and not self.motion:
            for index, name in enumerate(BUTTONS):
                if imgui.is_mouse_clicked(index) and not (self.gizmo.busy and index == 0):
                    self.motion = motion_for(session.preferences.keymap, name, _modifiers()) or "none"
                    self._button, self._travel = index, 0.0
                    self._start, self._pressed = (io.mouse_pos.x, io.mouse_pos.y), self.marker
                    self._pressed_bone = self.bone
                    session.tools.flying = False
                    imgui.set_window_focus()
            if session.tools.flying and not self.motion:
                self.motion, self._button, self._travel = "fly", HANDS_FREE, 0.0
        if self.motion:
            self._travel += abs(io.mouse_delta.x) + abs(io.mouse_delta.y)
            if self._held(ui):
                if self._travel > em(CLICK_SLOP) or self.motion == "fly":
                    self._move(ui, io.mouse_delta.x, io.mouse_delta.y, height, io.delta_time)
            else:
                u, v = (io.mouse_pos.x - x) / width, (io.mouse_pos.y - y) / height
                if self._travel <= em(CLICK_SLOP) and self._button == 0:
                    self._click(ui, u, v)
                elif self.motion == "select":
                    start = ((self._start[0] - x) / width, (self._start[1] - y) / height)
                    session.select_box(start, (u, v), add=bool(io.key_ctrl))
                self.motion = ""
        self.flying = self.motion == "fly"
        if self.flying:
            imgui.set_mouse_cursor(imgui.MouseCursor_.resize_all)
        if hovered or self.flying:
            self._wheel(ui, (io.mouse_pos.x - x) / width, (io.mouse_pos.y - y) / height, width / height, height)

    def _held(self, ui: Ui) -> bool:
        """Whether the motion goes on: its button is down, or nothing has ended a flight without one."""
        if self._button != HANDS_FREE:
            return bool(imgui.is_mouse_down(self._button))
        tools = ui.session.tools
        if any(map(imgui.is_mouse_clicked, range(3))) or imgui.is_key_pressed(imgui.Key.escape, False):
            tools.flying = False
        if any(imgui.is_key_down(getattr(imgui.Key, letter_at(key))) for key in FLY_KEYS):
            ui.again_in(0.0)
        return tools.flying

    def _click(self, ui: Ui, u: float, v: float) -> None:
        io, session = imgui.get_io(), ui.session
        if session.tools.focusing:
            focusing.focus_at(session, u, v)
        elif session.tools.measuring:
            session.measure(u, v)
        elif io.key_alt:
            session.pick_through(u, v)
        elif self._pressed_bone >= 0 and skeleton_overlay.pick(session, self._pressed_bone):
            pass
        elif self._pressed >= 0 and session.document is not None:
            session.document.select(self._pressed, toggle=bool(io.key_ctrl))
        else:
            session.pick(u, v, toggle=bool(io.key_ctrl))

    def _move(self, ui: Ui, dx: float, dy: float, height: float, seconds: float) -> None:
        session = ui.session
        camera = session.camera
        if self.motion == "orbit":
            camera = camera_controls.orbit(camera, dx, dy)
        elif self.motion == "pan":
            camera = camera_controls.pan(camera, dx, dy, height)
        elif self.motion == "dolly":
            camera = camera_controls.dolly(camera, dx, dy)
        elif self.motion == "fly":
            camera = self._fly(ui, camera_controls.look(camera, dx, dy), seconds)
        elif self.motion == "environment":
            turned = viewport_strip.wrap_degrees(
                float(getattr(session.settings, "environment_rotation", 0.0)) + 0.5 * dx
            )
            session.edit(
                "settings", "environment_rotation", (0,), ((turned,),), gesture="turn-light", label="Turn the light"
            )
        session.camera = camera

    def _fly(self, ui: Ui, camera: OrbitCamera, seconds: float) -> OrbitCamera:
        move = [0.0, 0.0, 0.0]
        for key, (right, up, forward) in FLY_KEYS.items():
            if imgui.is_key_down(getattr(imgui.Key, letter_at(key))):
                move = [move[0] + right, move[1] + up, move[2] + forward]
        speed = ui.session.preferences.fly_speed * camera.distance * (3.0 if imgui.get_io().key_shift else 1.0)
        return camera_controls.fly(camera, (move[0], move[1], move[2]), speed * min(seconds, 0.1))

    def _wheel(self, ui: Ui, u: float, v: float, aspect: float, height: float) -> None:
        io, session = imgui.get_io(), ui.session
        way = -1.0 if session.preferences.reverse_scroll else 1.0
        wheel, side = way * io.mouse_wheel, way * io.mouse_wheel_h
        if not wheel and not side:
            return
        if self.flying:
            session.preferences.fly_speed = min(max(session.preferences.fly_speed * 1.15**wheel, 0.001), 1000.0)
            session.ui.notice = f"Fly speed × {session.preferences.fly_speed:.2g}"
            return
        motion = wheel_motion(session.preferences.keymap, _modifiers(), session.preferences.pointer)
        if motion == "pan":
            session.camera = camera_controls.pan(session.camera, side * em(2), wheel * em(2), height)
        elif motion == "orbit":
            session.camera = camera_controls.orbit(session.camera, side * em(1.5), wheel * em(1.5))
        elif wheel:
            session.camera = camera_controls.zoom(session.camera, WHEEL_STEP**wheel, 2 * u - 1, 1 - 2 * v, aspect)


def _start_page(ui: Ui) -> None:
    """What stands here without a document: how to get one."""
    size = imgui.get_window_size()
    width = min(em(24), size.x - em(2))
    imgui.set_cursor_pos(((size.x - width) * 0.5, size.y * 0.3))
    imgui.begin_group()
    imgui.push_font(ui.fonts.bold, theme.FONT_SIZE * 1.7)
    text(icons.APP, theme.ACCENT)
    imgui.same_line(0, em(0.4))
    imgui.text_unformatted("Lucarna")
    imgui.pop_font()
    text("Drop a model, a scene or a folder on the window,", theme.DIM)
    text("or open one:", theme.DIM)
    imgui.spacing()
    if imgui.button(f"{icons.FOLDER_OPEN}  Open…", (em(9), 0)):
        ui.operations.run("file.open", ui.session)
    imgui.same_line()
    text("Ctrl+O", theme.FAINT)
    if ui.session.preferences.recent:
        imgui.spacing()
        text("Recent", theme.FAINT)
    for i, recent in enumerate(ui.session.preferences.recent[:6]):
        if imgui.selectable(f"{fitted(Path(recent).name, width)}###recent{i}", False, 0, (width, 0))[0]:
            ui.session.open(Path(recent))
        tooltip(recent)
    imgui.end_group()


def _modifiers() -> frozenset[str]:
    io = imgui.get_io()
    held = {"ctrl": io.key_ctrl, "shift": io.key_shift, "alt": io.key_alt}
    return frozenset(name for name, down in held.items() if down)


PANEL = ViewportPanel
