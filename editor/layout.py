"""Where the panels stand: workspaces to switch between, each remembered as the user arranges it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from imgui_bundle import hello_imgui, imgui

from editor.panels.base import Panel

Split = tuple[str, str, imgui.Dir, float]

#: (space to split, new space, side, share of it)
SPLITS: tuple[Split, ...] = (
    ("MainDockSpace", "Right", imgui.Dir.right, 0.245),
    ("MainDockSpace", "Left", imgui.Dir.left, 0.21),
    ("Left", "LeftBottom", imgui.Dir.down, 0.42),
    ("MainDockSpace", "Bottom", imgui.Dir.down, 0.27),
    ("Bottom", "BottomRight", imgui.Dir.right, 0.46),
    ("MainDockSpace", "Code", imgui.Dir.right, 0.5),
)
DOCKS = ("MainDockSpace", *(split[1] for split in SPLITS))

#: a window narrower than this, em, has two columns instead of three: on a small screen, or with a large interface
COMPACT_BELOW = 64.0
#: where panels stand then, and the spaces for it: tree above inspector, and one row below the picture
COMPACT_DOCKS = {"Left": "Right", "LeftBottom": "Right", "Right": "RightBottom", "BottomRight": "Bottom"}
COMPACT_SPLITS: tuple[Split, ...] = (
    ("MainDockSpace", "Right", imgui.Dir.right, 0.38),
    ("Right", "RightBottom", imgui.Dir.down, 0.58),
    ("MainDockSpace", "Bottom", imgui.Dir.down, 0.34),
    ("MainDockSpace", "Code", imgui.Dir.right, 0.5),
)


@dataclass(frozen=True, slots=True)
class Workspace:
    """`docks`: panels that stand elsewhere than they say; `shown`, `hidden`: others than those open at first; `front`:
    the panels whose tabs are in front."""

    name: str
    doc: str
    splits: tuple[Split, ...] = SPLITS
    docks: Mapping[str, str] = field(default_factory=dict)
    shown: tuple[str, ...] = ()
    hidden: tuple[str, ...] = ()
    front: tuple[str, ...] = ()

    def opens(self, panel: Panel) -> bool:
        return panel.title in self.shown or (panel.opened and panel.title not in self.hidden)


def _shares(**shares: float) -> tuple[Split, ...]:
    """SPLITS with other shares of the new spaces."""
    return tuple((space, new, side, shares.get(new, share)) for space, new, side, share in SPLITS)


WORKSPACES = (
    Workspace("Edit", "Tree, viewport, inspector, log"),
    Workspace(
        "Animate", "A timeline over half the window; blending, states and masks beside it",
        _shares(Bottom=0.5, BottomRight=0.36, Left=0.17, LeftBottom=0.3, Right=0.22),
        shown=("Blend space", "State graph", "Masks"), hidden=("Variants", "Console"),
        front=("Timeline", "Blend space"),
    ),
    Workspace(
        "Shade", "The shader editor beside the picture, the material preview below",
        _shares(Left=0.16, Bottom=0.3, Right=0.22), shown=("Shader editor",),
        front=("Shader editor", "Material preview"),
    ),
    Workspace(
        "Review", "The picture large: comparing, timings, frame graph",
        _shares(Left=0.13, Right=0.2, Bottom=0.22, BottomRight=0.55), shown=("Compare",), front=("Compare", "Log"),
    ),
)  # fmt: skip


def docking_params(
    panels: Sequence[Panel], draw: Callable[[Panel], Callable[[], None]], workspace: Workspace = WORKSPACES[0],
    *, compact: bool = False,
) -> hello_imgui.DockingParams:  # fmt: skip
    """A workspace with `draw(panel)` as each window's content; `compact` as arrange has it."""
    params = hello_imgui.DockingParams()
    params.layout_name = workspace.name
    params.docking_splits = splits(workspace, compact=compact)
    windows = []
    for panel in panels:
        dock = dock_of(workspace, panel, compact=compact)
        window = hello_imgui.DockableWindow(panel.label, dock, draw(panel), workspace.opens(panel), panel.closable)
        window.include_in_view_menu = False
        window.call_begin_end = panel.padded
        windows.append(window)
    params.dockable_windows = windows
    params.main_dock_space_node_flags = imgui.DockNodeFlags_.none
    return params


def splits(workspace: Workspace, *, compact: bool) -> list[hello_imgui.DockingSplit]:
    """What cuts the window into spaces."""
    return [hello_imgui.DockingSplit(*split) for split in (COMPACT_SPLITS if compact else workspace.splits)]


def dock_of(workspace: Workspace, panel: Panel, *, compact: bool) -> str:
    """The space that a panel stands in."""
    dock = workspace.docks.get(panel.title, panel.dock)
    assert dock in DOCKS, f"{panel.title}: no dock {dock}"
    return COMPACT_DOCKS.get(dock, dock) if compact else dock


def arrange(params: hello_imgui.DockingParams, panels: Sequence[Panel], workspace: Workspace, *, compact: bool) -> None:
    """Every panel of the workspace back to its place, in the next frame."""
    params.docking_splits = splits(workspace, compact=compact)
    for panel, window in zip(panels, params.dockable_windows, strict=True):
        window.is_visible = workspace.opens(panel)
        window.dock_space_name = dock_of(workspace, panel, compact=compact)
    params.layout_reset = True


def is_compact(width: float, font: float) -> bool:
    """Whether a window `width` wide, its letters `font` high in the same unit, has no room for three columns."""
    return width < COMPACT_BELOW * font


def named(name: str) -> Workspace:
    """The workspace of that name; the first where there is none (a file of another version)."""
    return next((w for w in WORKSPACES if w.name == name), WORKSPACES[0])
