"""The shader editor's bars: what can be done with the text, what is wrong, what changed elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from imgui_bundle import imgui

from editor import icons, theme
from editor.code.document import CodeDocument
from editor.code.files import is_built_in
from editor.code.problems import STATES
from editor.theme import Rgba
from editor.ui import Ui
from editor.widgets import em, fitted_text, icon_button, mono, text


def draw_header(ui: Ui) -> None:
    """Buttons, and the first problem."""
    session = ui.session
    front, problems = session.code.front, session.shaders.problems
    if icon_button(f"{icons.SAVE}##save-text", "Save (Ctrl+S)", enabled=front is not None and front.dirty):
        session.save_code()
    imgui.same_line(0, em(0.2))
    if icon_button(f"{icons.RELOAD}##reload", "Reload shaders (F5)"):
        ui.operations.run("shader.reload", session)
    imgui.same_line(0, em(0.2))
    if icon_button(f"{icons.NEXT_ERROR}##next-error", "Next error (F8)", enabled=bool(problems)):
        ui.operations.run("shader.next-error", session)
    imgui.same_line(0, em(0.2))
    if icon_button(f"{icons.SEARCH}##find", "Find and replace (Ctrl+F)", enabled=front is not None):
        ui.operations.run("shader.find", session)
    imgui.same_line(0, em(0.8))
    imgui.align_text_to_frame_padding()
    if problems:
        first = problems[0]
        fitted_text(
            f"{icons.ERROR}  {first.place}  {first.message}", theme.ERROR, more=f"{STATES[first.state]}\n{first.detail}"
        )
    elif session.shaders.taken:
        fitted_text(f"Up to date; the last change took {session.shaders.last_ms:.0f} ms", theme.FAINT)
    else:
        text("Saved text shows at once", theme.FAINT)


def draw_bars(ui: Ui, document: CodeDocument) -> None:
    """Above the text: a conflict, a file that is gone, a built-in shader."""
    if document.conflict:
        _conflict(ui, document)
    elif document.gone:
        if (
            _bar("gone", theme.WARNING, f"{icons.WARNING}  {document.name} is not there any more", ["Write it again"])
            == 0
        ):
            ui.session.save_code()
    elif document.read_only or is_built_in(document.path):
        what = "Read-only" if document.read_only else "Lucarna's own"
        buttons = (
            ["Copy into project to edit"] if is_built_in(document.path) and ui.session.document is not None else []
        )
        if _bar("built-in", theme.INFO, f"{icons.LOCK}  {what}", buttons) == 0:
            ui.session.copy_code_into_project()


def _conflict(ui: Ui, document: CodeDocument) -> None:
    words = f"{icons.WARNING}  Changed elsewhere too"
    chosen = _bar("conflict", theme.WARNING, words, ["Keep mine", "Take theirs", "Show difference"])
    if chosen == 0:
        document.keep_mine()
        ui.session.save_code()
    elif chosen == 1:
        document.take_theirs()
    elif chosen == 2:
        imgui.open_popup("Difference")
    _difference(ui, document)


def _difference(ui: Ui, document: CodeDocument) -> None:
    from imgui_bundle import imgui_color_text_edit as code_edit

    from editor.code_field import language_of

    size = imgui.get_main_viewport().size
    imgui.set_next_window_size((size.x * 0.8, size.y * 0.75), imgui.Cond_.appearing)
    if not imgui.begin_popup_modal("Difference", None, 0)[0]:
        return
    differ = _DIFFERENCES.get(document.path)
    if differ is None or differ[0] != (document.theirs, document.text):
        made = code_edit.TextDiff()
        made.set_side_by_side_mode(_SIDE_BY_SIDE[0])
        made.set_show_whitespaces_enabled(False)
        made.set_word_wrap_enabled(True)  # else it opens scrolled to the right, with the lines' beginnings out of sight
        made.set_palette(code_edit.TextEditor.get_dark_palette())
        made.set_colors(theme.u32(theme.GOOD, 0.22), theme.u32(theme.ERROR, 0.22))
        made.set_language(language_of(document))
        made.set_text(document.theirs or "", document.text)
        differ = _DIFFERENCES[document.path] = ((document.theirs, document.text), made)
    red, green = ("left", "right") if _SIDE_BY_SIDE[0] else ("red", "green")
    text(f"{red.capitalize()}: what the other program wrote. {green.capitalize()}: yours.", theme.DIM)
    imgui.same_line(imgui.get_window_width() - em(11))
    changed, _SIDE_BY_SIDE[0] = imgui.checkbox("Side by side", _SIDE_BY_SIDE[0])
    if changed:
        differ[1].set_side_by_side_mode(_SIDE_BY_SIDE[0])
    with mono(ui):
        differ[1].render("##difference", (0, -em(2.6)))
    for index, label in enumerate(("Keep mine", "Take theirs", "Close")):
        if imgui.button(label, (em(8), 0)):
            if index == 0:
                document.keep_mine()
                ui.session.save_code()
            elif index == 1:
                document.take_theirs()
            _DIFFERENCES.pop(document.path, None)
            imgui.close_current_popup()
        imgui.same_line()
    imgui.end_popup()


#: path -> ((theirs, mine), the widget that shows how they differ)
_DIFFERENCES: dict[Path, tuple[tuple[str | None, str], Any]] = {}
#: how it shows them
_SIDE_BY_SIDE = [True]


def _bar(name: str, color: Rgba, words: str, buttons: list[str]) -> int:
    """Words on a tinted ground with buttons, below them where the panel is narrow; which was pressed, or -1."""
    width = sum(imgui.calc_text_size(b).x + em(1.6) for b in buttons)
    narrow = imgui.calc_text_size(words).x + width + em(1) > imgui.get_content_region_avail().x
    imgui.push_style_color(imgui.Col_.child_bg, imgui.ImVec4(color[0], color[1], color[2], 0.12))
    lines = 2 if narrow and buttons else 1
    height = lines * imgui.get_frame_height() + em(0.5) + (lines - 1) * em(0.2)
    pressed = -1
    imgui.begin_child(f"bar-{name}", (0, height), 0, imgui.WindowFlags_.no_scrollbar)
    imgui.set_cursor_pos((em(0.5), em(0.25)))
    imgui.align_text_to_frame_padding()
    fitted_text(words, color)
    if lines == 2:
        imgui.set_cursor_pos((em(0.5), em(0.45) + imgui.get_frame_height()))
    else:
        imgui.same_line(imgui.get_window_width() - width)
    for index, label in enumerate(buttons):
        if imgui.button(label):
            pressed = index
        imgui.same_line(0, em(0.4))
    imgui.end_child()
    imgui.pop_style_color()
    return pressed
