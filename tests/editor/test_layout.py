"""Workspaces, slots, themes."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("imgui_bundle")

from imgui_bundle import imgui

from editor import layout, layout_operations, layout_slots, theme
from editor.panels.registry import make_panels
from editor.preferences import THEMES, Preferences, load, save
from engine.core.errors import InputError, OutputError


def test_operations_and_layouts_know_the_same_workspaces() -> None:
    assert tuple(w.name for w in layout.WORKSPACES) == layout_operations.WORKSPACES
    assert layout_operations.SLOTS == layout_slots.SLOTS
    assert layout.named("of another version") is layout.WORKSPACES[0]


def test_workspaces_name_panels_that_are() -> None:
    panels = make_panels()
    titles = {p.title for p in panels}
    for workspace in layout.WORKSPACES:
        assert {*workspace.shown, *workspace.hidden, *workspace.front, *workspace.docks} <= titles
        assert set(workspace.front) <= {p.title for p in panels if workspace.opens(p)}
        assert workspace.opens(next(p for p in panels if p.title == "Viewport"))


@pytest.fixture
def slots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(layout_slots, "layout_path", lambda: tmp_path / "layout.ini")
    taken: list[str] = []
    monkeypatch.setattr(imgui, "save_ini_settings_to_memory", lambda: "places")
    monkeypatch.setattr(imgui, "load_ini_settings_from_memory", taken.append)
    return tmp_path


def windows() -> list[Any]:
    return [
        SimpleNamespace(label=f"icon {name}###{name}", is_visible=shown, can_be_closed=name != "Viewport")
        for name, shown in (("Viewport", True), ("Log", True), ("Console", False))
    ]


def test_a_slot_brings_back_what_was_open(slots: Path) -> None:
    found = windows()
    assert "saved in slot 2" in layout_slots.run(("save", 2), found)
    for window in found:
        window.is_visible = not window.is_visible
    assert "of slot 2" in layout_slots.run(("load", 2), found)
    assert [w.is_visible for w in found] == [True, True, False]
    assert json.loads((slots / "layouts" / "slot-2.json").read_text(encoding="utf-8"))["places"] == "places"


def test_an_empty_or_damaged_slot_changes_nothing(slots: Path) -> None:
    found = windows()
    with pytest.raises(InputError, match="slot 3"):
        layout_slots.load(3, found)
    layout_slots.slot_path(1).parent.mkdir()
    layout_slots.slot_path(1).write_text("{", encoding="utf-8")
    assert "no saved layout" in layout_slots.run(("load", 1), found)
    assert [w.is_visible for w in found] == [True, True, False]
    layout_slots.slot_path(2).mkdir()
    with pytest.raises(OutputError):
        layout_slots.save(2, found)


def test_themes_are_told_apart_and_come_back() -> None:
    dark = {name: getattr(theme, name) for name in theme.THEMES["high-contrast"]}
    try:
        for name in THEMES:
            theme.use(name)
            assert contrast(theme.TEXT, theme.PANEL) > (15.0 if name == "high-contrast" else 10.0)
            assert contrast(theme.DIM, theme.PANEL) > (15.0 if name == "high-contrast" else 4.5)
        assert dark != theme.PANEL
    finally:
        theme.use("dark")
    assert {name: getattr(theme, name) for name in dark} == dark


def contrast(a: theme.Rgba, b: theme.Rgba) -> float:
    """Contrast ratio (WCAG 2.1) of two display colours."""
    from engine.math.color import luminance, srgb_to_linear

    low, high = sorted(float(luminance(srgb_to_linear(c[:3]))) for c in (a, b))
    return (high + 0.05) / (low + 0.05)


def test_preferences_keep_theme_and_workspace_and_refuse_nonsense(tmp_path: Path) -> None:
    path = tmp_path / "editor.json"
    save(Preferences(theme="high-contrast", workspace="Animate"), path)
    assert (load(path).theme, load(path).workspace) == ("high-contrast", "Animate")
    save(Preferences(theme="pink"), path)
    assert load(path).theme == "dark"
