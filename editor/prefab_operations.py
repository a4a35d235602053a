"""Operations on prefabs: make, place, open, revert, apply, all of it or value by value."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from editor import prefab_updates, prefab_values, prefabs
from editor.arguments import Argument
from editor.operations import Operation, Operations
from editor.prefabs import is_instance
from editor.requests import ChooseFile
from editor.session import Session
from engine.assets.prefab import FIELDS


def add_prefab_operations(ops: Operations) -> None:
    """Add them all to the registry."""

    def add(id: str, label: str, run: Callable[..., None], *keys: str, menu: str = "Edit", about: str,
            enabled: Callable[[Session], bool], first: bool = False) -> None:  # fmt: skip
        ops.add(Operation(id, label, run, menu, keys, enabled, None, first, about))

    add("prefab.make", "Make a prefab of the selection", lambda s: void(prefabs.make(s)), enabled=_has_selection,
        first=True, about="A file of its own in prefabs/, and an instance of it in the selection's place")  # fmt: skip
    add("prefab.revert", "Revert the instance to its prefab", _revert, enabled=is_instance,
        about="All that it has of its own goes, but for its place")  # fmt: skip
    add("prefab.apply", "Apply the instance to its prefab", _apply, enabled=is_instance,
        about="What it has of its own becomes the prefab's, and all instances follow")  # fmt: skip
    add("prefab.open", "Open the prefab of the instance", _open, enabled=is_instance,
        about="In a tab of its own; saving it changes all instances")  # fmt: skip
    add("prefab.choose", "Instance of a prefab or model…", _choose, menu="Add", enabled=_has_document, first=True,
        about="Files dragged from the assets into the viewport are placed, too")  # fmt: skip
    value = (
        Argument("node", "text", doc="as the prefab knows it: the names from its top down"),
        Argument("field", "enum", choices=(*FIELDS, prefab_values.REMOVED)),
    )
    ops.add(
        Operation(
            "prefab.revert-value", "Revert a value to the prefab", _revert_value, enabled=is_instance, arguments=value,
            sample=_sample, doc="One of those that the inspector lists; a removed node comes back",
        )
    )  # fmt: skip
    ops.add(
        Operation(
            "prefab.apply-value", "Apply a value to the prefab", _apply_value, enabled=is_instance, arguments=value,
            sample=_sample, doc="One of those that the inspector lists, and all instances follow",
        )
    )  # fmt: skip
    ops.add(
        Operation(
            "prefab.place", "Place a prefab or model", _place, enabled=_has_document,
            arguments=(
                Argument("path", "path", doc="a scene or a source"),
                Argument("at", "vec3", (0.0, 0.0, 0.0), unit="m"),
            ),
            doc="An instance of it, where it is said",
        )
    )  # fmt: skip


def _revert(session: Session) -> None:
    prefab_updates.revert(session)


def _apply(session: Session) -> None:
    prefab_updates.apply(session)


def _revert_value(session: Session, node: str, field: str) -> None:
    prefab_values.revert_value(session, node, field)


def _apply_value(session: Session, node: str, field: str) -> None:
    prefab_updates.apply(session, (node, field))


def _sample(session: Session, dice: random.Random) -> dict[str, Any]:
    assert session.document is not None
    own = prefab_values.own_values(session.document, prefab_values.selected_root(session))
    value = dice.choice(own) if own else None
    return {"node": value.node, "field": value.field} if value else {"node": "nobody", "field": "name"}


def _place(session: Session, path: Path, at: tuple[float, float, float]) -> None:
    matrix = np.eye(4)
    matrix[:3, 3] = at
    prefabs.place(session, path, matrix)


def _choose(session: Session) -> None:
    document = session.document
    if document is None:
        return
    endings = (".scene.json", *session.host.source_extensions())
    start = document.source if document.source.is_dir() else document.source.parent
    session.ui.choose = ChooseFile("Place an instance", endings, start, lambda path: void(prefabs.place(session, path)))


def _open(session: Session) -> None:
    document = session.document
    if document is not None:
        path = prefabs.path_of(document, prefabs.root_of(document, document.primary))
        if path is not None:
            session.open(path)


def void(_value: object) -> None:
    """Drop a result."""


def _has_document(session: Session) -> bool:
    return session.document is not None


def _has_selection(session: Session) -> bool:
    return session.document is not None and bool(session.document.selection)
