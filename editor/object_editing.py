"""Parameters of materials on one object alone: what the selected objects say themselves, edits of that. No imgui.

overridden on the object?  yes, or `only_object` is on ──► table "objects", column SLOT:PARAMETER (None: not any more)
                           no ──► the material, as everywhere (material_editing)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from editor.document import Document
from editor.material_editing import label_of, set_param
from editor.tables import plain

if TYPE_CHECKING:
    from editor.session import Session

#: an object and a slot of its mesh
Holder = tuple[int, int]


def holders(document: Document, materials: Sequence[int]) -> list[Holder]:
    """The selected objects, and their slots, that have one of these materials, varied or not."""
    objects = getattr(document.runtime, "objects", None)
    if objects is None:
        return []
    wanted = set(materials)
    return [(row, s) for row in document.selection for s, m in objects.slots(row).items() if m in wanted]


def own_values(document: Document, held: Sequence[Holder]) -> dict[str, tuple[Any, ...]]:
    """Parameter -> what each holder says itself (None: nothing), of those that one of them says."""
    said = [document.runtime.objects.values(row, slot) for row, slot in held]  # type: ignore[attr-defined]  # see holders
    names = dict.fromkeys(name for values in said for name in values)
    return {name: tuple(plain(values.get(name)) for values in said) for name in names}


def set_value(session: Session, materials: Sequence[int], held: Sequence[Holder], name: str, value: Any) -> None:
    """A parameter of the selected objects: on them alone where they say it themselves or the user wants it so, else of
    their materials. What a drag sets is one entry. None: as the material says again."""
    document = session.document
    if document is None:
        return
    own = own_values(document, held)
    if not held or (name not in own and not session.ui.only_object):
        set_param(session, materials, name, value)
        return
    for slot in dict.fromkeys(slot for _, slot in held):
        rows = [row for row, s in held if s == slot]
        names = document.runtime.scene.nodes.name
        whose = names[rows[0]] if len(rows) == 1 else f"{len(rows)} objects"
        label = f"{label_of(session, materials, name)} on {whose}"
        key = ("objects", slot, name, tuple(rows))
        session.edit("objects", f"{slot}:{name}", rows, [value] * len(rows), gesture=key, label=label)


def clear(session: Session, names: Sequence[str] = ()) -> None:
    """The selected objects look as their materials say: in `names`, or in all."""
    document = session.document
    if document is None or not hasattr(document.runtime, "objects"):
        return
    materials = [m for row in document.selection for m in document.runtime.objects.slots(row).values()]
    held = holders(document, materials)
    for slot in dict.fromkeys(slot for _, slot in held):
        rows = [row for row, s in held if s == slot]
        said = own_values(document, [(row, slot) for row in rows])
        for name in said:
            if not names or name in names:
                label = f"{name.replace('_', ' ').capitalize()} as the material says"
                session.edit("objects", f"{slot}:{name}", rows, [None] * len(rows), label=label)


def has_own(session: Session) -> bool:
    """Whether a selected object says something itself."""
    document = session.document
    if document is None or not hasattr(document.runtime, "objects"):
        return False
    objects = document.runtime.objects
    return any(objects.values(row, slot) for row in document.selection for slot in objects.slots(row))
