"""Material preview: a material on a shape or the user's own mesh, in the scene's light, by the scene's own renderer."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.flowing import button_width, flow_field
from editor.panels.base import ASSET, Panel
from editor.preview import BACKDROPS, FILE, LIGHTS, MESH, SELECTED, Preview
from editor.requests import ChooseFile
from editor.session import shader_root
from editor.ui import Ui
from editor.widgets import em, empty_state, fitted_text, flow, icon_button, pretty, text, tooltip
from engine.assets.preview_shapes import SHAPES

WHEEL_STEP = 0.88
LABELS = {"ball": "Shader ball", SELECTED: "Selected object", "scene": "Scene's light", "studio": "Studio"}
GESTURES = "Drag: orbit\nMiddle drag: pan\nRight drag, wheel: zoom\nShift + right drag: turn the light"


class MaterialPreviewPanel(Panel):
    title: ClassVar[str] = "Material preview"
    icon: ClassVar[str] = icons.MATERIAL
    dock: ClassVar[str] = "BottomRight"

    def __init__(self) -> None:
        self.motion = ""
        self._button = 0

    def draw(self, ui: Ui) -> None:
        session, preview = ui.session, ui.session.preview
        preview.load(session)
        if session.document is None or preview.subject(session) < 0:
            empty_state(icons.MATERIAL, "No material to show", "Select something that has one")
            return
        self._bar(ui, preview)
        self._picture(ui, preview)
        if not self.motion and not imgui.is_any_item_active():
            preview.remember(session)

    # --- the bar ---

    def _bar(self, ui: Ui, preview: Preview) -> None:
        session, setup = ui.session, preview.setup
        assert session.document is not None
        pinned = preview.pinned >= 0
        if icon_button(
            f"{icons.PIN}###pin", "Stay with this material, or follow the selection",
            active=pinned,
        ):  # fmt: skip
            preview.pinned = -1 if pinned else preview.subject(session)
        imgui.same_line(0, em(0.2))
        self._materials(ui, preview)
        flow_field(8.5, gap=0.3)
        if imgui.begin_combo("##shape", self._shape_label(preview)):
            for name in SHAPES:
                if imgui.selectable(LABELS.get(name, pretty(name)), setup.shape == name)[0]:
                    setup.shape = name
            imgui.separator()
            if imgui.selectable(LABELS[SELECTED], setup.shape == SELECTED)[0]:
                setup.shape = SELECTED
            for name in preview.mesh_names(session):
                chosen = setup.shape == MESH and setup.mesh == name
                if imgui.selectable(f"{icons.MESH}  {name}##mesh-{name}", chosen)[0]:
                    setup.shape, setup.mesh = MESH, name
            imgui.separator()
            if imgui.selectable(f"{icons.FOLDER_OPEN}  A file…", setup.shape == FILE)[0]:
                session.ui.choose = ChooseFile(
                    "Choose a model",
                    (".lmesh", ".scene.json", *session.host.source_extensions()),
                    asset_folder(ui),
                    lambda path: preview.take(session, path),
                )
            tooltip("Or drop a model from Assets on the picture")
            imgui.end_combo()
        tooltip("What the material is put on")
        flow(button_width(icons.EXPOSURE), 0.3)
        if icon_button(f"{icons.EXPOSURE}###light", "Light and background"):
            imgui.open_popup("light")
        self._light(preview)
        flow(button_width(icons.RESET), 0.1)
        if icon_button(f"{icons.RESET}###again", "Frame and light it as at first (double click)"):
            preview.look_again()
        imgui.same_line(0, em(0.3))
        text(icons.INFO, theme.FAINT)
        tooltip(GESTURES)

    def _materials(self, ui: Ui, preview: Preview) -> None:
        session = ui.session
        assert session.document is not None
        records = session.document.runtime.residency.materials.records
        shown = preview.subject(session)
        room = imgui.get_content_region_avail().x
        imgui.set_next_item_width(max(room - em(15.8), min(room, em(7))))
        if imgui.begin_combo("##material", records[shown].asset.name or f"material {shown}"):
            for index, record in enumerate(records):
                name = record.asset.name or f"material {index}"
                if imgui.selectable(f"{name}##{index}", index == shown)[0]:
                    preview.pinned = index
            imgui.end_combo()
        tooltip(records[shown].path or "This material has no file")

    @staticmethod
    def _shape_label(preview: Preview) -> str:
        setup = preview.setup
        if setup.shape == MESH:
            return setup.mesh
        return Path(setup.mesh).name if setup.shape == FILE else LABELS.get(setup.shape, pretty(setup.shape))

    @staticmethod
    def _light(preview: Preview) -> None:
        setup = preview.setup
        if not imgui.begin_popup("light"):
            return
        for name in LIGHTS:
            if imgui.radio_button(LABELS[name], setup.light == name):
                setup.light = name
        imgui.set_next_item_width(em(11))
        changed, turned = imgui.slider_float("##turn", setup.rotation, -180.0, 180.0, "turned %.0f°")
        if changed:
            setup.rotation = float(turned)
        imgui.separator()
        text("Background", theme.DIM)
        for name in BACKDROPS:
            if imgui.radio_button(pretty(name), setup.backdrop == name):
                setup.backdrop = name
        imgui.end_popup()

    # --- the picture ---

    def _picture(self, ui: Ui, preview: Preview) -> None:
        session = ui.session
        avail = imgui.get_content_region_avail()
        width, height = max(avail.x, em(2)), max(avail.y, em(2))
        frame = preview.update(session, round(width * ui.pixel_scale), round(height * ui.pixel_scale))
        origin = imgui.get_cursor_screen_pos()
        imgui.invisible_button(
            "##preview", (width, height),
            imgui.ButtonFlags_.mouse_button_left | imgui.ButtonFlags_.mouse_button_right
            | imgui.ButtonFlags_.mouse_button_middle,
        )  # fmt: skip
        hovered = bool(imgui.is_item_hovered())
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        self._take_drop(ui, preview)
        lines = imgui.get_window_draw_list()
        end = (origin.x + width, origin.y + height)
        if frame is not None and frame.color.native:
            lines.add_image(imgui.ImTextureRef(frame.color.native), (origin.x, origin.y), end, (0, 0), (1, 1))
        else:
            lines.add_rect_filled((origin.x, origin.y), end, theme.u32(theme.FRAME))
        self._words(ui, preview, origin.x + em(0.5), origin.y + em(0.4))
        self._gestures(preview, hovered, height)

    @staticmethod
    def _words(ui: Ui, preview: Preview, x: float, y: float) -> None:
        """Over the picture: what is wrong with it."""
        problems = ui.session.shaders.badge
        line = preview.error or problems
        imgui.set_cursor_screen_pos((x, y))
        if line or preview.note:  # the picture may be of any colour
            wide, high = imgui.get_content_region_avail().x, imgui.get_text_line_height()
            low, pad = (x - em(0.3), y - em(0.2)), theme.u32(theme.FRAME)
            imgui.get_window_draw_list().add_rect_filled(low, (x + wide, y + high + em(0.2)), pad, em(0.2))
        if line:
            fitted_text(f"{icons.ERROR}  {line}", theme.ERROR)
        elif preview.note:
            fitted_text(preview.note, theme.WARNING)

    @staticmethod
    def _take_drop(ui: Ui, preview: Preview) -> None:
        """A file dragged from the assets panel: a material to show, or something to put it on."""
        if imgui.begin_drag_drop_target():
            dropped = imgui.accept_drag_drop_payload_py_id(ASSET)
            path = ui.session.ui.dragged
            if dropped is not None and path is not None:
                preview.take(ui.session, path)
            imgui.end_drag_drop_target()

    def _gestures(self, preview: Preview, hovered: bool, height: float) -> None:
        io = imgui.get_io()
        if hovered and not self.motion:
            for button in range(3):
                if imgui.is_mouse_clicked(button):
                    self.motion, self._button = _motion(button, io.key_shift, io.key_alt), button
                    imgui.set_window_focus()
            if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
                preview.look_again()
        if self.motion and not imgui.is_mouse_down(self._button):
            self.motion = ""
        dx, dy = io.mouse_delta.x, io.mouse_delta.y
        if self.motion and (dx or dy):
            if self.motion == "orbit":
                preview.orbit(dx, dy)
            elif self.motion == "pan":
                preview.pan(dx, dy, height)
            elif self.motion == "zoom":
                preview.come_nearer(2.0 ** (-(dx - dy) / 100.0))
            else:
                preview.turn_light(dx)
        if hovered and io.mouse_wheel:
            preview.come_nearer(WHEEL_STEP**io.mouse_wheel)


def asset_folder(ui: Ui) -> Path:
    """Where the project or the opened file lies."""
    document = ui.session.document
    return shader_root(document) if document is not None else Path()


def _motion(button: int, shift: bool, alt: bool) -> str:
    """What a drag with a button does."""
    if button == 1:
        return "light" if shift else "zoom"
    if button == 2:
        return "pan" if not alt else "zoom"
    return "pan" if shift else "orbit"


PANEL = MaterialPreviewPanel
