"""The picture of the texture viewer: fitted, or zoomed to the pointer and dragged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from imgui_bundle import imgui

from editor import theme

LEAST, MOST = 0.02, 128.0
#: from this zoom on texels are squares, and the one under the pointer is framed
MAGNIFIED = 3.0
STEP = 1.25


@dataclass(frozen=True, slots=True)
class Placed:
    """In imgui units of the screen: the place `origin`, `size`, and the picture `low` to `high` in it, `scale` a texel.
    `where`: the texel under the pointer."""

    origin: tuple[float, float]
    size: tuple[float, float]
    low: tuple[float, float]
    high: tuple[float, float]
    scale: float
    where: tuple[int, int] | None


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

    def place(self, width: int, height: int, room: tuple[float, float]) -> Placed:
        """Where a picture of that size stands in `room` imgui units from the cursor on. The wheel zooms, a drag moves,
        a double click fits."""
        origin = imgui.get_cursor_screen_pos()
        size = (max(room[0], 1.0), max(room[1], 1.0))
        imgui.invisible_button(
            "##canvas", size, imgui.ButtonFlags_.mouse_button_left | imgui.ButtonFlags_.mouse_button_middle
        )
        hovered, io = imgui.is_item_hovered(), imgui.get_io()
        scale = self.zoom or min(size[0] / width, size[1] / height)
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
        where = None
        if hovered:
            x, y = ((io.mouse_pos[i] - low[i]) / scale for i in (0, 1))
            if 0 <= x < width and 0 <= y < height:
                where = (int(x), int(y))
        return Placed((origin.x, origin.y), size, low, (low[0] + width * scale, low[1] + height * scale), scale, where)


def paint(placed: Placed, native: int, marked: tuple[int, int] | None, *, magnified: bool) -> None:
    """Draw the picture, and frames about the texel that is marked and the one under the pointer. `magnified`: the
    texture is what the whole place shows (see texture_view.magnified), else the picture."""
    end = (placed.origin[0] + placed.size[0], placed.origin[1] + placed.size[1])
    lines = imgui.get_window_draw_list()
    lines.push_clip_rect(placed.origin, end, True)
    if native:
        ends = (placed.origin, end) if magnified else (placed.low, placed.high)
        lines.add_image(imgui.ImTextureRef(native), *ends)
    if marked is not None:
        _frame(lines, placed, marked, max(placed.scale, 6.0), theme.ERROR, 2.0)
    if placed.where is not None and placed.scale >= MAGNIFIED:
        _frame(lines, placed, placed.where, placed.scale, theme.ACCENT, 1.0)
    lines.pop_clip_rect()


def _frame(lines: Any, placed: Placed, texel: tuple[int, int], size: float, color: theme.Rgba, thick: float) -> None:
    a, b = placed.low[0] + texel[0] * placed.scale, placed.low[1] + texel[1] * placed.scale
    lines.add_rect((a, b), (a + size, b + size), theme.u32(color), 0.0, thick)
