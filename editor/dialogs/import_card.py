"""The import card: beside the picture after an import, until it is put away: what came in, what is odd about it, and
buttons that mend the usual mistakes. No modal: everything else goes on, and the first thing that the user does folds
the card to one line (import_card_place.py)."""

from __future__ import annotations

from pathlib import Path

from imgui_bundle import imgui

from editor import icons, import_settings, theme
from editor.dialogs.import_card_place import EDGE, NARROW, Folding, placed
from editor.import_settings import FIXES, can_import
from editor.reimporting import stamp_of
from editor.ui import Ui
from editor.widgets import bold, em, fitted, text, tooltip
from engine.core.errors import LucarnaError
from engine.core.findings import Severity
from importers.presets import sidecar_path
from importers.settings import ImportSettings

#: findings and orphans that are listed; of more, their count
LISTED = 6
FLAGS = (
    imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_docking | imgui.WindowFlags_.always_auto_resize
    | imgui.WindowFlags_.no_focus_on_appearing | imgui.WindowFlags_.no_nav | imgui.WindowFlags_.no_title_bar
    | imgui.WindowFlags_.no_move
)  # fmt: skip


class ImportCard:
    NAME = "###import-card"

    def __init__(self) -> None:
        self._key: object = None
        self._facts: dict[str, str] = {}
        self._read: tuple[object, ImportSettings] | None = None
        self.folding = Folding()
        #: em that all of it took in the last draw
        self._height = 1e9

    def draw(self, ui: Ui) -> None:
        session = ui.session
        document = session.document
        if not session.ui.import_card or session.ui.welcome or document is None or not can_import(session):
            return
        if ui.viewport_at < ui.drawn:  # it lies behind another panel, and so does what belongs to it
            return
        assert document.imported_from is not None
        x, y, width, height = ui.viewport_area
        place = placed(width / em(1), height / em(1), self._height)
        if session.ui.import_card_opened:
            session.ui.import_card_opened = False
            self.folding.choose(whole=True)
        deed = document.selection, document.history.revision, session.camera
        self.folding.follow(document.news or document, deed, busy=session.importing is not None)
        whole = place.whole if self.folding.whole is None else self.folding.whole
        session.ui.import_card_folded = not whole
        if not whole and not place.fits:
            return
        name = f"{icons.MESH}  {fitted(document.imported_from.name, em(place.width - 6.8))}"
        with bold(ui):
            line = imgui.calc_text_size(name).x / em(1)
        wide = place.width if whole else min(max(line + 6.0, NARROW), max(width / em(1) - 2.0 * EDGE, NARROW))
        at = (x + width - em(EDGE), y + em(place.top if whole else place.line))
        imgui.set_next_window_pos(at, imgui.Cond_.always, (1.0, 0.0))
        imgui.set_next_window_size_constraints((em(wide), 0), (em(wide), em(place.height)))
        imgui.set_next_window_bg_alpha(0.95)
        imgui.begin(self.NAME, None, FLAGS)
        with bold(ui):
            imgui.text_unformatted(name)
        imgui.same_line(em(wide - 4.2))
        if imgui.small_button("–" if whole else "+"):
            self.folding.choose(whole=not whole)
        tooltip("Its name only" if whole else "All of it: size, warnings, what mends the usual mistakes")
        imgui.same_line(0, em(0.3))
        if imgui.small_button("×"):
            session.ui.import_card = False
        tooltip("Put it away; File, Import card brings it back")
        if not whole:
            imgui.end()
            return
        key = (id(document.runtime), document.history.revision)
        if key != self._key:
            self._key, self._facts = key, import_settings.facts(document)
        facts = list(self._facts.items())
        first = 1 if self._height > place.height else len(facts)  # where not all is seen, what is to be clicked is
        self._tell(facts[:first], place.width)
        self._fixes(ui)
        self._news(ui)
        self._tell(facts[first:], place.width)
        self._height = (imgui.get_cursor_pos_y() + imgui.get_style().window_padding.y) / em(1)
        imgui.end()

    @staticmethod
    def _tell(facts: list[tuple[str, str]], width: float) -> None:
        for name, value in facts:
            text(name, theme.DIM)
            imgui.same_line(em(5.2))
            imgui.text_unformatted(fitted(value, em(width - 6.5)))

    def _settings(self, source: Path) -> ImportSettings:
        """Read again only when the sidecar changed."""
        key = source, stamp_of(sidecar_path(source))
        if self._read is None or self._read[0] != key:
            self._read = key, import_settings.settings_of(source)
        return self._read[1]

    def _fixes(self, ui: Ui) -> None:
        session = ui.session
        assert session.document is not None
        source = session.document.imported_from
        assert source is not None
        imgui.separator()
        try:
            settings = self._settings(source)
        except LucarnaError as error:
            text(f"{icons.ERROR} {error}", theme.ERROR)
            return
        busy = session.importing is not None
        imgui.begin_disabled(busy)
        room = imgui.get_content_region_avail().x
        used = 0.0
        for fix in FIXES:
            width = imgui.calc_text_size(fix.label).x + 2 * imgui.get_style().frame_padding.x
            if used and used + width + em(0.4) < room:
                imgui.same_line(0, em(0.4))
            else:
                used = 0.0
            used += width + em(0.4)
            on = import_settings.is_on(settings, fix)
            if on:
                imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*theme.ACCENT[:3], 0.35))
            if imgui.button(f"{fix.label}###{fix.id}"):
                ui.operations.run(f"import.{fix.id}", session)
            if on:
                imgui.pop_style_color()
            tooltip(f"{fix.doc}\n{'Again takes it back. ' if not fix.factor else ''}Kept in the source's sidecar")
        imgui.end_disabled()
        said = {k: v for k, v in settings.differences().items() if k != "quality"}
        if busy:
            text(session.importing.text if session.importing is not None else "", theme.ACCENT)
        elif said:
            text(fitted(", ".join(f"{k} {v}" for k, v in said.items()), room), theme.FAINT)

    def _news(self, ui: Ui) -> None:
        """What the last import noticed, and what found no place in it."""
        document = ui.session.document
        assert document is not None
        news = document.news
        findings = list(news.findings.items) if news is not None else list(document.findings.items)
        bad = [f for f in findings if f.severity is not Severity.INFO]
        lines = [(icons.WARNING, theme.WARNING, f"Orphan: {line}") for line in (news.orphans if news else ())]
        if news is not None and news.report is not None:
            lines += [(icons.WARNING, theme.WARNING, f"Both changed {line}") for line in news.report.conflicts]
        lines += [
            (icons.ERROR if f.severity is Severity.ERROR else icons.WARNING, theme.WARNING, f.message) for f in bad
        ]
        if news is not None and news.report is not None:
            imgui.separator()
            imgui.push_text_wrap_pos(0.0)
            text(news.report.summary, theme.DIM)
            imgui.pop_text_wrap_pos()
            tooltip("The log has every line of it")
        for icon, color, line in lines[:LISTED]:
            text(icon, color)
            imgui.same_line(0, em(0.4))
            imgui.text_unformatted(fitted(line, imgui.get_content_region_avail().x))
            tooltip(line)
        if len(lines) > LISTED:
            text(f"and {len(lines) - LISTED} more, in the log", theme.FAINT)
        elif not lines:
            text("No warnings", theme.GOOD)
