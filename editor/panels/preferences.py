"""Preferences: language, size of the interface, and the keymap: presets, search, binding, conflicts, files."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.flowing import button_width, flow_button
from editor.habit_operations import BACKGROUNDS
from editor.keymap import PRESET_KEYS
from editor.keys import pressed_shortcut, shown_shortcut
from editor.navigation import POINTERS
from editor.operations import Operation, match_score
from editor.panels.base import Panel
from editor.preferences import IN_BACKGROUND
from editor.requests import ChooseFile
from editor.strings import LANGUAGES, tr, verbatim
from editor.ui import Ui
from editor.widgets import (
    em,
    flow,
    icon_button,
    pretty,
    property_grid,
    property_row,
    search_field,
    section,
    text,
    tooltip,
)
from engine.core.errors import LucarnaError
from engine.core.paths import user_config_dir

#: limits of pictures a second to choose from
FPS_LIMITS = (15, 30, 60, 120)


class PreferencesPanel(Panel):
    title: ClassVar[str] = "Preferences"
    icon: ClassVar[str] = icons.SETTINGS
    dock: ClassVar[str] = "MainDockSpace"
    opened: ClassVar[bool] = False

    def __init__(self) -> None:
        self.needle = ""
        #: the operation whose new key is waited for, and the key that another has
        self.waiting = ""
        self.taken = ""
        self.changed_only = False

    def draw(self, ui: Ui) -> None:
        ui.keymap.listening = bool(self.waiting)
        if section(ui, "Interface"):
            self._interface(ui)
        imgui.spacing()
        if section(ui, "Keys"):
            self._keymap(ui)

    def _interface(self, ui: Ui) -> None:
        preferences = ui.session.preferences
        with property_grid("interface") as shown:
            if not shown:
                return
            property_row("Language", "What the menus and panels speak; at once")
            codes = ["auto", *LANGUAGES]
            names = [tr("As the system"), *LANGUAGES.values()]
            now = codes.index(preferences.language) if preferences.language in codes else 0
            changed, chosen = imgui.combo("##language", now, names)
            if changed:
                preferences.language = codes[chosen]
                ui.session.remember()
            property_row("Size", "Of text and everything else, on top of what the display asks for")
            for label, id in (("-", "view.scale-down"), ("+", "view.scale-up"), ("100 %", "view.scale-reset")):
                if imgui.button(f"{label}##{id}"):
                    ui.operations.run(id, ui.session)
                imgui.same_line(0, em(0.3))
            text(f"{preferences.ui_scale * 100:.0f} %", theme.DIM)
            self._habits(ui)

    def _habits(self, ui: Ui) -> None:
        preferences, run = ui.session.preferences, ui.operations.run
        property_row("Pointer", "On a trackpad two fingers pan or orbit, as the keymap says, and a pinch zooms")
        names = [tr(pretty(pointer)) for pointer in POINTERS]
        changed, chosen = imgui.combo("##pointer", POINTERS.index(preferences.pointer), names)
        if changed:
            run(f"help.pointer-{POINTERS[chosen]}", ui.session)
        property_row("Reverse scrolling", "Two fingers and the wheel go the other way")
        if imgui.checkbox("##reverse", preferences.reverse_scroll)[0]:
            run("help.reverse-scroll", ui.session)
        property_row("Behind another window", "What animation does meanwhile; minimised, it always stops")
        names = [tr(BACKGROUNDS[choice]) for choice in IN_BACKGROUND]
        changed, chosen = imgui.combo("##background", IN_BACKGROUND.index(preferences.in_background), names)
        if changed:
            run(f"view.background-{IN_BACKGROUND[chosen]}", ui.session)
        property_row("Pictures a second", "At most, while something moves; still windows draw none")
        names = [tr("as the display")] + [str(limit) for limit in FPS_LIMITS]
        now = FPS_LIMITS.index(preferences.fps_limit) + 1 if preferences.fps_limit in FPS_LIMITS else 0
        changed, chosen = imgui.combo("##fps", now, names)
        if changed:
            run("view.fps-limit", ui.session, fps=FPS_LIMITS[chosen - 1] if chosen else 0)

    # --- keys ---

    def _keymap(self, ui: Ui) -> None:
        keymap = ui.keymap
        for preset in PRESET_KEYS:
            if preset != next(iter(PRESET_KEYS)):
                flow(button_width(tr(pretty(preset))) + em(1.5), 0.8)
            if imgui.radio_button(pretty(preset), keymap.preset == preset):
                ui.operations.run(f"help.keymap-{preset}", ui.session)
                keymap.apply()
        if flow_button("Reset all##reset-keys", first=True):
            keymap.reset()
            ui.session.remember()
        if flow_button(f"{tr('Import')}…##import-keys"):
            ui.session.ui.choose = ChooseFile(tr("Import keys"), (".json",), Path.home(), lambda path: _take(ui, path))
        if flow_button("Export##export-keys"):
            ui.operations.run("help.export-keymap", ui.session, path=str(user_config_dir() / "lucarna-keys.json"))
        flow(button_width(tr("Changed ones only")) + em(1.5), 0.8)
        _, self.changed_only = imgui.checkbox("Changed ones only", self.changed_only)
        self.needle = search_field("##keys", self.needle, "Name of an operation, or a key such as Ctrl+D")
        if self.waiting:
            self._listen(ui)
        if imgui.begin_table("keys", 3, imgui.TableFlags_.row_bg | imgui.TableFlags_.sizing_stretch_prop):
            imgui.table_setup_column("name", imgui.TableColumnFlags_.width_stretch, 0.55)
            imgui.table_setup_column("keys", imgui.TableColumnFlags_.width_stretch, 0.35)
            imgui.table_setup_column("reset", imgui.TableColumnFlags_.width_fixed, em(2.2))
            rows = self.rows(ui)
            clipper = imgui.ListClipper()
            clipper.begin(len(rows))
            while clipper.step():
                for operation in rows[clipper.display_start : clipper.display_end]:
                    self._row(ui, operation)
            clipper.end()
            imgui.end_table()

    def rows(self, ui: Ui) -> list[Operation]:
        """The operations that the search finds, by label, its translation, or key; the best first."""
        found: list[tuple[float, Operation]] = []
        for operation in ui.operations:
            if self.changed_only and operation.id not in ui.keymap.changes:
                continue
            keys = ui.operations.keys_of(operation)
            words = f"{operation.menu} {operation.label} {tr(operation.label)} {operation.id}"
            by_key = self.needle.lower() in (key.lower() for key in keys)
            score = 0.0 if by_key else match_score(self.needle, words)
            if score is not None:
                found.append((score if self.needle else 0.0, operation))
        return [operation for _score, operation in sorted(found, key=lambda entry: entry[0])]

    def _row(self, ui: Ui, operation: Operation) -> None:
        imgui.push_id(operation.id)
        imgui.table_next_row()
        imgui.table_next_column()
        imgui.align_text_to_frame_padding()
        changed = operation.id in ui.keymap.changes
        label = f"{tr(operation.menu)} › {tr(operation.label)}" if operation.menu else tr(operation.label)
        text(label, theme.TEXT if changed else theme.DIM)
        tooltip(f"{operation.id}\n{operation.doc}".strip())
        imgui.table_next_column()
        keys = "   ".join(map(shown_shortcut, ui.operations.keys_of(operation))) or "—"
        words = tr("press a key…") if self.waiting == operation.id else keys
        with verbatim():
            clicked = imgui.button(f"{words}###bind", (-1, 0))
        if clicked:
            self.waiting, self.taken = operation.id, ""
        tooltip(tr("Click, then press the new key; Delete takes the key away, Escape keeps it"))
        imgui.table_next_column()
        if changed and icon_button(f"{icons.RESET}###reset", "As the preset has it"):
            ui.keymap.reset(operation.id)
            ui.session.remember()
        imgui.pop_id()

    def _listen(self, ui: Ui) -> None:
        """Wait for the key; one that is taken is asked about."""
        if imgui.is_key_pressed(imgui.Key.escape, False):
            self.waiting = ""
            return
        if self.taken:
            others = ui.keymap.conflicts(self.waiting, [self.taken])
            names = ", ".join(tr(ui.operations[other].label) for other in others)
            text(f"{icons.WARNING}  {shown_shortcut(self.taken)}: {names}", theme.WARNING)
            if flow_button("Take it from there##take"):
                self._bind(ui, [self.taken], replace=True)
            if flow_button("Keep##keep"):
                self.waiting = self.taken = ""
            return
        pressed = pressed_shortcut()
        if pressed == "Delete":
            self._bind(ui, [])
        elif pressed and ui.keymap.conflicts(self.waiting, [pressed]):
            self.taken = pressed
        elif pressed:
            self._bind(ui, [pressed])

    def _bind(self, ui: Ui, keys: list[str], *, replace: bool = False) -> None:
        try:
            ui.keymap.bind(self.waiting, keys, replace=replace)
        except LucarnaError as error:
            ui.session.ui.notice = str(error)
        self.waiting = self.taken = ""
        ui.session.remember()


def _take(ui: Ui, path: Path) -> None:
    ui.operations.run("help.import-keymap", ui.session, path=str(path))


PANEL = PreferencesPanel
