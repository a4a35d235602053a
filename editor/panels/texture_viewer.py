"""Texture viewer: any target of the last frame, any texture of a material: channels, mips, exposure, pixel values."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from editor import icons, theme
from editor.panels.base import Panel
from editor.texture_view import CHANNELS, as_float, overwritten, picture, value_range
from editor.ui import Ui
from editor.widgets import em, empty_state, fitted, icon_button, mono, text, tooltip
from engine.core.errors import LucarnaError
from engine.framegraph.dump import extent
from engine.framegraph.resources import human_bytes, texture_bytes
from engine.gpu.types import TextureDesc

#: screen pixels a texel when one is to be shown
PIXEL_ZOOM = 16.0


@dataclass(frozen=True, slots=True)
class Source:
    """Something to look at. `kind`: target (of the frame graph, by name) or material (id and slot)."""

    kind: str
    name: str
    material: int = -1
    label: str = ""
    note: str = ""
    lost: bool = False


class TextureViewerPanel(Panel):
    title: ClassVar[str] = "Textures"
    icon: ClassVar[str] = icons.TEXTURE
    dock: ClassVar[str] = "MainDockSpace"

    def __init__(self) -> None:
        self.source: Source | None = None
        self.level = 0
        self.layer = 0
        self.channels = "rgb"
        self.stops = 0.0
        self.low, self.high = 0.0, 1.0
        self.zoom = 0.0  # 0 fits the panel
        self.values: NDArray[np.float32] | None = None
        self.problem = ""
        self._desc: Any = None
        self._linear = False
        self._read_key: object = None
        self._shown_key: object = None
        self._texture: Any = None
        self._owner: object = None
        #: the texel that was asked for: x, y of the level; None when another source was chosen
        self.marked: tuple[int, int] | None = None
        self._note = ""
        self._scroll = False

    def draw(self, ui: Ui) -> None:
        session = ui.session
        if session.document is not self._owner:
            self._owner, self.source, self.values = session.document, None, None
            self._read_key = self._shown_key = None
        sources = [] if session.null_pictures else list_sources(session)
        if not sources:
            empty_state(icons.TEXTURE, "No textures yet", "They are there once a scene is drawn")
            return
        if self.source not in sources:
            targets = [s for s in sources if s.kind == "target" and not s.lost]
            self.source = targets[-1] if targets else sources[0]
            self._reset()
        self._go(ui, sources)
        self._bar(ui, sources)
        self._read(ui)
        if self.problem or self.values is None:
            empty_state(icons.WARNING, self.problem or "Nothing to show")
            return
        self._picture(ui)

    def _go(self, ui: Ui, sources: list[Source]) -> None:
        """Take over the texel that someone wants to be shown."""
        wanted = ui.session.ui.show_pixel
        if wanted is None:
            return
        ui.session.ui.show_pixel = None
        found = next((s for s in sources if s.kind == "target" and s.name == wanted.resource), None)
        if found is None:
            return
        self.source = found
        self._reset()
        self.level, self.layer, self.marked, self._note = wanted.level, wanted.layer, (wanted.x, wanted.y), wanted.note
        self.zoom, self._scroll = PIXEL_ZOOM, True

    def _bar(self, ui: Ui, sources: list[Source]) -> None:
        assert self.source is not None
        imgui.set_next_item_width(em(16))
        if imgui.begin_combo("##source", self.source.label, imgui.ComboFlags_.height_large):
            kind = ""
            for source in sources:
                if source.kind != kind:
                    kind = source.kind
                    imgui.separator_text("Targets of the frame" if kind == "target" else "Materials")
                if imgui.selectable(f"{source.label}##{source.kind}{source.material}", source == self.source)[0]:
                    self.source = source
                    self._reset()
                tooltip(source.note)
            imgui.end_combo()
        for name in CHANNELS:
            imgui.same_line(0, em(0.5 if name == "rgb" else 0.1))
            if icon_button(f"{name.upper()}##channel", f"Show {name.upper()}", active=name == self.channels):
                self.channels = name
        imgui.same_line(0, em(0.6))
        imgui.set_next_item_width(em(5.5))
        _changed, self.stops = imgui.drag_float("##stops", self.stops, 0.05, -20.0, 20.0, "%+.1f EV")
        tooltip("Exposure of this view")
        imgui.same_line(0, em(0.4))
        imgui.set_next_item_width(em(9))
        _changed, (self.low, self.high) = imgui.drag_float2("##range", [self.low, self.high], 0.005, 0, 0, "%.3g")
        tooltip("What is shown as black and as white")
        imgui.same_line(0, em(0.2))
        if icon_button(f"{icons.SCALE}##fit-range", "Black and white at the smallest and largest value"):
            self.low, self.high = value_range(self.values) if self.values is not None else (0.0, 1.0)
        desc = self._desc
        if desc is not None and desc.mips > 1:
            imgui.same_line(0, em(0.6))
            imgui.set_next_item_width(em(5))
            _changed, self.level = imgui.slider_int("##mip", min(self.level, desc.mips - 1), 0, desc.mips - 1, "mip %d")
        layers = 1 if desc is None else 6 if desc.kind == "cube" else max(desc.layers, desc.depth)
        if self.source.kind == "target" and layers > 1:
            imgui.same_line(0, em(0.4))
            imgui.set_next_item_width(em(5))
            _changed, self.layer = imgui.slider_int("##layer", min(self.layer, layers - 1), 0, layers - 1, "layer %d")

    def _read(self, ui: Ui) -> None:
        """Fetch the level's numbers when something else is to be shown, or a new frame changed a target."""
        session, source = ui.session, self.source
        assert source is not None
        key = (source, self.level, self.layer, session.image.renders if source.kind == "target" else 0)
        if key == self._read_key:
            return
        self._read_key, self._shown_key, self.problem = key, None, ""
        try:
            with session.device_frame():
                texture, layer = find_texture(session, source)
                if source.kind == "target":
                    layer = self.layer
                self._desc = texture.desc
                self.level = min(self.level, texture.desc.mips - 1)
                pixels = np.asarray(texture.read(level=self.level, layer=layer))
                self._linear = pixels.dtype.kind == "f" and not texture.desc.format.startswith("d")
                self.values = as_float(pixels)
        except (LucarnaError, KeyError, ValueError, AssertionError) as error:
            self.values, self.problem = None, f"Cannot be read: {error}"

    def _picture(self, ui: Ui) -> None:
        assert self.values is not None
        self._upload(ui)
        height, width = self.values.shape[:2]
        room = imgui.get_content_region_avail()
        footer = imgui.get_frame_height() + em(0.3)
        fit = min(room.x / width, max(room.y - footer, 1.0) / height)
        zoom = self.zoom or fit
        if imgui.begin_child("pixels", (0, -footer), 0, imgui.WindowFlags_.horizontal_scrollbar):
            space = imgui.get_content_region_avail()
            at = imgui.get_cursor_pos()
            imgui.set_cursor_pos((at.x + max(0.0, 0.5 * (space.x - width * zoom)), at.y))
            start = imgui.get_cursor_screen_pos()
            if self._texture is not None and self._texture.native:
                imgui.image(imgui.ImTextureRef(self._texture.native), (width * zoom, height * zoom))
            else:
                imgui.dummy((width * zoom, height * zoom))
            if self.marked is not None:
                a, b = start.x + self.marked[0] * zoom, start.y + self.marked[1] * zoom
                size = max(zoom, 6.0)
                imgui.get_window_draw_list().add_rect((a, b), (a + size, b + size), theme.u32(theme.ERROR), 0.0, 2.0)
                if self._scroll:
                    self._scroll = False
                    imgui.set_scroll_x(max(0.0, (self.marked[0] + 0.5) * zoom - 0.5 * space.x))
                    imgui.set_scroll_y(max(0.0, (self.marked[1] + 0.5) * zoom - 0.5 * space.y))
            io = imgui.get_io()
            where = None
            if imgui.is_item_hovered():
                x, y = int((io.mouse_pos.x - start.x) / zoom), int((io.mouse_pos.y - start.y) / zoom)
                if 0 <= x < width and 0 <= y < height:
                    where = (x, y)
                    if zoom >= 4.0:
                        a, b = start.x + x * zoom, start.y + y * zoom
                        imgui.get_window_draw_list().add_rect((a, b), (a + zoom, b + zoom), theme.u32(theme.ACCENT))
                if io.key_ctrl and io.mouse_wheel:
                    self.zoom = min(max(zoom * 1.25**io.mouse_wheel, 0.02), 64.0)
        imgui.end_child()
        self._footer(ui, where, zoom)

    def _footer(self, ui: Ui, where: tuple[int, int] | None, zoom: float) -> None:
        desc = self._desc
        assert desc is not None and self.values is not None  # noqa: PT018  (both are set together by _read)
        with mono(ui):
            where = where or self._inside()
            if where is not None:
                pixel = self.values[where[1], where[0]]
                numbers = "  ".join(f"{n} {v:.5g}" for n, v in zip("RGBA", pixel, strict=False))
                text(f"{where[0]:5d} {where[1]:5d}   {numbers}", theme.TEXT)
            else:
                text(f"{desc.format}  {extent(desc)}  {human_bytes(texture_bytes(desc))}", theme.DIM)
        if self._note:
            imgui.same_line(0, em(1))
            text(fitted(self._note, imgui.get_window_width() - em(10) - imgui.get_cursor_pos_x()), theme.WARNING)
            tooltip(self._note)
        imgui.same_line(imgui.get_window_width() - em(8))
        if imgui.small_button("Fit"):
            self.zoom = 0.0
        imgui.same_line(0, em(0.3))
        if imgui.small_button("1:1"):
            self.zoom = 1.0 / max(ui.pixel_scale, 1e-3)
        imgui.same_line(0, em(0.5))
        text(f"{zoom * 100:.0f} %", theme.FAINT)
        tooltip("Ctrl + wheel over the picture zooms")

    def _inside(self) -> tuple[int, int] | None:
        """The marked texel, where the level has it."""
        if self.marked is None or self.values is None:
            return None
        height, width = self.values.shape[:2]
        return self.marked if self.marked[0] < width and self.marked[1] < height else None

    def _upload(self, ui: Ui) -> None:
        """Bring what is to be seen into a texture of our own."""
        assert self.values is not None
        encode, normal = self._linear, self._desc.format in {"bc5", "rg8"}
        key = (self._read_key, self.channels, self.stops, self.low, self.high)
        if key == self._shown_key:
            return
        self._shown_key = key
        pixels = picture(self.values, self.channels, self.stops, self.low, self.high, encode=encode, normal=normal)
        height, width = pixels.shape[:2]
        device = ui.session.device
        with ui.session.device_frame():
            if self._texture is None or (self._texture.desc.width, self._texture.desc.height) != (width, height):
                if self._texture is not None:
                    self._texture.release()
                self._texture = device.texture(TextureDesc("rgba8", width, height, label="texture viewer"))
            self._texture.write(pixels)

    def _reset(self) -> None:
        self.level = self.layer = 0
        self.stops, self.low, self.high, self.zoom = 0.0, 0.0, 1.0, 0.0
        self.marked, self._note, self._scroll = None, "", False


