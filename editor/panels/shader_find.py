"""The shader editor's bar to find and replace, over the text: Enter finds the next, Shift+Enter the one before, Escape
closes it."""

from __future__ import annotations

from imgui_bundle import imgui

from editor import icons, theme
from editor.code.search import Search, after
from editor.code_field import CodeField
from editor.widgets import em, icon_button, text


class FindBar:
    """One for all texts: what is looked for stays when another is in front."""

    def __init__(self) -> None:
        self.search = Search()
        self.shown = False
        self._focus = False
        self._places: list[tuple[int, int, int]] = []
        self._key: object = None

    def open(self, field: CodeField) -> None:
        """Show it, with what is selected in the text as what to look for."""
        self.shown = self._focus = True
        chosen = field.selected()
        if chosen and "\n" not in chosen:
            self.search.needle = chosen

    def draw(self, field: CodeField) -> None:
        if not self.shown:
            return
        document, search = field.document, self.search
        key = (document.path, document.text, search.needle, search.case, search.word)
        if key != self._key:
            self._key, self._places = key, search.places(document.text)
        room = imgui.get_content_region_avail().x
        buttons = em(10.6)
        if self._focus:
            imgui.set_keyboard_focus_here()
            self._focus = False
        imgui.set_next_item_width(max(room - buttons, em(5)))
        entered, search.needle = imgui.input_text_with_hint(
            "##find", f"{icons.SEARCH}  Find", search.needle, imgui.InputTextFlags_.enter_returns_true
        )
        if not entered and imgui.is_item_deactivated() and imgui.is_key_pressed(imgui.Key.escape, False):
            self.shown = False
            field.editor.set_focus()
        imgui.same_line(0, em(0.2))
        if icon_button("Aa###case", "Match case", active=search.case):
            search.case = not search.case
        imgui.same_line(0, em(0.1))
        if icon_button("[w]###word", "Whole words only", active=search.word):
            search.word = not search.word
        imgui.same_line(0, em(0.1))
        back = icon_button(f"{icons.UP}###before", "The one before (Shift+Enter)", enabled=bool(self._places))
        imgui.same_line(0, em(0.1))
        on = icon_button(f"{icons.DOWN}###next", "The next one (Enter)", enabled=bool(self._places))
        imgui.same_line(0, em(0.1))
        if icon_button(f"{icons.CLEAR}###close", "Close (Escape)"):
            self.shown = False
        if entered:
            self._focus = True
            back, on = bool(imgui.get_io().key_shift), not imgui.get_io().key_shift
        if self._places and (back or on):
            self._go(field, -1 if back else 1)
        self._replace(field, room, buttons)

    def _replace(self, field: CodeField, room: float, buttons: float) -> None:
        search = self.search
        editable = not field.document.read_only and bool(self._places)
        imgui.set_next_item_width(max(room - buttons, em(5)))
        _changed, search.new = imgui.input_text_with_hint("##replace", "Replace by", search.new)
        imgui.same_line(0, em(0.2))
        imgui.begin_disabled(not editable)
        if imgui.button("One"):
            self._replace_one(field)
        imgui.same_line(0, em(0.2))
        if imgui.button("All"):
            field.document.put(search.replaced(field.document.text))  # one step of the field's own undo
        imgui.end_disabled()
        imgui.same_line(0, em(0.4))
        count = len(self._places)
        text(f"{count}" if search.needle else "", theme.DIM if count else theme.ERROR)

    def _go(self, field: CodeField, step: int) -> None:
        line, column = field.selection_start() if step < 0 else field.selection_end()
        field.select(*self._places[after(self._places, line, column, step)])

    def _replace_one(self, field: CodeField) -> None:
        """The one that is selected, and on to the next; else only on to the next."""
        start = field.selection_start()
        here = next((place for place in self._places if place[:2] == start), None)
        if here is not None and field.selection_end() == (here[0], here[2]):
            field.replace_selection(self.search.new)
            self._places = self.search.places(field.document.text)
            self._key = None
        if self._places:
            self._go(field, 1)
