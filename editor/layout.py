"""Where the panels stand at first, and where their places are kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from imgui_bundle import hello_imgui, imgui

from editor.panels.base import Panel

#: (space to split, new space, side, share of it)
SPLITS = (
    ("MainDockSpace", "Right", imgui.Dir.right, 0.245),
    ("MainDockSpace", "Left", imgui.Dir.left, 0.21),
    ("Left", "LeftBottom", imgui.Dir.down, 0.42),
    ("MainDockSpace", "Bottom", imgui.Dir.down, 0.27),
    ("Bottom", "BottomRight", imgui.Dir.right, 0.46),
    ("MainDockSpace", "Code", imgui.Dir.right, 0.5),
)
DOCKS = ("MainDockSpace", *(split[1] for split in SPLITS))


def docking_params(panels: Sequence[Panel], draw: Callable[[Panel], Callable[[], None]]) -> hello_imgui.DockingParams:
    """The default layout with `draw(panel)` as each window's content."""
    params = hello_imgui.DockingParams()
    params.docking_splits = [hello_imgui.DockingSplit(*split) for split in SPLITS]
    windows = []
    for panel in panels:
        assert panel.dock in DOCKS, f"{panel.title}: no dock {panel.dock}"
        window = hello_imgui.DockableWindow(panel.label, panel.dock, draw(panel), panel.opened, panel.closable)
        window.include_in_view_menu = False
        window.call_begin_end = panel.padded
        windows.append(window)
    params.dockable_windows = windows
    params.main_dock_space_node_flags = imgui.DockNodeFlags_.none
    return params
