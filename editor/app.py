"""The window: hello_imgui's runner around a session. Owns the frame loop; knows no scene and no GL."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from imgui_bundle import hello_imgui, imgui

from editor import (
    dropping,
    file_drop,
    keys,
    layout,
    layout_slots,
    menus,
    prefab_updates,
    recovering,
    strings,
    theme,
    turntable,
    waking,
    window_state,
)  # fmt: skip
from editor.baking import surroundings_waiting
from editor.dialogs import Dialogs
from editor.dialogs.modals import draw_error_bar
from editor.file_watch import LOOK, FileWatch
from editor.fonts import HINT, cjk_font
from editor.idling import AWAKE, NEVER, Idling
from editor.interrupts import Interrupts
from editor.operations import Operations
from editor.panels.base import Panel
from editor.panels.registry import make_panels
from editor.panels.report import drop_context
from editor.panels.viewport import ViewportPanel
from editor.plugins.manager import PluginManager
from editor.plugins.windows import draw_windows
from editor.preferences import layout_path
from editor.session import Session
from editor.strings import doors
from editor.ui import Ui
from engine.core.errors import DeviceError, LucarnaError

#: frames a second of a window that `_pace` says nothing about: there is none, or tests drive it
UNPACED_FPS = 10.0
#: the wheel is at rest after so many seconds
WHEEL_REST = 0.2
#: how long a screenshot waits for a file that is still being opened, seconds
SCREENSHOT_PATIENCE = 120.0


class App:
    """`frames`: quit after so many frames once the scene is there (for screenshots); 0 runs until the user quits."""

    def __init__(
        self,
        session: Session,
        operations: Operations,
        *,
        size: tuple[int, int] = (1440, 900),
        frames: int = 0,
        remember_layout: bool = True,
        null_platform: bool = False,
        plugins: bool = True,
        fps: int | None = None,
    ) -> None:
        #: pictures a second at most, this time; None: as the preferences say
        self.fps = fps
        self.ui = Ui(session, operations)
        self.ui.plugins = self.plugins = PluginManager(session, operations, active=plugins)
        self._language = "en"
        self.panels = make_panels()
        self.dialogs = Dialogs()
        self.frames = frames
        self.null_platform = null_platform
        self.failure: LucarnaError | None = None
        self._drop: Any = None
        self._start = time.monotonic()
        self._settled = 0
        self._wheeled = self._followed = self._began = -1e9
        self._focus = ""
        self.idling = Idling()
        self.interrupts = Interrupts()
        self._files = FileWatch()
        self._longest = NEVER
        self._sight: Callable[[], window_state.Sight] = lambda: "front"
        #: what to do once the window is there: opening a file takes the processor that the first frame wants
        self.on_shown: Callable[[], None] | None = None
        #: panels whose tabs come to the front once a workspace is there
        self._front: tuple[str, ...] = ()
        self.params = self._make_params(size, remember_layout)

    def run(self) -> None:
        """Show the window until it is closed. Raises DeviceError when there is no usable graphics device,
        KeyboardInterrupt after Ctrl+C in the terminal; unsaved edits then wait for the next start."""
        try:
            with self.interrupts.listening():
                hello_imgui.run(self.params)
        except RuntimeError as error:
            if self.ui.drawn:  # the window was there: this is a defect, and its traceback is wanted
                raise
            raise DeviceError(
                f"no window could be opened: {error}", hint="is there a display, and does its driver have OpenGL 4.5?"
            ) from error
        if self.failure is not None:
            raise self.failure
        if self.interrupts.signal:
            raise KeyboardInterrupt

    def panel(self, kind: type[Panel]) -> Any:
        return next(p for p in self.panels if isinstance(p, kind))

    # --- set-up ---

    def _make_params(self, size: tuple[int, int], remember_layout: bool) -> hello_imgui.RunnerParams:
        p = hello_imgui.RunnerParams()
        p.app_window_params.window_title = "Lucarna"
        p.app_window_params.window_geometry.size = size
        p.app_window_params.restore_previous_geometry = remember_layout
        gl = p.renderer_backend_options.open_gl_options
        gl.major_version, gl.minor_version, gl.glsl_version, gl.use_core_profile = 4, 5, "450", True
        gl.anti_aliasing_samples = 0  # imgui smooths its own edges; multisampling only slows the software rasteriser
        w = p.imgui_window_params
        w.default_imgui_window_type = hello_imgui.DefaultImGuiWindowType.provide_full_screen_dock_space
        w.show_menu_bar, w.show_menu_app, w.show_menu_view = True, False, False
        w.show_status_bar, w.show_status_fps, w.remember_status_bar_settings = True, False, False
        w.remember_theme = False
        current = layout.named(self.ui.session.preferences.workspace)
        compact = layout.is_compact(size[0], theme.FONT_SIZE * self.ui.session.preferences.ui_scale)
        self._layouts = {
            w.name: layout.docking_params(self.panels, self._panel_function, w, compact=compact)
            for w in layout.WORKSPACES
        }
        p.docking_params = self._layouts[current.name]
        p.alternative_docking_layouts = [x for name, x in self._layouts.items() if name != current.name]
        p.ini_disable = not remember_layout
        if remember_layout:
            layout_path().parent.mkdir(parents=True, exist_ok=True)
            p.ini_folder_type = hello_imgui.IniFolderType.absolute_path
            p.ini_filename = str(layout_path())
        p.fps_idling.fps_idle = UNPACED_FPS
        p.fps_idling.time_active_after_last_event = AWAKE
        p.fps_idling.remember_enable_idling = False
        p.fps_idling.enable_idling = self.frames == 0
        c = p.callbacks
        c.load_additional_fonts = self._load_fonts
        c.setup_imgui_style = self._style
        c.setup_imgui_config = self._configure
        c.post_init = self._post_init
        c.show_menus = lambda: menus.draw_menu_bar(self.ui)
        c.show_status = lambda: menus.draw_status_bar(self.ui)
        c.pre_new_frame = self._arrange
        c.post_new_frame = self._begin_frame
        c.post_render_dockable_windows = self._end_frame
        c.before_exit = self._before_exit
        c.confirm_exit = self.ui.session.request_quit
        if self.null_platform:
            p.platform_backend_type = hello_imgui.PlatformBackendType.null
            p.renderer_backend_type = hello_imgui.RendererBackendType.null
        self._guard(c)
        return p

    def _guard(self, callbacks: hello_imgui.RunnerCallbacks) -> None:
        """An exception must not unwind through the C++ frame loop: keep it, close the window, raise it after."""
        for name in ("post_init", "post_new_frame", "post_render_dockable_windows", "show_menus", "show_status"):
            setattr(callbacks, name, self._guarded(getattr(callbacks, name)))

    def _guarded(self, function: Callable[[], None]) -> Callable[[], None]:
        def call() -> None:
            try:
                function()
            except LucarnaError as error:
                self.failure = self.failure or error
                self.params.app_shall_exit = True

        return call

    def _load_fonts(self) -> None:
        self.ui.fonts = theme.load_fonts()

    def _configure(self) -> None:
        hello_imgui.imgui_default_settings.setup_default_imgui_config()
        io = imgui.get_io()
        io.config_flags &= ~imgui.ConfigFlags_.nav_enable_gamepad
        io.config_drag_click_to_input_text = True
        io.config_input_text_enter_keep_active = False
        context = imgui.get_current_context()
        context.config_nav_windowing_key_next = context.config_nav_windowing_key_prev = 0  # Ctrl+Tab is ours
        io.config_windows_move_from_title_bar_only = True  # a drag on the gizmo is no drag of the window

    def _post_init(self) -> None:
        session = self.ui.session
        if self.null_platform:
            io = imgui.get_io()
            io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
        else:
            self._drop = file_drop.install(_glfw_window(), self.dropped)
            self._sight = window_state.sight(_glfw_window())
            post = waking.waker()
            waking.connect(post)
            self._longest = NEVER if post is not None else 1.0  # nobody could wake it: it looks once a second
            session.shaders.wake = session.asset_pictures.wake = session.sources.wake = waking.wake
        if session.device is None:
            session.device = session.host.open_device(attach=not self.null_platform)
        self.plugins.start()

    def dropped(self, paths: list[Path]) -> None:
        """Files were dropped on the window."""
        dropping.take(self.ui.session, paths, add=bool(imgui.get_io().key_ctrl))

    # --- the frame ---

    def _speak(self, language: str) -> None:
        """Another language for the interface, at once; windows keep their places."""
        self._language = language
        doors.apply(language)
        if strings.language() == "zh" and cjk_font() is None and not self.null_platform:
            self.ui.session.messages.warn("There is no font with Chinese glyphs: it stays English", hint=HINT)
            doors.apply("en")
        for panel, window in zip(self.panels, self.params.docking_params.dockable_windows, strict=True):
            window.label = panel.label

    def _begin_frame(self) -> None:
        session = self.ui.session
        io = imgui.get_io()
        self.ui.pixel_scale = max(float(io.display_framebuffer_scale.x), 1e-3)
        self._began = time.monotonic()
        self.idling.began(self._began, woken=waking.take(), waited=bool(self.params.fps_idling.is_idling))
        self.idling.sight = self._sight()
        if self.interrupts.signal:
            self.params.app_shall_exit = True
        session.poll()
        self.plugins.poll()
        if session.preferences.language != self._language:
            self._speak(session.preferences.language)
        session.interacting = not self.frames and self._interacting(io)
        seconds = min(float(io.delta_time), 0.25) if self.idling.plays(session) else 0.0
        session.tick(seconds)
        turntable.step(session, seconds)
        self.ui.flying = self.panel(ViewportPanel).flying
        keys.run_shortcuts(self.ui, flying=self.ui.flying)
        self._requests()

    def _interacting(self, io: Any) -> bool:
        """A button is held, the wheel turned a moment ago, or time runs."""
        now = imgui.get_time()
        if io.mouse_wheel or io.mouse_wheel_h:
            self._wheeled = now
        held = any(imgui.is_mouse_down(button) for button in range(3))
        if held or io.mouse_delta.x or io.mouse_delta.y or io.mouse_wheel or io.input_queue_characters.size():
            self.ui.session.image.disturb()
        session = self.ui.session
        session.handling = held or now - self._wheeled < WHEEL_REST
        return session.handling or session.playback.playing or session.tools.turning

    def _pace(self) -> None:
        """How long the window may sleep now; before it does, a thread takes over looking at files."""
        session, now = self.ui.session, time.monotonic()
        caret = bool(imgui.get_io().want_text_input)
        pause = self.idling.pause(session, now, moving=session.handling, caret=caret, asked=self.ui.asked_for)
        self.ui.asked_for = NEVER
        if pause > LOOK and now - self._followed > LOOK:
            self._followed = now
            if self._files.follow(self._watched()):
                self.idling.look_again(now)
                pause = self.idling.pause(session, now, moving=False, caret=caret)
        idle = self.params.fps_idling
        idle.fps_max = float(session.preferences.fps_limit if self.fps is None else self.fps)
        pause = min(pause, self._longest)
        if pause <= 0.0:
            hello_imgui.request_refresh()
        else:
            idle.fps_idle = 1.0 / (pause + now - self._began)  # the library counts from the frame's beginning

    def _watched(self) -> Iterator[Path]:
        """Files that frames look at themselves, and whose change should bring one."""
        session = self.ui.session
        yield from (text.path for text in session.code.documents)
        if session.document is not None:
            yield from prefab_updates.files_of(session.document)
        yield from self.plugins.files()
        for panel, window in zip(self.panels, self.params.docking_params.dockable_windows, strict=True):
            if window.is_visible:
                yield from panel.watched()

    def _panel_function(self, panel: Panel) -> Callable[[], None]:
        return self._guarded(lambda: panel.draw(self.ui) if panel.padded else self._draw_unpadded(panel))

    def _draw_unpadded(self, panel: Panel) -> None:
        flags = (
            imgui.WindowFlags_.no_scrollbar | imgui.WindowFlags_.no_scroll_with_mouse | imgui.WindowFlags_.no_collapse
        )
        if self._focus == panel.title:
            self._focus = ""
            imgui.set_next_window_focus()
        imgui.push_style_var(imgui.StyleVar_.window_padding, (0, 0))
        shown = imgui.begin(panel.label, None, flags)[0]
        imgui.pop_style_var()
        if shown:
            panel.draw(self.ui)
        imgui.end()

    def _end_frame(self) -> None:
        session = self.ui.session
        draw_error_bar(self.ui, imgui.get_frame_height() * 2.6)
        draw_windows(self.ui, self.plugins)
        self.dialogs.draw(self.ui)
        if not imgui.is_any_item_active() and not imgui.is_mouse_down(imgui.MouseButton_.left):
            session.end_gesture()
        recovering.keep(session)
        self.ui.drawn += 1
        if not (self.null_platform or self.frames or self.params.use_imgui_test_engine):
            self._pace()
        if self.ui.drawn > 1 and self.on_shown is not None:
            begin, self.on_shown = self.on_shown, None
            begin()
        elif self.frames and self.on_shown is None:
            self._count_frames()

    def _requests(self) -> None:
        requests = self.ui.session.ui
        if requests.copy_text:
            imgui.set_clipboard_text(requests.copy_text)
            requests.copy_text = ""
        if requests.paste is not None:
            take, requests.paste = requests.paste, None
            take(imgui.get_clipboard_text())
        if requests.quit:
            self.params.app_shall_exit = True
        if requests.focus_panel:
            self._show_panel(requests.focus_panel)
            requests.focus_panel = ""
        if requests.workspace:
            self._switch(requests.workspace)
            requests.workspace = ""
        if requests.reset_layout:
            requests.reset_layout = False
            workspace = layout.named(self.ui.session.preferences.workspace)
            compact = layout.is_compact(imgui.get_io().display_size.x, imgui.get_font_size())
            layout.arrange(self.params.docking_params, self.panels, workspace, compact=compact)
        if requests.scale_changed:
            requests.scale_changed = False
            self._style()

    def _switch(self, name: str) -> None:
        """Arrange the panels as a workspace has them."""
        preferences = self.ui.session.preferences
        if name == preferences.workspace or self.null_platform:
            preferences.workspace = name
            return
        preferences.workspace = name
        hello_imgui.switch_layout(name)
        self._front = layout.named(name).front
        self.ui.session.remember()

    def _arrange(self) -> None:
        """Between two frames: keep the arrangement in a slot, or take it from one."""
        requests = self.ui.session.ui
        if self._front and self.params.docking_params.layout_name == self.ui.session.preferences.workspace:
            for panel, window in zip(self.panels, self.params.docking_params.dockable_windows, strict=True):
                window.focus_window_at_next_frame = panel.title in self._front
            self._front = ()
        if requests.layout_slot is not None and self.ui.drawn:
            request, requests.layout_slot = requests.layout_slot, None
            requests.notice = layout_slots.run(request, self.params.docking_params.dockable_windows)

    def _style(self) -> None:
        preferences = self.ui.session.preferences
        theme.use(preferences.theme)
        # the window library scales sizes by the display's factor itself, once, on its second frame
        display = hello_imgui.dpi_window_size_factor() if self.ui.drawn > 1 and not self.null_platform else 1.0
        theme.apply(preferences.ui_scale, display)

    def _show_panel(self, title: str) -> None:
        """Open the panel of that title and bring it to the front."""
        for panel, window in zip(self.panels, self.params.docking_params.dockable_windows, strict=True):
            if panel.title == title:
                window.is_visible = True
                window.focus_window_at_next_frame = True
                self._focus = "" if panel.padded else title  # one that begins its own window takes the focus itself

    def _count_frames(self) -> None:
        """Leave after `frames` frames that show what was asked for."""
        session = self.ui.session
        working = session.job is not None or session.image.compiling is not None or surroundings_waiting(session)
        waiting = working and time.monotonic() - self._start < SCREENSHOT_PATIENCE
        self._settled = 0 if waiting else self._settled + 1
        if self._settled == self.frames - 2:
            session.image.invalidate()  # so that timings show a frame's cost, not that of the first one
        if self._settled >= self.frames:
            self.params.app_shall_exit = True

    def _before_exit(self) -> None:
        session = self.ui.session
        if session.job is not None:
            session.job.cancel()
        if self.failure is not None or (self.interrupts.signal and session.unsaved):  # neither may cost edits
            recovering.leave(session)
        waking.connect(None)
        self._files.stop()
        session.shaders.stop()
        session.sources.stop()
        session.asset_pictures.stop()
        session.close_all()
        session.asset_pictures.forget(session)
        drop_context()
        session.remember()


def _glfw_window() -> int:
    """The address of the window's GLFWwindow; 0 where another platform library made it."""
    address = getattr(hello_imgui, "get_glfw_window_address", None)  # there, but not in the type stubs
    return int(address()) if address is not None else 0
