"""The row of open documents over the viewport: a click brings one to the front, a drag moves it, the cross or the
middle button closes it. Drawn only where there are two or more."""

from __future__ import annotations

from imgui_bundle import imgui

from editor import tabs, theme
from editor.ui import Ui
from editor.widgets import em, tooltip

#: who asked last for the tab in front: the session, or the row itself
_shown: list[object] = [None]


def draw(ui: Ui) -> None:
    """Draw the row, if there is anything to choose."""
    session = ui.session
    if len(session.tabs) < 2:
        return
    flags = imgui.TabBarFlags_.fitting_policy_scroll | imgui.TabBarFlags_.reorderable
    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + em(0.3))
    shown = imgui.begin_tab_bar("##documents", flags | imgui.TabBarFlags_.draw_selected_overline)
    if not shown:
        return
    imgui.push_style_color(imgui.Col_.tab_selected, imgui.ImVec4(*theme.FRAME))
    imgui.push_style_color(imgui.Col_.tab_selected_overline, imgui.ImVec4(*theme.ACCENT))
    raise_it = _shown[0] is not session.document
    chosen, closed = -1, -1
    for index, tab in enumerate(session.tabs):
        document = tab.document
        item = imgui.TabItemFlags_.none | imgui.TabItemFlags_.no_assumed_closure
        if document.dirty:
            item |= imgui.TabItemFlags_.unsaved_document
        if raise_it and document is session.document:
            item |= imgui.TabItemFlags_.set_selected
        selected, stays = imgui.begin_tab_item(f"{document.name}###document{id(document)}", True, item)
        tooltip(f"{document.source}\n{'Unsaved changes' if document.dirty else 'No unsaved changes'}")
        if selected:
            if document is not session.document and not raise_it:
                chosen = index
            imgui.end_tab_item()
        if not stays:
            closed = index
    imgui.end_tab_bar()
    imgui.pop_style_color(2)
    _shown[0] = session.document
    if closed >= 0:
        tabs.show(session, closed)
        ui.operations.run("file.close", session)
    elif chosen >= 0:
        tabs.show(session, chosen)
        _shown[0] = session.document
