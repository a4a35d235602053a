"""What can be done to the materials of the selection, by name: menu, palette and keys."""

from __future__ import annotations

from editor import material_editing, object_editing
from editor.operations import Operation, Operations
from editor.session import Session


def selected_materials(session: Session) -> list[int]:
    document = session.document
    return material_editing.materials_of(document, document.selection) if document is not None else []


def _has(session: Session) -> bool:
    return bool(selected_materials(session))


def show_preview(session: Session) -> None:
    session.ui.focus_panel = "Material preview"


def copy(session: Session) -> None:
    material = selected_materials(session)[0]
    session.ui.copy_text = material_editing.copy_text(session, material)
    session.ui.notice = f"Copied {material_editing.label_of(session, [material])}"


def paste(session: Session) -> None:
    session.ui.paste = lambda text: material_editing.paste(session, selected_materials(session), text)


def reset(session: Session) -> None:
    material_editing.reset(session, selected_materials(session))


def only_object(session: Session) -> None:
    session.ui.only_object = not session.ui.only_object
    scope = "the selected objects alone" if session.ui.only_object else "the material, wherever it is"
    session.ui.notice = f"Edits of parameters are of {scope}"


def add_material_operations(ops: Operations) -> None:
    def add(id: str, label: str, run: object, about: str, *, needs: bool = True, separator: bool = False) -> None:
        assert callable(run)
        ops.add(Operation(
            id, label, run, "Shaders", (), _has if needs else (lambda session: session.document is not None),
            None, separator, about,
        ))  # fmt: skip

    add("material.preview", "Material preview", show_preview, "A material on a shape or a mesh of your own",
        needs=False, separator=True)  # fmt: skip
    add(
        "material.only_object",
        "Edit materials on this object only",
        only_object,
        "Parameters that are set from now on are those of the selected objects alone",
    )
    add("material.clear_object", "Let the object look as its material says", object_editing.clear,
        "Take away what the selected objects say themselves")  # fmt: skip
    add("material.copy", "Copy the selected material", copy, "As text of a material file")
    add("material.paste", "Paste to the selected materials", paste, "A material or a parameter from the clipboard")
    add("material.reset", "Reset the selected materials", reset, "All their parameters back to the defaults")
