"""The plain runtime window: the scene, a free camera, nothing of the editor.

W A S D move, Q E down and up, the wheel sets the speed, dragging with a button looks around, Space pauses, R starts the
animation again, Home goes back to the first camera, Escape closes.
"""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from engine.app.runtime import MANY_PICTURES, Runtime
from engine.core.errors import DeviceError
from engine.gpu import open_device
from engine.math.quat import from_axis_angle, to_matrix3
from engine.render.camera import Camera
from engine.render.view import View

LOOK_SPEED = 0.004  # radians a pixel


class FreeCamera:
    """Yaw and pitch about +Y and the camera's own right; moves in metres a second."""

    def __init__(self, camera: Camera, scale: float) -> None:
        self.camera = camera
        self.speed = max(scale, 1e-6)
        back = camera.world_from_camera[:3, 2]
        self.yaw = math.atan2(back[0], back[2])
        self.pitch = -math.asin(float(np.clip(back[1], -1.0, 1.0)))

    def look(self, dx: float, dy: float) -> None:
        """Turn by a drag of (dx, dy) pixels."""
        self.yaw -= dx * LOOK_SPEED
        self.pitch = float(np.clip(self.pitch - dy * LOOK_SPEED, -1.55, 1.55))  # short of straight up: yaw would flip
        yaw = to_matrix3(from_axis_angle(np.array([0.0, 1.0, 0.0]), self.yaw))
        pitch = to_matrix3(from_axis_angle(np.array([1.0, 0.0, 0.0]), self.pitch))
        self.camera.world_from_camera[:3, :3] = yaw @ pitch

    def move(self, right: float, up: float, forward: float, seconds: float) -> None:
        axes = self.camera.world_from_camera[:3, :3]
        step = axes @ np.array([right, 0.0, -forward]) + np.array([0.0, up, 0.0])
        self.camera.world_from_camera[:3, 3] += step * self.speed * seconds


class Player:
    """Drives a runtime in a moderngl-window window."""

    def __init__(self, window: Any, runtime: Runtime) -> None:
        self.window = window
        self.runtime = runtime
        self.time = 0.0
        self.paused = False
        low, high = runtime.bounds()
        self.scale = float(np.linalg.norm(high - low)) / 3 if np.isfinite(high - low).all() else 1.0
        self.free = self._first_camera()
        window.key_event_func = self.on_key
        window.mouse_drag_event_func = lambda x, y, dx, dy: self.free.look(dx, dy)
        window.mouse_scroll_event_func = self.on_scroll

    def _first_camera(self) -> FreeCamera:
        width, height = self.window.buffer_size
        return FreeCamera(self.runtime.default_camera(width / max(height, 1)), self.scale)

    def on_scroll(self, _dx: float, dy: float) -> None:
        self.free.speed *= 1.2**dy

    def on_key(self, key: Any, action: Any, _modifiers: Any) -> None:
        keys = self.window.keys
        if action != keys.ACTION_PRESS:
            return
        if key == keys.SPACE:
            self.paused = not self.paused
        elif key == keys.R:
            self.time = 0.0
        elif key == keys.HOME:
            self.free = self._first_camera()

    def frame(self, seconds: float) -> None:
        """Advance by `seconds` and show the picture."""
        keys, held = self.window.keys, self.window.is_key_pressed
        self.free.move(held(keys.D) - held(keys.A), held(keys.E) - held(keys.Q), held(keys.W) - held(keys.S), seconds)
        if not self.paused:
            self.time += seconds
        self.runtime.update(self.time)
        width, height = self.window.buffer_size
        if width < 1 or height < 1:
            return
        frame = self.runtime.render(View(self.free.camera, width, height, seconds=seconds))
        self.runtime.device.present(frame.color, width, height)


def play(open_scene: Any, *, size: tuple[int, int] = (1280, 720), title: str = "Lucarna", frames: int = 0) -> int:
    """Open a window, call `open_scene(runtime)`, and show it until the window closes (or after `frames` frames).

    Returns the number of frames shown. Raises DeviceError where no window can be opened.
    """
    from moderngl_window import get_local_window_cls  # the window library is only needed here

    try:
        window = get_local_window_cls("pyglet")(
            title=title, size=size, gl_version=(4, 5), vsync=True, resizable=True, samples=0, cursor=True
        )
    except Exception as error:  # pyglet raises its own unrelated kinds for a missing display, driver or GL version
        raise DeviceError(
            f"cannot open a window: {error}", hint="it needs a display and OpenGL 4.5; see `lucarna doctor`"
        ) from error
    device = open_device("gl", attach=True)
    runtime = Runtime(device, profile=False, pixels=MANY_PICTURES)
    runtime.sleepy = True
    shown = 0
    try:
        open_scene(runtime)
        player = Player(window, runtime)
        last = time.perf_counter()
        while not window.is_closing:
            now = time.perf_counter()
            player.frame(min(now - last, 0.1))  # a long stall must not throw the camera away
            last = now
            window.swap_buffers()
            shown += 1
            if frames and shown >= frames:
                break
    finally:
        runtime.close()
        device.release()
        window.destroy()
    return shown
