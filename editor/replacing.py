"""Replacing the scene under a document as one undoable entry, and what of the session must follow. No imgui."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from editor.bookmark_table import BOOKMARKS, COLUMN, BookmarkTable, of_asset, to_plain
from editor.commands.command import VIEW_TABLE, Edit
from editor.commands.replacement import LIMIT, Replacement, Standing, standing
from editor.tables import SettingsTable, tables_of
from engine.core.errors import LucarnaError
from engine.core.findings import Findings

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session


def watch(session: Session, document: Document) -> None:
    """Let the session follow when the scene under `document` becomes another one."""
    document.on_replaced = lambda: follow(session, document)
    document.history.on_dropped = lambda edits: release(session, document, edits)
    set_view_table(session, document)


def set_view_table(session: Session, document: Document) -> None:
    document.tables[VIEW_TABLE] = SettingsTable(lambda: session.settings)


def replace_scene(
    session: Session,
    document: Document,
    scene: Path,
    label: str,
    *,
    findings: Findings | None = None,
    of_view: bool = False,
    steps: tuple[Callable[[], None], Callable[[], None]] = (lambda: None, lambda: None),
    materials: Mapping[Path, Mapping[str, Any]] | None = None,
    **more: Any,
) -> None:
    """Put the scene file `scene` under `document` (in front): one entry. The selection stays where names stay.

    `materials`: file -> {column: value}: unsaved values that it begins with. `more`: other fields of Standing.
    Raises LucarnaError when it cannot be opened or a step fails; then nothing has changed."""
    from editor.session import shader_root

    with session.device_frame():
        runtime = session.host.open_runtime(session.device, scene, shader_root(document))
    try:
        values = {
            "source": document.source, "scene_path": scene, "base_path": None, "findings": findings or Findings(),
            "runtime": runtime, "tables": tables_of(runtime), "overrides": {}, "isolated": None, "locked": set(),
            "saved_to": document.saved_to, "selection": (), "name": document.name,
            "imported_from": document.imported_from, "news": document.news, **more,
        }  # fmt: skip
        values["prefabs"] = prefabs_of(runtime, scene)
        _carry(values, runtime, materials or {})
        _carry_bookmarks(values, document.bookmarks)
        values["selection"] = _same_names(document, runtime, document.selection)
        values["locked"] = set(_same_names(document, runtime, sorted(document.locked)))
        edit = Replacement(standing(document), Standing(values), label, of_view, steps)
        session.end_gesture()
        document.history.do(edit)
    except BaseException:  # an interrupt, too, leaves nothing behind
        if document.runtime is not runtime:
            with session.device_frame():
                runtime.close()
        raise
    found = [i for i, e in enumerate(document.history.entries) if isinstance(e, Replacement)]
    if len(found) > LIMIT:
        release(session, document, document.history.forget(found[-LIMIT - 1] + 1))


def unsaved_materials(document: Document) -> dict[Path, dict[str, Any]]:
    """The materials' values that are not in their files, by file."""
    found: dict[Path, dict[str, Any]] = {}
    for (table, column, row), value in document.overrides.items():
        path = document.runtime.residency.material(row).path if table == "materials" else ""
        if path:
            found.setdefault(Path(path).resolve(), {})[column] = value
    return found


def _carry(values: dict[str, Any], runtime: Any, materials: Mapping[Path, Mapping[str, Any]]) -> None:
    for path, columns in materials.items():
        if path in runtime.residency.material_files:
            row = int(runtime.residency.material_files[path])
            for column, value in columns.items():
                values["tables"]["materials"].write(column, (row,), (value,))
                values["overrides"]["materials", column, row] = value


def _carry_bookmarks(values: dict[str, Any], bookmarks: Mapping[int, Any]) -> None:
    """Those of the new scene, and of the old one those that it lacks."""
    cameras = of_asset(values["runtime"].asset)
    for number, camera in bookmarks.items():
        if number not in cameras:
            cameras[number] = camera
            values["overrides"][BOOKMARKS, COLUMN, number] = to_plain(camera)
    values["bookmarks"] = cameras
    values["tables"][BOOKMARKS] = BookmarkTable(cameras)


def prefabs_of(runtime: Any, scene: Path) -> dict[Path, list[Any]]:
    """The prefabs that the open scene at `scene` has instances of; those that cannot be read are left out."""
    from engine.assets.prefab import file_of, instance_nodes, prefab_files

    found: dict[Path, list[Any]] = {}
    if any(file_of(node) for node in runtime.asset.nodes):
        for path in prefab_files(runtime.asset, scene.parent):
            with contextlib.suppress(LucarnaError):
                found[path] = instance_nodes(path, scene.parent)
    return found


def follow(session: Session, document: Document) -> None:
    """The scene under `document` is another one now."""
    set_view_table(session, document)
    if session.document is not document or document.history.visited:
        return
    session.image.forget()
    with session.device_frame():
        session.thumbnails.forget()
        session.preview.forget()
    session.comparing.forget(session)
    session.forced_cost = session.feature_effects = None
    session.followed, session.drawing_noted = None, (None, None)
    session.playback.set_duration(float(document.runtime.duration))
    session.tools.points.clear()
    session.ui.rename, session.ui.pick_list = -1, ()
    document.runtime.scene.update()


def release(session: Session, document: Document, edits: list[Edit]) -> None:
    """Close the runtimes that only `edits`, now forgotten, would have brought back."""
    kept = {id(document.runtime)}
    for edit in (*document.history.entries, *document.history.undone):
        if isinstance(edit, Replacement):
            kept.update(id(r) for r in edit.runtimes)
    gone = {id(r): r for edit in edits if isinstance(edit, Replacement) for r in edit.runtimes}
    closing = [runtime for key, runtime in gone.items() if key not in kept]
    if closing:
        with session.device_frame():
            for runtime in closing:
                runtime.close()


def _same_names(document: Document, runtime: Any, rows: Any) -> tuple[int, ...]:
    """The rows of `runtime` whose paths of names are those of `rows` in the document as it stands."""
    if not rows:
        return ()
    present = document.runtime.scene.nodes
    wanted = {path_of(present, row) for row in rows if row < len(present) and present.alive[row]}  # locked, then undone
    nodes = runtime.scene.nodes
    alive = [row for row in range(len(nodes.name)) if nodes.alive[row]]
    return tuple(row for row in alive if path_of(nodes, row) in wanted)


def path_of(nodes: Any, row: int) -> str:
    """`stage/lamp`: the names from the top of the tree down to `row`."""
    names = []
    while row >= 0:
        names.append(str(nodes.name[row]))
        row = int(nodes.parent[row])
    return "/".join(reversed(names))
