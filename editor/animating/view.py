"""AnimatingView: what the animation panels and overlays show; view state, not part of the document."""

from __future__ import annotations

from dataclasses import dataclass, field

from editor.animating.time_scale import TimeScale


@dataclass(slots=True)
class AnimatingView:
    """`skeleton`, `names`, `axes`: over the picture. `ghosts`: that many poses before and after, `ghost_step` seconds
    apart; 0 none. `block`, `track`, `state`, `transition`, `mask`, `blend`: what is selected, -1 or "" none."""

    skeleton: bool = False
    names: bool = False
    axes: bool = False
    ghosts: int = 0
    ghost_step: float = 0.1
    root_path: bool = True
    snap: bool = True
    #: tracks | dope | curves
    page: str = "tracks"
    scale: TimeScale = field(default_factory=TimeScale)
    #: all of the time is in view; until the user zooms or moves along, it stays so
    fitted: bool = False
    zoomed: bool = False
    fitted_width: float = 0.0
    track: int = -1
    block: int = -1
    marker: int = -1
    channel: int = -1
    search: str = ""
    state: str = ""
    transition: int = -1
    mask: str = ""
    blend: str = ""
    #: how a clip that is added cross-fades with the block before it
    new_fade: float = 0.25
    new_curve: str = "smooth"
    new_sync: bool = False
    #: over how many bones a mask rises from a bone that is clicked, in the list or in the picture
    fall_off: int = 0
    #: a click in the viewport picks a bone for the mask
    picking_bone: bool = False
    #: (names of bones, search) of the mask panel
    bone_search: str = ""
