"""Where a message of the log leads: the file that it names, and the place in it. No imgui."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from editor.session import Session
from editor.thumbnail_maker import TEXTURES, sort_of

TEXTS = (
    ".toml",
    ".glsl",
    ".vert",
    ".frag",
    ".comp",
    ".geom",
    ".tesc",
    ".tese",
    ".json",
    ".md",
    ".txt",
    ".py",
    ".import",
)
_PLACE = re.compile(r"^(?P<file>.+?)(?::(?P<line>\d+))?(?::(?P<column>\d+))?(?:: .*)?$")


@dataclass(frozen=True, slots=True)
class Link:
    """`kind`: text, texture or node; `node`: its row."""

    kind: str
    path: Path = Path()
    line: int = 0
    column: int = 0
    node: int = -1


def link_of(where: str, session: Session) -> Link | None:
    """What a click on the place of a message shows: a text at its line, a picture, a node of the scene; None where
    there is nothing to show."""
    found = _PLACE.match(where)
    if found is None:
        return None
    path = Path(found["file"])
    document = session.document
    if not path.is_absolute() and document is not None:
        roots = [r for r in (document.project_root, document.source.parent) if r is not None]
        path = next((r / path for r in roots if (r / path).is_file()), path)
    if path.is_absolute() and path.is_file():
        if path.name.lower().endswith(TEXTS):
            return Link("text", path, int(found["line"] or 0), int(found["column"] or 0))
        return Link("texture", path) if sort_of(path.name) == TEXTURES else None
    index = re.search(r"nodes\[(\d+)\]", where)
    if index is not None and document is not None:
        nodes = document.runtime.scene.nodes
        row = int(index[1])
        if row < len(nodes.name) and nodes.alive[row]:
            return Link("node", node=row)
    return None


def follow(link: Link, session: Session) -> None:
    """Show what it leads to."""
    if link.kind == "text":
        session.open_code(link.path, link.line, link.column)
    elif link.kind == "texture":
        session.ui.show_texture, session.ui.focus_panel = link.path, "Textures"
    elif session.document is not None:
        session.document.select(link.node)
