"""Progress of an opening file, the question about unsaved changes, and short notices."""

from __future__ import annotations

from imgui_bundle import imgui

from editor import icons, theme
from editor.ui import Ui
from editor.widgets import bold, em, text

NOTICE_SECONDS = 3.0
#: a job shorter than this shows no window, which would only flicker
PATIENCE_SECONDS = 0.25


def center_next_window(width: float) -> None:
    """Put the next window in the middle, `width` em wide, as high as its content."""
    viewport = imgui.get_main_viewport()
    imgui.set_next_window_pos(viewport.get_center(), imgui.Cond_.always, (0.5, 0.5))
    imgui.set_next_window_size((em(width), 0), imgui.Cond_.always)


def begin_card(name: str, *, modal: bool, flags: int = 0) -> bool:
    """Begin a popup with more room round its content; when True, draw it and call imgui.end_popup()."""
    imgui.push_style_var(imgui.StyleVar_.window_padding, (em(1.1), em(0.95)))
    flags |= imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_resize
    if modal:
        shown = imgui.begin_popup_modal(name, None, flags | imgui.WindowFlags_.no_title_bar)[0]
    else:
        shown = imgui.begin_popup(name, flags)
    imgui.pop_style_var()
    return bool(shown)


class ProgressModal:
    """While a file is being opened: what is being done, how far it is, and a way out."""

    NAME = "Opening###progress"

    def __init__(self) -> None:
        self._since = 0.0
        self._job: object = None

    def draw(self, ui: Ui) -> None:
        job = ui.session.job
        now = imgui.get_time()
        if job is not self._job:
            self._job, self._since = job, now
        wanted = job is not None and not ui.session.ui.welcome  # the card is no place to be interrupted in
        if wanted and now - self._since > PATIENCE_SECONDS and not imgui.is_popup_open(self.NAME):
            imgui.open_popup(self.NAME)
        center_next_window(26)
        if not begin_card(self.NAME, modal=True):
            return
        if job is None:
            imgui.close_current_popup()
        else:
            with bold(ui):
                imgui.text_unformatted(f"Opening {job.path.name}")
            imgui.push_text_wrap_pos(0)
            text(job.text, theme.DIM)
            imgui.pop_text_wrap_pos()
            fraction = job.fraction if job.fraction >= 0.0 else -0.6 * now
            imgui.progress_bar(fraction, (-1, em(0.55)), "")
            imgui.spacing()
            if imgui.button("Cancel", (em(6), 0)) or imgui.is_key_pressed(imgui.Key.escape):
                job.cancel()
            if job.cancelled:
                imgui.same_line()
                text("Stopping at the next step…", theme.DIM)
        imgui.end_popup()


class DiscardModal:
    """Asks what becomes of unsaved changes before something would lose them."""

    NAME = "Unsaved changes"

    def draw(self, ui: Ui) -> None:
        session = ui.session
        pending = session.ui.after_discard
        if pending is not None and not imgui.is_popup_open(self.NAME):
            imgui.open_popup(self.NAME)
        center_next_window(26)
        if not begin_card(self.NAME, modal=True):
            return
        if pending is None or not session.asked_about:
            session.ui.after_discard = None
            imgui.close_current_popup()
        else:
            with bold(ui):
                imgui.text_unformatted(f"{icons.WARNING}  {', '.join(session.asked_about)}: unsaved changes")
            if session.document is not None and session.document.dirty:
                text(f"{len(session.document.history.entries)} edits since it was opened or saved", theme.DIM)
            imgui.spacing()
            if imgui.button("Save", (em(6), 0)) and (session.save_all() if session.ui.discard_all else session.save()):
                self._go(ui)
            imgui.same_line()
            if imgui.button("Discard", (em(6), 0)):
                session.discard()
                self._go(ui)
            imgui.same_line()
            if imgui.button("Cancel", (em(6), 0)) or imgui.is_key_pressed(imgui.Key.escape) or session.ui.save_dialog:
                session.ui.after_discard = None
        imgui.end_popup()

    def _go(self, ui: Ui) -> None:
        pending, ui.session.ui.after_discard = ui.session.ui.after_discard, None
        if pending is not None:
            pending()


class Notice:
    """A line at the bottom that says what just happened, and goes."""

    def __init__(self) -> None:
        self._text = ""
        self._since = -1e9

    def draw(self, ui: Ui) -> None:
        if ui.session.ui.notice:
            self._text, ui.session.ui.notice = ui.session.ui.notice, ""
            self._since = imgui.get_time()
        age = imgui.get_time() - self._since
        if age > NOTICE_SECONDS:
            return
        ui.again_in(NOTICE_SECONDS - age + 0.02)
        viewport = imgui.get_main_viewport()
        imgui.set_next_window_pos(
            (viewport.pos.x + viewport.size.x * 0.5, viewport.pos.y + viewport.size.y - em(3.4)), 0, (0.5, 1.0)
        )
        flags = (
            imgui.WindowFlags_.no_decoration
            | imgui.WindowFlags_.no_inputs
            | imgui.WindowFlags_.no_saved_settings
            | imgui.WindowFlags_.no_docking
            | imgui.WindowFlags_.no_focus_on_appearing
            | imgui.WindowFlags_.always_auto_resize
            | imgui.WindowFlags_.no_nav
        )
        imgui.set_next_window_bg_alpha(0.92)
        imgui.begin("##notice", None, flags)
        imgui.text_unformatted(self._text)
        imgui.end()


def draw_error_bar(ui: Ui, y: float) -> None:
    """Over the top of the viewport area: the last error, until it is put away. The log keeps it."""
    message = ui.session.ui.error_bar
    if not message:
        return
    viewport = imgui.get_main_viewport()
    imgui.set_next_window_pos((viewport.pos.x + viewport.size.x * 0.5, viewport.pos.y + y), 0, (0.5, 0.0))
    imgui.set_next_window_size((min(em(60), viewport.size.x * 0.7), 0))
    flags = (
        imgui.WindowFlags_.no_decoration
        | imgui.WindowFlags_.no_saved_settings
        | imgui.WindowFlags_.no_docking
        | imgui.WindowFlags_.no_focus_on_appearing
        | imgui.WindowFlags_.no_nav
    )
    imgui.push_style_color(imgui.Col_.window_bg, imgui.ImVec4(*theme.rgb("#3a1f1e", 0.97)))
    imgui.push_style_color(imgui.Col_.border, imgui.ImVec4(*theme.rgb("#7a3a36")))
    imgui.begin("##error-bar", None, flags)
    text(icons.ERROR, theme.ERROR)
    imgui.same_line(0, em(0.5))
    right = imgui.get_window_width() - imgui.calc_text_size("Dismiss").x - em(2.2)
    imgui.push_text_wrap_pos(right)
    imgui.text_unformatted(message)
    imgui.pop_text_wrap_pos()
    imgui.same_line(right)
    if imgui.small_button("Dismiss"):
        ui.session.ui.error_bar = ""
    imgui.end()
    imgui.pop_style_color(2)