def list_sources(session: Any) -> list[Source]:
    """Everything that can be looked at now: the frame's targets, then the materials' textures."""
    found: list[Source] = []
    frame = session.image.frame
    plan = getattr(getattr(frame, "graph", None), "plan", None)
    if plan is not None:
        for name, desc in plan.descs.items():
            if desc.kind in {"2d", "2d-array", "cube"} and getattr(desc, "samples", 1) == 1:
                lost = overwritten(plan, name)
                note = "Its memory was used again later in the frame: what shows is that" if lost else desc.format
                found.append(Source("target", name, -1, f"{name} (overwritten)" if lost else name, note, lost))
    document = session.document
    if document is None:
        return found
    materials = document.runtime.scene.instances.material
    for material in dict.fromkeys(int(m) for m in materials if m >= 0):
        record = document.runtime.residency.material(material)
        for slot in record.effect.textures:
            ref = record.asset.textures.get(slot.name)
            if ref is not None and ref.path:
                label = f"{record.asset.name or 'material'}: {slot.name.removesuffix('_map').replace('_', ' ')}"
                found.append(Source("material", slot.name, material, label, Path(ref.path).name))
    return found


def find_texture(session: Any, source: Source) -> tuple[Any, int]:
    """(texture, layer) of a source."""
    if source.kind == "target":
        return session.image.frame.graph.texture(source.name), 0
    texture, layer = session.document.runtime.residency.materials.slot_texture(source.material, source.name)
    return texture, int(layer)


PANEL = TextureViewerPanel
