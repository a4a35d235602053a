"""Workspaces, slots, themes."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("imgui_bundle")

from imgui_bundle import imgui

from editor import layout, layout_operations, layout_slots, theme
from editor.panels.registry import make_panels
from editor.preferences import Preferences, load, save
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


TEXTS = ("TEXT", "DIM", "FAINT", "ACCENT", "INFO", "WARNING", "ERROR", "GOOD")


@pytest.mark.parametrize(("name", "least"), [("dark", 4.5), ("high-contrast", 7.0)])
def test_text_is_read_on_what_it_stands_on(name: str, least: float) -> None:
    """WCAG 2.2: 4.5 for text (1.4.3, AA), 7 in the theme for low vision (1.4.6, AAA); bars and marks 3 (1.4.11)."""
    dark = {name: getattr(theme, name) for name in theme.THEMES["high-contrast"]}
    try:
        theme.use(name)
        for text in TEXTS:
            for ground in ("BACKGROUND", "PANEL", "POPUP", "RAISED", "FRAME"):
                assert contrast(getattr(theme, text), over(getattr(theme, ground))) >= least, (text, ground)
        own = TEXTS if name == "high-contrast" else ("TEXT",)
        for text in own:
            for ground in ("SELECTION", "SELECTION_HOVER", "FILL", "BUTTON"):
                assert contrast(getattr(theme, text), over(getattr(theme, ground))) >= least, (text, ground)
        for ground in ("FRAME_HOVER", "FRAME_ACTIVE", "BUTTON_HOVER", "BUTTON_ACTIVE", "FILL_ACTIVE"):
            assert contrast(theme.TEXT, over(getattr(theme, ground))) >= least, ground
        for color in (*theme.SERIES, *theme.AXES, theme.SLIDER):
            assert contrast(color, theme.PANEL) >= 3.0, color
        assert theme.high_contrast() == (name == "high-contrast")
    finally:
        theme.use("dark")
    assert {name: getattr(theme, name) for name in dark} == dark


def over(color: theme.Rgba) -> theme.Rgba:
    """A translucent ground as it is seen on a panel."""
    mixed = [c * color[3] + p * (1.0 - color[3]) for c, p in zip(color[:3], theme.PANEL[:3], strict=True)]
    return mixed[0], mixed[1], mixed[2], 1.0


def test_no_module_keeps_a_colour_of_one_theme() -> None:
    """Tables and default arguments are made once: a colour in them would stay the dark theme's."""
    kept = []
    for path in sorted(Path(theme.__file__).parent.rglob("*.py")):
        if path.name == "theme.py":
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        once: list[ast.AST] = [n for n in tree.body if isinstance(n, ast.Assign | ast.AnnAssign)]
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                once += [d for d in (*node.args.defaults, *node.args.kw_defaults) if d is not None]
            elif isinstance(node, ast.ClassDef):
                once += [n for n in node.body if isinstance(n, ast.Assign | ast.AnnAssign)]
        for part in once:
            for node in ast.walk(part):
                own = isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "theme"
                if own and isinstance(node, ast.Attribute) and node.attr in theme.THEMES["high-contrast"]:
                    kept.append(f"{path.name}:{node.lineno} theme.{node.attr}")
    assert not kept


def test_a_window_of_few_letters_has_two_columns() -> None:
    """Every panel has a place in both arrangements, and the tree does not stand in the inspector's."""
    panels = make_panels()
    assert layout.is_compact(1400, 30.0)
    assert not layout.is_compact(1400, 15.0)
    for workspace in layout.WORKSPACES:
        spaces = {"MainDockSpace", *(split[1] for split in layout.COMPACT_SPLITS)}
        places = {p.title: layout.dock_of(workspace, p, compact=True) for p in panels}
        assert set(places.values()) <= spaces
        assert places["Scene"] != places["Inspector"]
        assert {layout.dock_of(workspace, p, compact=False) for p in panels} <= set(layout.DOCKS)


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
