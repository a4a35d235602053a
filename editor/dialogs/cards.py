"""Cards: the welcome of a first start, the sheet of keys, what this program is."""

from __future__ import annotations

from pathlib import Path

from imgui_bundle import imgui

from editor import icons, theme
from editor.dialogs.modals import begin_card, center_next_window
from editor.keys import shown_shortcut
from editor.navigation import PRESETS, hints
from editor.preferences import THEMES
from editor.ui import Ui
from editor.widgets import bold, em, own_text, pretty, property_grid, property_text, text
from engine import __version__


def _hint_table(ui: Ui, name: str) -> None:
    if imgui.begin_table(name, 2, imgui.TableFlags_.sizing_fixed_fit):
        for gesture, what in hints(ui.session.preferences.keymap, ui.session.preferences.pointer):
            imgui.table_next_row()
            imgui.table_next_column()
            text(gesture, theme.ACCENT)
            imgui.table_next_column()
            imgui.text_unformatted(what)
        imgui.end_table()


def _keymap_choice(ui: Ui) -> None:
    preferences = ui.session.preferences
    for preset in PRESETS:
        if imgui.radio_button(pretty(preset), preferences.keymap == preset):
            ui.operations.run(f"help.keymap-{preset}", ui.session)
        imgui.same_line(0, em(1.0))
    trackpad = preferences.pointer == "trackpad"
    if imgui.checkbox("Trackpad", trackpad)[0]:
        ui.operations.run("help.pointer-mouse" if trackpad else "help.pointer-trackpad", ui.session)


def _size_choice(ui: Ui) -> None:
    for label, id in (("Smaller", "view.scale-down"), ("100 %", "view.scale-reset"), ("Larger", "view.scale-up")):
        if imgui.button(label, (em(5.5), 0)):
            ui.operations.run(id, ui.session)
        imgui.same_line()
    text(f"{ui.session.preferences.ui_scale * 100:.0f} %", theme.DIM)


def _theme_choice(ui: Ui) -> None:
    for name in THEMES:
        if imgui.radio_button(pretty(name.replace("-", " ")), ui.session.preferences.theme == name):
            ui.operations.run(f"view.theme-{name}", ui.session)
        imgui.same_line(0, em(1.0))
    imgui.new_line()


class WelcomeCard:
    """Three choices and a place to start, beside what is on the stage; closed by anything, shown once."""

    NAME = "###welcome"

    def draw(self, ui: Ui) -> None:
        session = ui.session
        if session.ui.welcome and not imgui.is_popup_open(self.NAME):
            imgui.open_popup(self.NAME)
        area = imgui.get_main_viewport()
        imgui.set_next_window_pos((area.pos.x + em(2), area.get_center().y), imgui.Cond_.always, (0.0, 0.5))
        imgui.set_next_window_size((em(26), 0), imgui.Cond_.always)
        imgui.push_style_color(imgui.Col_.modal_window_dim_bg, imgui.ImVec4(0.0, 0.0, 0.0, 0.2))
        shown = begin_card(self.NAME, modal=True)
        imgui.pop_style_color()
        if not shown:
            return
        imgui.push_font(ui.fonts.bold, theme.FONT_SIZE * 1.5)
        text(icons.APP, theme.ACCENT)
        imgui.same_line(0, em(0.5))
        imgui.text_unformatted("Lucarna")
        imgui.pop_font()
        text("Drop a model, a scene or a folder on the window, or open one.", theme.DIM)
        imgui.separator_text("Mouse and keys")
        _keymap_choice(ui)
        _hint_table(ui, "gestures")
        imgui.separator_text("Interface size")
        _size_choice(ui)
        imgui.separator_text("Colours")
        _theme_choice(ui)
        for recent in self._recent(ui):
            if imgui.selectable(f"{icons.FILE}  {recent.name}##{recent}", False)[0]:
                session.open(recent)
        imgui.spacing()
        imgui.separator()
        if imgui.button(f"{icons.FOLDER_OPEN}  Open…", (em(8), 0)):
            session.ui.welcome = False
            session.ui.open_dialog = True
        imgui.same_line()
        if imgui.button("Start", (em(8), 0)) or imgui.is_key_pressed(imgui.Key.escape):
            session.ui.welcome = False
        if not session.ui.welcome:
            session.preferences.welcome_seen = True
            session.remember()
            imgui.close_current_popup()
        imgui.end_popup()

    def _recent(self, ui: Ui) -> list[Path]:
        paths = [Path(p) for p in ui.session.preferences.recent[:4]]
        if paths:
            imgui.separator_text("Recent")
        return paths


class HelpCard:
    """All gestures and shortcuts of the keymap in use."""

    NAME = "Keys and mouse"

    def draw(self, ui: Ui) -> None:
        if ui.session.ui.help:
            ui.session.ui.help = False
            imgui.open_popup(self.NAME)
        center_next_window(44)
        if not begin_card(self.NAME, modal=False):
            return
        with bold(ui):
            imgui.text_unformatted(f"{self.NAME}: {pretty(ui.session.preferences.keymap)} keymap")
        _keymap_choice(ui)
        imgui.separator()
        _hint_table(ui, "gestures")
        imgui.separator()
        if imgui.begin_table("shortcuts", 4, imgui.TableFlags_.sizing_stretch_prop):
            rows = [o for o in ui.operations if ui.operations.keys_of(o)]
            half = -(-len(rows) // 2)
            for i in range(half):
                imgui.table_next_row()
                for operation in rows[i::half]:
                    imgui.table_next_column()
                    own_text("  ".join(map(shown_shortcut, ui.operations.keys_of(operation))), theme.ACCENT)
                    imgui.table_next_column()
                    imgui.text_unformatted(operation.label)
            imgui.end_table()
        imgui.end_popup()


class AboutCard:
    """Version, and the graphics device in use: the first thing to know when a picture is slow or wrong."""

    NAME = "About Lucarna"

    def draw(self, ui: Ui) -> None:
        if ui.session.ui.about:
            ui.session.ui.about = False
            imgui.open_popup(self.NAME)
        center_next_window(34)
        if not begin_card(self.NAME, modal=False):
            return
        with bold(ui):
            imgui.text_unformatted(f"{icons.APP}  Lucarna {__version__}")
        text("An editor around a real-time render engine", theme.DIM)
        imgui.spacing()
        with property_grid("about") as shown:
            if shown and ui.session.device is not None:
                caps = ui.session.device.caps
                property_text("Graphics device", caps.device)
                property_text("API", f"{caps.backend} {caps.version}")
                property_text("Software rendering", "yes: expect low frame rates" if caps.software else "no")
                property_text("Largest texture", f"{caps.max_texture_size} texels")
        imgui.end_popup()
