"""Texture viewer: any target of the last frame, any texture of a material, the renderer's tables, any image file:
channels, mips, faces, layers, exposure, range, marks for what is no number, values under the pointer."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from editor import icons, theme
from editor.flowing import button_width, field_width, flow_field, flow_icon
from editor.panels.base import ASSET, Panel
from editor.panels.texture_canvas import MAGNIFIED, Canvas, Placed, paint
from editor.picture_files import PictureFiles
from editor.texture_sources import ALL_FACES, FACES, KINDS, Level, Source, list_sources, read
from editor.texture_view import CHANNELS, depth_range, magnified, normals, not_numbers, picture, value_range
from editor.thumbnail_maker import ENVIRONMENTS, TEXTURES, sort_of
from editor.ui import Ui
from editor.widgets import em, empty_state, fitted, flow, icon_button, mono, text, tooltip
from engine.core.errors import LucarnaError
from engine.framegraph.dump import extent
from engine.framegraph.resources import human_bytes
from engine.gpu.types import TextureDesc

#: screen pixels a texel when one is to be shown
PIXEL_ZOOM = 16.0
DOCS = {
    "rgb": "Show colours", "r": "Show R", "g": "Show G", "b": "Show B", "a": "Show A",
    "luma": "Show luminance (Rec. 709)", "normal": "Show normals: -1 to 1 as dark to bright, z made of x and y",
}  # fmt: skip
NAMES = {"rgb": "RGB", "luma": "Y", "normal": "N"}


class TextureViewerPanel(Panel):
    title: ClassVar[str] = "Textures"
    icon: ClassVar[str] = icons.TEXTURE
    dock: ClassVar[str] = "MainDockSpace"

    def __init__(self) -> None:
        self.source: Source | None = None
        self.file: Path | None = None
        self.files = PictureFiles()
        self.level = 0
        self.layer = 0
        self.channels = "rgb"
        self.stops = 0.0
        self.low, self.high = 0.0, 1.0
        self.canvas = Canvas()
        self.image: Level | None = None
        self.values: NDArray[np.float32] | None = None
        self.problem = ""
        self.bad = (0, 0)
        self._read_key: object = None
        self._shown_key: object = None
        self._pixels_key: object = None
        self._pixels: NDArray[np.uint8] | None = None
        self._texture: Any = None
        self._owner: object = None
        #: the texel that was asked for: x, y of the level; None when another source was chosen
        self.marked: tuple[int, int] | None = None
        self._note = ""

    def draw(self, ui: Ui) -> None:
        ui.keep_live()
        session = ui.session
        if session.document is not self._owner:
            self._owner, self.source, self.image, self.values = session.document, None, None, None
            self._read_key = self._shown_key = None
        if isinstance(session.ui.show_texture, Path):
            self.file = session.ui.show_texture
        sources = [] if session.null_pictures else list_sources(session, self.file)
        if not sources:
            empty_state(icons.TEXTURE, "No textures yet", "They are there once a scene is drawn")
            return
        if self.source not in sources:
            targets = [s for s in sources if s.kind == "target" and s.samples == 1]
            self._take(targets[-1] if targets else sources[0])
        self._go(ui, sources)
        self._bar(sources)
        self._read(ui)
        if self.problem:
            empty_state(icons.WARNING, self.problem)
        elif self.image is None:
            empty_state(icons.WAITING, "It is being read")
        else:
            self._picture(ui)
        self._drop(ui)

    def _go(self, ui: Ui, sources: list[Source]) -> None:
        """Take over what someone wants to be shown."""
        asked, ui.session.ui.show_texture = ui.session.ui.show_texture, ""
        if asked:
            found = next((s for s in sources if s.name == str(asked) and s.kind in ("target", "file")), None)
            if found is not None:
                self._take(found)
        wanted = ui.session.ui.show_pixel
        if wanted is None:
            return
        ui.session.ui.show_pixel = None
        found = next((s for s in sources if s.kind == "target" and s.name == wanted.resource), None)
        if found is None:
            return
        self._take(found)
        self.level, self.layer, self.marked, self._note = wanted.level, wanted.layer, (wanted.x, wanted.y), wanted.note
        self.canvas.show(wanted.x, wanted.y, PIXEL_ZOOM)

    def _drop(self, ui: Ui) -> None:
        """An image that is let go over the picture is shown."""
        if not imgui.begin_drag_drop_target():
            return
        dragged = ui.session.ui.dragged
        if imgui.accept_drag_drop_payload_py_id(ASSET) is not None and dragged is not None and shows(dragged):
            ui.session.ui.show_texture = dragged
        imgui.end_drag_drop_target()

    # --- above the picture ---

    def _bar(self, sources: list[Source]) -> None:
        assert self.source is not None
        field_width(16)
        if imgui.begin_combo("##source", self.source.label, imgui.ComboFlags_.height_large):
            kind = ""
            for source in sources:
                if source.kind != kind:
                    kind = source.kind
                    imgui.separator_text(KINDS[kind])
                if imgui.selectable(f"{source.label}##{source.kind}{source.material}", source == self.source)[0]:
                    self._take(source)
                tooltip(source.note)
            imgui.end_combo()
        tooltip(f"{self.source.label}\n{self.source.note}")
        for name in CHANNELS:
            label = NAMES.get(name, name.upper())
            if flow_icon(label, "channel", DOCS[name], gap=0.5 if name == "rgb" else 0.1, active=name == self.channels):
                self.channels = name
        flow_field(5.5, gap=0.6)
        _changed, self.stops = imgui.drag_float("##stops", self.stops, 0.05, -20.0, 20.0, "%+.1f EV")
        tooltip("Exposure of this view")
        flow_field(9)
        _changed, (self.low, self.high) = imgui.drag_float2("##range", [self.low, self.high], 0.005, 0, 0, "%.3g")
        tooltip("What is shown as black and as white")
        if flow_icon(icons.SCALE, "fit-range", "Black and white at the smallest and largest value", gap=0.2):
            self._fit_range()
        if flow_icon(icons.RESET, "no-range", "As it is: 0 EV, black at 0, white at 1"):
            self.stops, self.low, self.high = 0.0, 0.0, 1.0
        self._places()

    def _places(self) -> None:
        """Which mip, which face or layer."""
        image = self.image
        if image is None or self.source is None:
            return
        desc = image.desc
        if desc.mips > 1:
            flow_field(5.5, gap=0.6)
            _changed, self.level = imgui.slider_int("##mip", min(self.level, desc.mips - 1), 0, desc.mips - 1, "mip %d")
        if self.source.kind == "material" or image.layers == 1:
            return
        if desc.kind == "cube":
            flow_field(6)
            names = FACES if self.source.kind == "target" else (*FACES, "All faces")
            now = self.layer if 0 <= self.layer < 6 else 6
            changed, now = imgui.combo("##face", min(now, len(names) - 1), list(names))
            if changed:
                self.layer = now if now < 6 else ALL_FACES
            return
        flow_field(6)
        last = image.layers - 1
        word = "slice %d" if desc.kind == "3d" else "layer %d"
        _changed, self.layer = imgui.slider_int("##layer", min(max(self.layer, 0), last), 0, last, word)

    # --- reading ---

    def _read(self, ui: Ui) -> None:
        """Fetch the level's numbers when something else is to be shown, or a new frame changed a target."""
        session, source = ui.session, self.source
        assert source is not None
        live = session.image.renders if source.kind in ("target", "renderer") else 0
        key = (source, self.level, self.layer, live, _stamp(source))
        if key == self._read_key:
            return
        first = self.image is None
        try:
            found = read(session, source, self.level, self.layer, self.files)
        except (LucarnaError, KeyError, ValueError, AssertionError) as error:
            self._read_key, self.image, self.values, self.problem = key, None, None, f"Cannot be read: {error}"
            return
        if found is None:  # on its way: what was there stays
            if source.kind == "target":  # with the next picture
                ui.again_in(0.0)
            return
        self._read_key, self.problem = key, ""
        self._pixels_key = self._shown_key = None
        self.image, self.values = found, found.values
        self.level = min(self.level, found.desc.mips - 1)
        self.bad = not_numbers(found.values)
        if first and found.depth:
            self.low, self.high = depth_range(found.values)

    def _fit_range(self) -> None:
        if self.image is None:
            return
        self.low, self.high = (depth_range if self.image.depth else value_range)(self.image.values)

    # --- the picture ---

    def _picture(self, ui: Ui) -> None:
        assert self.values is not None
        height, width = self.values.shape[:2]
        room = imgui.get_content_region_avail()
        footer = self._footer_lines() * imgui.get_frame_height_with_spacing()
        placed = self.canvas.place(width, height, (room.x, room.y - footer))
        large = placed.scale * ui.pixel_scale >= MAGNIFIED
        self._upload(ui, placed, large)
        paint(placed, self._texture.native if self._texture is not None else 0, self.marked, magnified=large)
        where = placed.where
        if where is not None and imgui.is_mouse_clicked(imgui.MouseButton_.right):
            pixel = ", ".join(f"{float(v):.9g}" for v in self.values[where[1], where[0]])
            ui.session.ui.copy_text, ui.session.ui.notice = pixel, f"Copied {pixel}"
        self._footer(ui, where)

    def _footer_lines(self) -> int:
        return 1 if imgui.get_content_region_avail().x > em(34) and not self._note else 2

    def _footer(self, ui: Ui, where: tuple[int, int] | None) -> None:
        image = self.image
        assert image is not None
        where = where or self._inside()
        imgui.align_text_to_frame_padding()
        with mono(ui):
            if where is not None:
                shown = self.told(ui, where)
                text(fitted(shown, imgui.get_content_region_avail().x), theme.TEXT)
                tooltip(f"{shown}\nStored with the sRGB curve; the numbers are linear" if image.srgb else shown)
            else:
                about = f"{image.desc.format}  {extent(image.desc)}  {human_bytes(image.bytes)}"
                text(fitted(about, imgui.get_content_region_avail().x), theme.DIM)
        nan, inf = self.bad
        if nan or inf:
            flow(em(9), 1.0)
            text(f"{icons.ERROR} {nan:,} NaN, {inf:,} infinite", theme.ERROR)
            tooltip("Texels of this image: magenta NaN, yellow infinite")
        if self._note:
            flow(em(12), 1.0)
            text(fitted(self._note, imgui.get_content_region_avail().x), theme.WARNING)
            tooltip(self._note)
        zoom = f"{self.canvas.scale * max(ui.pixel_scale, 1e-3) * 100:.0f} %"
        wide = button_width("Fit") + button_width("1:1") + imgui.calc_text_size(zoom).x + em(1.4)
        flow(wide, 1.0)
        imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + max(imgui.get_content_region_avail().x - wide, 0.0))
        assert self.values is not None
        height, width = self.values.shape[:2]
        if icon_button("Fit##fit", "The whole picture (double click)"):
            self.canvas.fit()
        imgui.same_line(0, em(0.2))
        if icon_button("1:1##whole", "A texel a pixel of the screen"):
            self.canvas.at(1.0 / max(ui.pixel_scale, 1e-3), width, height)
        imgui.same_line(0, em(0.4))
        text(zoom, theme.DIM)
        tooltip("The wheel zooms to the pointer, a drag moves, a right click copies the value")

    def told(self, ui: Ui, where: tuple[int, int]) -> str:
        """Place and value of a texel, as numbers that the shaders see."""
        image = self.image
        assert image is not None
        pixel = image.values[where[1], where[0]]
        numbers = "  ".join(f"{n} {v:.5g}" for n, v in zip("RGBA", pixel, strict=False))
        parts = [f"{where[0]:5d} {where[1]:5d}", numbers]
        if self.channels == "normal" and len(pixel) >= 2:
            signed = bool((image.values[..., :2] < 0.0).any())
            x, y, z = normals(pixel.reshape(1, 1, -1), signed=signed)[0, 0]
            parts.append(f"n {x:+.3f} {y:+.3f} {z:+.3f}  |n| {float(np.sqrt(x * x + y * y + z * z)):.3f}")
        elif self.channels == "luma" and len(pixel) >= 3:
            parts.append(f"Y {float(pixel[:3] @ np.array((0.2126, 0.7152, 0.0722))):.5g}")
        if image.depth and self.source is not None and self.source.name.startswith("depth"):
            camera = ui.session.camera
            if not camera.orthographic:
                parts.append(f"{camera.znear / float(pixel[0]):.4g} m" if pixel[0] > 0.0 else "nothing there")
        return "   ".join(parts)

    def _inside(self) -> tuple[int, int] | None:
        """The marked texel, where the level has it."""
        if self.marked is None or self.values is None:
            return None
        height, width = self.values.shape[:2]
        return self.marked if self.marked[0] < width and self.marked[1] < height else None

    def _upload(self, ui: Ui, placed: Placed, large: bool) -> None:
        """Bring what is to be seen into a texture of our own: the picture, or the squares of `large` texels."""
        image = self.image
        assert image is not None
        key = (self._read_key, self.channels, self.stops, self.low, self.high)
        if key != self._pixels_key:
            self._pixels_key = key
            encode, normal = image.floating or image.srgb, image.desc.format in {"bc5", "rg8"}
            self._pixels = picture(
                image.values, self.channels, self.stops, self.low, self.high, encode=encode, normal=normal
            )
        assert self._pixels is not None
        shown = (key, (placed.origin, placed.size, placed.low, placed.scale) if large else None)
        if shown == self._shown_key:
            return
        self._shown_key = shown
        pixels = self._pixels
        if large:
            dots = ui.pixel_scale
            low = ((placed.low[0] - placed.origin[0]) * dots, (placed.low[1] - placed.origin[1]) * dots)
            size = (max(int(placed.size[0] * dots), 1), max(int(placed.size[1] * dots), 1))
            pixels = magnified(pixels, low, placed.scale * dots, size)
        height, width = pixels.shape[:2]
        device = ui.session.device
        with ui.session.device_frame():
            if self._texture is None or (self._texture.desc.width, self._texture.desc.height) != (width, height):
                if self._texture is not None:
                    self._texture.release()
                self._texture = device.texture(TextureDesc("rgba8", width, height, label="texture viewer"))
            self._texture.write(pixels)

    def _take(self, source: Source) -> None:
        """Look at another one, from the start."""
        self.source, self.image, self.values, self._read_key = source, None, None, None
        self.level, self.layer = 0, 0
        self.stops, self.low, self.high = 0.0, 0.0, 1.0
        self.marked, self._note, self.problem = None, "", ""
        self.canvas.fit()
        if source.name == "environment" and source.kind == "renderer":
            self.layer = ALL_FACES


def shows(path: Path) -> bool:
    """Whether the viewer can show that file."""
    return sort_of(path.name) in (TEXTURES, ENVIRONMENTS)


def _stamp(source: Source) -> int:
    """When a file was written last; 0 for anything else."""
    if source.kind != "file":
        return 0
    try:
        return Path(source.name).stat().st_mtime_ns
    except OSError:
        return -1


PANEL = TextureViewerPanel
