"""The check of a frame's numbers in the editor: whether it is on, what it found, going to a pixel. No imgui."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from editor.session import Session
from engine.report.number_check import NumberReport, NumberRow

VIEW = "nonfinite"


@dataclass(frozen=True, slots=True)
class PixelRequest:
    """Show this texel of a target of the frame: asked of the texture viewer."""

    resource: str
    x: int
    y: int
    layer: int = 0
    level: int = 0
    note: str = ""


def offered(session: Session) -> bool:
    """Whether this build's render settings know the check."""
    return any(p.name == "check_numbers" for p in session.settings.PARAMS)


def checking(session: Session) -> bool:
    """Whether each picture is checked: by the switch, or because the view that shows it is on."""
    settings: Any = session.settings
    return offered(session) and bool(settings.check_numbers or settings.view == VIEW)


def toggle(session: Session) -> None:
    settings: Any = session.settings
    if checking(session):
        settings.check_numbers = False
        if settings.view == VIEW:
            settings.view = "lit"
    else:
        settings.check_numbers = True
        session.ui.focus_panel = "Numbers"


def toggle_marks(session: Session) -> None:
    """Mark the pixels in the picture, or show it as it is and go on checking."""
    settings: Any = session.settings
    shown = settings.view == VIEW
    settings.view = "lit" if shown else VIEW
    settings.check_numbers = True


def report(session: Session) -> NumberReport | None:
    """What was found in the picture that is shown; None where it was not checked."""
    found = getattr(session.image.frame, "numbers", None)
    return found if isinstance(found, NumberReport) else None


def summary(found: NumberReport) -> str:
    """A few words for the status bar."""
    first = found.first
    if first is None:
        return "no NaN or Inf"
    return f"{found.bad_pixels:,} NaN/Inf, first in {first.pass_name}"


def go_to(session: Session, row: NumberRow) -> None:
    """Show the row's first pixel in the texture viewer, and select what lies under it in the picture."""
    if row.first is None:
        return
    x, y, layer = row.first
    plan = session.image.frame.graph.plan
    desc = plan.descs.get(row.resource)
    resource, note, level = row.resource, "", row.level
    why = ""
    if desc is None or desc.samples > 1 or desc.kind == "3d":
        why = "cannot be read (several samples a pixel)"
    if why:
        resource, level, layer = "color", 0, 0
        note = f"{row.resource} {why}: this is the finished picture"
    across, down = (x + 0.5) / row.width, (y + 0.5) / row.height
    if resource != row.resource:
        x, y = int(across * session.image.width), int(down * session.image.height)
    session.ui.show_pixel = PixelRequest(resource, x, y, layer, level, note)
    session.ui.focus_panel = "Textures"
    alike = abs(row.width / row.height - session.aspect) < 1.0 / row.height  # a part of the view, not a shadow map
    if alike and (desc is None or desc.kind == "2d"):
        node = session.pick(across, down)
        what = session.node_name(node)
        session.ui.notice = f"{what} lies under it" if what else "Nothing of the scene lies under it"
