"""The picture of the texture viewer: fitted, or zoomed to the pointer and dragged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from imgui_bundle import imgui

from editor import theme

LEAST, MOST = 0.02, 128.0
#: from this zoom on, the texel under the pointer is framed
FRAMED = 4.0
STEP = 1.25


@dataclass(slots=True)
class Canvas:
    """`zoom`: imgui units a texel, 0 fits the picture in. `center`: texel in the middle of the panel."""

    zoom: float = 0.0
    center: tuple[float, float] = (0.0, 0.0)
    #: as last drawn
    scale: float = 1.0

    def fit(self) -> None:
        self.zoom = 0.0

    def show(self, x: float, y: float, zoom: float) -> None:
        """That texel in the middle, so large."""
        self.zoom, self.center = zoom, (x + 0.5, y + 0.5)

    def at(self, zoom: float, width: int, height: int) -> None:
        """Another zoom about what is in the middle now."""
        if not self.zoom:
            self.center = (0.5 * width, 0.5 * height)
        self.zoom = min(max(zoom, LEAST), MOST)

    def draw(
        self, native: int, width: int, height: int, room: tuple[float, float], marked: tuple[int, int] | None
    ) -> tuple[int, int] | None:
        """Over `room` imgui units; returns the texel under the pointer. The wheel zooms, a drag moves, a double click
        fits."""
        origin = imgui.get_cursor_screen_pos()
        size = (max(room[0], 1.0), max(room[1], 1.0))
        imgui.invisible_button(
            "##canvas", size, imgui.ButtonFlags_.mouse_button_left | imgui.ButtonFlags_.mouse_button_middle
        )
        hovered, io = imgui.is_item_hovered(), imgui.get_io()
        fit = min(size[0] / width, size[1] / height)
        scale = self.zoom or fit
        if not self.zoom:
            self.center = (0.5 * width, 0.5 * height)
        if imgui.is_item_active() and (io.mouse_delta.x or io.mouse_delta.y):
            self.zoom = scale
            self.center = (self.center[0] - io.mouse_delta.x / scale, self.center[1] - io.mouse_delta.y / scale)
        if hovered and imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            self.fit()
        middle = (origin.x + 0.5 * size[0], origin.y + 0.5 * size[1])
        if hovered and io.mouse_wheel:
            pointed = tuple((io.mouse_pos[i] - middle[i]) / scale + self.center[i] for i in (0, 1))
            self.zoom = scale = min(max(scale * STEP**io.mouse_wheel, LEAST), MOST)
            x, y = (pointed[i] - (io.mouse_pos[i] - middle[i]) / scale for i in (0, 1))
            self.center = (x, y)
        self.scale = scale
        low = (middle[0] - self.center[0] * scale, middle[1] - self.center[1] * scale)
        high = (low[0] + width * scale, low[1] + height * scale)
        lines = imgui.get_window_draw_list()
        lines.push_clip_rect(origin, (origin.x + size[0], origin.y + size[1]), True)
        if native:
            lines.add_image(imgui.ImTextureRef(native), low, high)
        where = None
        if hovered:
            x, y = ((io.mouse_pos[i] - low[i]) / scale for i in (0, 1))
            if 0 <= x < width and 0 <= y < height:
                where = (int(x), int(y))
        if marked is not None:
            _frame(lines, low, marked, max(scale, 6.0), scale, theme.ERROR, 2.0)
        if where is not None and scale >= FRAMED:
            _frame(lines, low, where, scale, scale, theme.ACCENT, 1.0)
        lines.pop_clip_rect()
        return where


def _frame(
    lines: Any, low: tuple[float, float], texel: tuple[int, int], size: float, scale: float, color: theme.Rgba,
    thick: float,
) -> None:  # fmt: skip
    a, b = low[0] + texel[0] * scale, low[1] + texel[1] * scale
    lines.add_rect((a, b), (a + size, b + size), theme.u32(color), 0.0, thick)
