"""What becomes of files dropped on the window: models, scenes and folders open, each in a tab, or with Ctrl held are
placed in the scene in front; a panorama lights that. No imgui."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from editor import prefabs
from editor.thumbnail_maker import ENVIRONMENTS, sort_of

if TYPE_CHECKING:
    from editor.session import Session


def take(session: Session, paths: Sequence[Path], *, add: bool = False) -> None:
    """Open what can be opened, in the order given, or with `add` place models and scenes in the scene in front; what
    cannot be opened is told of in the log, each by name."""
    environments, openable, rest = sorted_out(session, paths)
    if add and session.document is not None:
        for path in [p for p in openable if not p.is_dir() and p.name != "project.toml"]:
            prefabs.place(session, path)
        openable = [p for p in openable if p.is_dir() or p.name == "project.toml"]
        if not (openable or environments or rest):
            return
    session.queue += [*openable, *environments[:1]]
    go_on(session)
    for path in environments[1:]:
        session.messages.info("Only the first of the dropped panoramas lights the scene", where=str(path))
    alone = not openable and not environments
    for path in rest:
        why = "belongs to a model, or goes into a slot of a material: drag it there from the assets panel"
        if alone:
            session.messages.warn(f"{path.name} was not opened: it {why}", where=str(path))
    if alone and rest:
        session.ui.notice = "Nothing there to open; the log says more"


def go_on(session: Session) -> None:
    """Open the next of what waits, once nothing else is being opened. A panorama lights the scene in front, if any."""
    while session.queue and session.job is None:
        path = session.queue.pop(0)
        if sort_of(path.name) == ENVIRONMENTS and session.document is not None:
            light_with(session, path)
        else:
            session.open(path)


def sorted_out(session: Session, paths: Sequence[Path]) -> tuple[list[Path], list[Path], list[Path]]:
    """(panoramas, what opens, the rest). Images beside a model are its textures and open nothing."""
    extensions = tuple(session.host.source_extensions())
    environments: list[Path] = []
    openable: list[Path] = []
    pictures: list[Path] = []
    rest: list[Path] = []
    for path in paths:
        lowered = path.name.lower()
        if sort_of(path.name) == ENVIRONMENTS:
            environments.append(path)
        elif path.is_dir() or lowered == "project.toml" or lowered.endswith(".scene.json"):
            openable.append(path)
        elif lowered.endswith(extensions):
            (pictures if sort_of(path.name) == "textures" else openable).append(path)
        else:
            rest.append(path)
    if openable or environments:
        return environments, openable, rest + pictures
    return environments, pictures, rest


def light_with(session: Session, path: Path) -> None:
    """Light the scene in front with the panorama at `path`: one entry of the undo history."""
    session.edit("environment", "kind,path", (0,), (("image", str(path.resolve())),), label=f"Light with {path.name}")
    session.ui.notice = f"Lit by {path.name}; Ctrl+Z takes it back"
