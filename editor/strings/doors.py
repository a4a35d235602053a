"""Labels are translated where they go into imgui: its functions that take a label are wrapped while the interface is in
another language than English. So a panel is written in English and needs no word about it; in English nothing is
wrapped and nothing costs.

A translated label keeps the identity of the English one (`label###English`), so that windows, headings and tests find
it again in every language."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from imgui_bundle import imgui

from editor import strings

#: functions whose first argument is a label with an identity
LABELS = (
    "button", "small_button", "checkbox", "radio_button", "menu_item", "menu_item_simple", "begin_menu",
    "collapsing_header", "tree_node", "tree_node_ex", "begin_tab_item", "selectable",
)  # fmt: skip
#: functions whose argument at this place is text alone
TEXTS = {
    "text_unformatted": 0, "text": 0, "text_wrapped": 0, "text_disabled": 0, "text_colored": 1, "separator_text": 0,
    "calc_text_size": 0, "set_tooltip": 0, "set_item_tooltip": 0, "table_setup_column": 0, "bullet_text": 0,
    "begin_combo": 1,
}  # fmt: skip
#: a label with an identity, and text in the place after it
HINTED = ("input_text_with_hint",)
_originals: dict[str, Callable[..., Any]] = {}


def apply(language: str) -> None:
    """Speak this language from now on (`auto`: the system's)."""
    strings.set_language(language)
    if strings.language() == "en":
        _unwrap()
    elif not _originals:
        _wrap()


def translated_label(label: str) -> str:
    shown = strings.tr(label)
    if shown == label:
        return label
    return shown if "##" in label else f"{shown}###{label}"


def _wrap() -> None:
    for name in LABELS:
        _replace(name, _labelled)
    for name, place in TEXTS.items():
        _replace(name, partial(_texted, place=place))
    for name in HINTED:
        _replace(name, _hinted)
    _replace("combo", _combo)


def _replace(name: str, make: Callable[[Callable[..., Any]], Callable[..., Any]]) -> None:
    original = getattr(imgui, name, None)
    if original is not None:
        _originals[name] = original
        setattr(imgui, name, make(original))


def _unwrap() -> None:
    for name, original in _originals.items():
        setattr(imgui, name, original)
    _originals.clear()


def _labelled(original: Callable[..., Any]) -> Callable[..., Any]:
    def call(label: str, *more: Any, **named: Any) -> Any:
        return original(translated_label(label), *more, **named)

    return call


def _texted(original: Callable[..., Any], place: int) -> Callable[..., Any]:
    def call(*given: Any, **named: Any) -> Any:
        if len(given) > place and isinstance(given[place], str):
            given = (*given[:place], strings.tr(given[place]), *given[place + 1 :])
        return original(*given, **named)

    return call


def _hinted(original: Callable[..., Any]) -> Callable[..., Any]:
    def call(label: str, hint: str, *more: Any, **named: Any) -> Any:
        return original(translated_label(label), strings.tr(hint), *more, **named)

    return call


def _combo(original: Callable[..., Any]) -> Callable[..., Any]:
    def call(label: str, index: int, items: Any, *more: Any, **named: Any) -> Any:
        shown = [strings.tr(item) for item in items] if isinstance(items, (list, tuple)) else items
        return original(translated_label(label), index, shown, *more, **named)

    return call
