"""The scene's surroundings as choices of one list: sky, studio, a colour, none, panoramas. No imgui.

What is chosen is an edit of the environment's table: one entry of the undo history, saved with the scene.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from editor.operations import Operation, Operations
from editor.requests import ChooseFile
from editor.session import Session

#: kind -> (label, what it is)
KINDS = {
    "studio": ("Studio", "Soft boxes in a grey room, shipped with Lucarna"),
    "sky": ("Sun and sky", "A clear sky by the sun's height; the sun casts shadows"),
    "uniform": ("One colour", "The same light from everywhere"),
    "none": ("None", "The scene's own lights alone"),
}
PANORAMAS = (".hdr", ".exr")
#: lux-like: a sun as bright as the sky's, where the environment had none
SUN = 1.2


def label(session: Session) -> str:
    """What lights the scene, in a word."""
    document = session.document
    if document is None:
        return ""
    environment = document.runtime.scene.environment
    if environment.kind == "image":
        name = str(Path(environment.path).name)
        return name.removesuffix(".dds").removesuffix(".env") or "Panorama"
    return KINDS.get(str(environment.kind), (str(environment.kind), ""))[0]


def choose(session: Session, kind: str) -> None:
    """Light the scene so."""
    document = session.document
    if document is None:
        return
    if kind == "sky" and document.runtime.scene.environment.sun_illuminance <= 0.0:
        columns, value = "kind,sun_illuminance", (kind, SUN)
        session.edit("environment", columns, (0,), (value,), label="Surroundings: sun and sky")
        return
    session.edit("environment", "kind", (0,), (kind,), label=f"Surroundings: {KINDS[kind][0].lower()}")


def open_panorama(session: Session) -> None:
    """Let the user choose a panorama."""
    document = session.document
    if document is None:
        return
    from editor.dropping import light_with

    start = document.project_root or document.source.parent
    session.ui.choose = ChooseFile("Light with a panorama", PANORAMAS, start, lambda path: light_with(session, path))


def add_surroundings_operations(ops: Operations) -> None:
    for i, (kind, (name, doc)) in enumerate(KINDS.items()):
        ops.add(
            Operation(
                f"surroundings.{kind}", f"Surroundings: {name.lower()}", _chooser(kind), "View", (), _has_document,
                _is(kind), i == 0, doc,
            )
        )  # fmt: skip
    ops.add(
        Operation(
            "surroundings.panorama", "Surroundings: panorama…", open_panorama, "View", (), _has_document, _is("image"),
            doc="An .hdr or .exr file; or drop one on the window",
        )
    )  # fmt: skip


def _has_document(session: Session) -> bool:
    return session.document is not None


def _chooser(kind: str) -> Callable[[Session], None]:
    return lambda session: choose(session, kind)


def _is(kind: str) -> Callable[[Session], bool]:
    return lambda s: s.document is not None and bool(s.document.runtime.scene.environment.kind == kind)
