"""Asks for what an operation takes that was chosen in the palette: a widget for each argument, by its declaration."""

from __future__ import annotations

from typing import Any

from imgui_bundle import imgui

from editor import theme
from editor.arguments import Argument
from editor.dialogs.modals import begin_card, center_next_window
from editor.operations import Operation
from editor.param_widgets import edit_value
from editor.strings import tr
from editor.ui import Ui
from editor.widgets import bold, em, pretty, property_grid, property_row, text
from engine.core.errors import LucarnaError
from engine.core.param import COMPONENTS, Param


class ArgumentsCard:
    """`operation`: what is asked about, or None. Enter runs it, Escape leaves; a bad value is told and asked again."""

    NAME = "###arguments"

    def __init__(self) -> None:
        self.operation: Operation | None = None
        self.values: dict[str, Any] = {}
        self.problem = ""

    def draw(self, ui: Ui) -> None:
        asked, ui.asked = ui.asked, None
        if asked is not None:
            self.operation, self.problem = asked, ""
            self.values = {a.name: a.default if not a.required else first_value(ui, a) for a in asked.arguments}
            imgui.open_popup(self.NAME)
        center_next_window(28)
        if not begin_card(self.NAME, modal=True):
            return
        operation = self.operation
        if operation is None or imgui.is_key_pressed(imgui.Key.escape):
            self.operation = None
            imgui.close_current_popup()
            imgui.end_popup()
            return
        with bold(ui):
            imgui.text_unformatted(tr(operation.label))
        if operation.doc:
            text(tr(operation.doc), theme.DIM)
        with property_grid("arguments") as shown:
            for argument in operation.arguments if shown else ():
                self._row(ui, argument)
        if self.problem:
            imgui.push_text_wrap_pos(0.0)
            text(self.problem, theme.ERROR)
            imgui.pop_text_wrap_pos()
        imgui.spacing()
        entered = imgui.is_key_pressed(imgui.Key.enter) or imgui.is_key_pressed(imgui.Key.keypad_enter)
        if imgui.button(f"{tr('Do it')}###do", (em(7), 0)) or entered:
            self._run(ui, operation)
        imgui.same_line()
        if imgui.button("Cancel", (em(7), 0)):
            self.operation = None
        imgui.end_popup()

    def _row(self, ui: Ui, argument: Argument) -> None:
        property_row(pretty(argument.name), argument.doc)
        value = self.values[argument.name]
        imgui.push_id(argument.name)
        if argument.type in COMPONENTS:
            choices = argument.known(ui.session)
            param = Param(argument.name, argument.type, value, argument.min, argument.max, 0.0, argument.unit, choices)
            if argument.type == "enum" and value not in choices:
                value = choices[0] if choices else ""
            self.values[argument.name] = edit_value(param, value)[1]
        else:
            _, entered = imgui.input_text(f"##{argument.name}", shown_value(value))
            self.values[argument.name] = entered
        imgui.pop_id()

    def _run(self, ui: Ui, operation: Operation) -> None:
        given = {a.name: typed_value(a, self.values[a.name]) for a in operation.arguments}
        try:
            ui.operations.run(operation.id, ui.session, **given)
        except LucarnaError as error:
            self.problem = str(error)
            return
        self.operation = None


def first_value(ui: Ui, argument: Argument) -> Any:
    """What stands in the field of a required argument at first."""
    if argument.type == "enum":
        return next(iter(argument.known(ui.session)), "")
    count = COMPONENTS.get(argument.type, 0)
    if argument.type == "bool":
        return False
    low = min(max(0.0, argument.min), argument.max)
    whole = argument.type in ("int", "uint")
    return (low,) * count if count > 1 else (int(low) if whole else low) if count == 1 else ""


def shown_value(value: Any) -> str:
    return "" if value is None else ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


def typed_value(argument: Argument, value: Any) -> Any:
    """What was typed as the argument's own kind: nodes by a comma between, values as numbers where they are some."""
    if not isinstance(value, str) or argument.type in ("text", "path", "enum"):
        return value
    parts = [_number(part.strip()) for part in value.split(",") if part.strip()]
    if argument.type == "nodes":
        return parts
    if argument.type == "node":
        return parts[0] if parts else -1
    if not parts:
        return argument.default if not argument.required else ""
    return parts[0] if len(parts) == 1 else tuple(parts)


def _number(word: str) -> Any:
    if word.lower() in ("true", "false"):
        return word.lower() == "true"
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return word
