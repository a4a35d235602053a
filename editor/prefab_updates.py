"""Instances and their prefabs brought together: reverted, applied, up to date when a prefab's file changes. Each is one
undoable entry. No imgui."""

from __future__ import annotations

import functools
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from editor import replacing, saving
from editor.commands.replacement import settled
from editor.prefab_values import REMOVED, changes, nothing_own
from editor.prefabs import index_of, path_of, root_of
from engine.assets.clip_nodes import clip_number
from engine.assets.prefab import FIELDS, NODE, ROOT, file_of, instance_nodes, keys_of, map_files, members
from engine.assets.scene import SceneAsset
from engine.assets.scene_json import format_scene, read_scene, write_scene
from engine.core.errors import InputError, LucarnaError
from engine.core.paths import user_cache_dir

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session

#: seconds between two looks at the files of prefabs
LOOK = 0.5


#: (node, by its key in the prefab; field of it, or prefab_values.REMOVED)
Value = tuple[str, str]


def revert(session: Session, only: Value | None = None) -> bool:
    """Give the selected instance back what its prefab says, but for its own place; `only` that value of it."""
    found = _selected(session)
    if found is None:
        return False
    document, row, path = found
    asset = saving.current_scene(document)
    _say(asset, index_of(document, row), *_without(*changes(document, row), only))
    return _reopen(session, document, asset, f"Revert {path.name}" + (f": {only[0]}, {only[1]}" if only else ""))


def apply(session: Session, only: Value | None = None) -> bool:
    """Write what the selected instance has of its own into its prefab, or `only` that value; all other instances
    follow."""
    found = _selected(session)
    if found is None:
        return False
    document, row, path = found
    all_changed, all_removed = changes(document, row)
    kept, kept_removed = _without(all_changed, all_removed, only)
    changed = {k: [f for f in v if f not in kept.get(k, ())] for k, v in all_changed.items()}
    changed, removed = {k: v for k, v in changed.items() if v}, [k for k in all_removed if k not in kept_removed]
    if not changed and not removed:
        session.ui.notice = nothing_own(*only) if only else "This instance has nothing of its own"
        return only is None
    try:
        before = path.read_text("utf-8")
        prefab = read_scene(path)
        asset = saving.current_scene(document)
        index = index_of(document, row)
        mine = {str(asset.nodes[i].extras[NODE]): asset.nodes[i] for i in members(asset, index)}
        folder = document.scene_path.resolve().parent
        keys = keys_of(prefab.nodes)
        for number, key in enumerate(keys):
            if key in changed:
                own = map_files(mine[key], lambda text: saving.moved_reference(text, folder, path.parent))
                values = {n: getattr(own, n) for field in changed[key] for n in FIELDS[field]}
                prefab.nodes[number] = replace(prefab.nodes[number], **values)
        unknown = sorted(set(changed) - set(keys))
        renamed = {old: new for old, new in zip(keys, keys_of(prefab.nodes), strict=True) if old != new}
        prefab = without(prefab, [i for i, key in enumerate(keys) if key in removed])
        after = format_scene(prefab, str(path))
    except (LucarnaError, OSError) as error:
        session.fail(error if isinstance(error, LucarnaError) else InputError(str(error), where=path))
        return False
    if unknown:
        session.messages.warn(
            f"Of prefabs within the prefab nothing was applied: {', '.join(unknown)}", where=str(path)
        )
    for key in unknown:
        kept[key] = all_changed[key]
    _say(asset, index, kept, kept_removed)
    _rename_keys(asset, path, folder, renamed)
    steps = settled(after, path), settled(before, path)
    label = f"Apply to {path.name}" + (f": {only[0]}, {only[1]}" if only else "")
    return _reopen(session, document, asset, label, steps)


def _without(
    changed: dict[str, list[str]], removed: list[str], only: Value | None
) -> tuple[dict[str, list[str]], list[str]]:
    """What stays the instance's own when `only` that value is not any more; without it nothing does."""
    if only is None:
        return {}, []
    node, field = only
    if field == REMOVED:
        return changed, [key for key in removed if key != node]
    left = {key: [f for f in own if (key, f) != only] for key, own in changed.items()}
    return {key: own for key, own in left.items() if own}, removed


def _rename_keys(asset: SceneAsset, path: Path, folder: Path, renamed: dict[str, str]) -> None:
    """Let the instances of `path` know its nodes by their new names, so that they keep what is their own."""
    for root, node in enumerate(asset.nodes) if renamed else ():
        if not file_of(node) or NODE in node.extras or (folder / file_of(node)).resolve() != path.resolve():
            continue
        for i in members(asset, root):
            key = str(asset.nodes[i].extras[NODE])
            asset.nodes[i] = replace(asset.nodes[i], extras={**asset.nodes[i].extras, NODE: renamed.get(key, key)})
        said: Any = node.extras[ROOT]
        changed = {renamed.get(key, key): own for key, own in (said.get("changed") or {}).items()}
        _say(asset, root, changed, [renamed.get(key, key) for key in said.get("removed") or ()])


def _say(asset: SceneAsset, index: int, changed: dict[str, list[str]], removed: list[str]) -> None:
    """Write down what the instance at node `index` has of its own."""
    said: Any = asset.nodes[index].extras[ROOT]
    extras = {**asset.nodes[index].extras, ROOT: {**said, "changed": changed, "removed": removed}}
    asset.nodes[index] = replace(asset.nodes[index], extras=extras)


def without(asset: SceneAsset, lost: Sequence[int]) -> SceneAsset:
    """`asset` without the nodes `lost` and what is below them."""
    gone = set(lost)
    for index, node in enumerate(asset.nodes):
        if node.parent in gone:
            gone.add(index)
    order = [i for i in range(len(asset.nodes)) if i not in gone]
    number = {old: new for new, old in enumerate(order)}
    nodes = [
        replace(
            n, parent=number.get(n.parent, -1), joints=[number[j] for j in n.joints if j in number],
            clip_node=clip_number(n, old) if asset.clips and number[old] != old else n.clip_node,
        )
        for old, n in ((i, asset.nodes[i]) for i in order)
    ]  # fmt: skip
    return replace(asset, nodes=nodes, active_camera=number.get(asset.active_camera, -1))


def _selected(session: Session) -> tuple[Document, int, Path] | None:
    document = session.document
    row = root_of(document, document.primary) if document is not None and document.primary >= 0 else -1
    path = path_of(document, row) if document is not None and row >= 0 else None
    if document is None or path is None:
        session.ui.notice = "Select an instance of a prefab"
        return None
    return document, row, path


def poll(session: Session) -> None:
    """Once a frame: bring the document in front up to date with prefabs whose files changed."""
    from editor.reimporting import stamp_of

    document, now = session.document, time.monotonic()
    if document is None or not document.prefabs or now < session.prefabs_at or session.handling:
        return
    session.prefabs_at = now + LOOK
    stamps = {path: (stamp_of(path), *map(stamp_of, _clips_of(path, stamp_of(path)))) for path in document.prefabs}
    before = document.prefab_stamps
    if stamps == before:
        return
    document.prefab_stamps = stamps
    changed = []
    for path in document.prefabs:
        other_clips = path in before and stamps[path][1:] != before[path][1:]
        try:
            if other_clips or instance_nodes(path, document.scene_path.parent) != document.prefabs[path]:
                changed.append(path)
        except LucarnaError as error:
            if str(error) not in document.noted:
                document.noted.add(str(error))
                session.messages.error(error)
    if changed:
        names = ", ".join(p.name for p in changed)
        _reopen(
            session, document, saving.current_scene(document), f"Prefab {names} changed", of_view=not document.dirty
        )


def files_of(document: Document) -> Iterator[Path]:
    """What `poll` looks at: the prefabs, and what they play."""
    from editor.reimporting import stamp_of

    for path in document.prefabs:
        yield path
        yield from _clips_of(path, stamp_of(path))


@functools.lru_cache(maxsize=64)
def _clips_of(path: Path, _stamp: object) -> tuple[Path, ...]:
    """The clips and the animation file of a prefab, read again when it changes."""
    try:
        asset = read_scene(path)
        return tuple(path.parent / name for name in (*asset.clips, asset.animation) if name)
    except LucarnaError:  # told of by whoever needs its nodes
        return ()


def _reopen(
    session: Session, document: Document, asset: SceneAsset, label: str,
    steps: tuple[Callable[[], None], Callable[[], None]] | None = None, *, of_view: bool = False,
) -> bool:  # fmt: skip
    """Open `asset`, the document as it shall be, in its place; the instances in it come up to date as it is read."""
    from editor.reimporting import last_import, once, origin_of
    from importers.reimport.merging import rebased
    from importers.reimport.record import Imported, write_record

    root = user_cache_dir() / "merged"
    folder = document.scene_path.resolve().parent
    out: Path | None = None
    try:
        root.mkdir(parents=True, exist_ok=True)
        out = Path(tempfile.mkdtemp(dir=root))
        scene = out / document.scene_path.name
        write_scene(scene, rebased(asset, folder, out, known=set()))
        last = last_import(document)
        if last is not None:
            keys = origin_of(document, last)
            write_record(scene, Imported(last.source, last.digest, last.scene, last.materials, keys, last.orphans))
        if steps is not None:
            steps[0]()
        try:
            saved_to = document.saved_to
            if saved_to is None and not folder.is_relative_to(user_cache_dir().resolve()):
                saved_to = document.scene_path
            replacing.replace_scene(
                session, document, scene, label, findings=document.findings, of_view=of_view, saved_to=saved_to,
                steps=once(steps) if steps is not None else (_nothing, _nothing),
                materials=replacing.unsaved_materials(document),
            )  # fmt: skip
        except LucarnaError:
            if steps is not None:
                steps[1]()
            raise
    except (LucarnaError, OSError) as error:
        if out is not None:
            shutil.rmtree(out, ignore_errors=True)
        session.fail(error if isinstance(error, LucarnaError) else InputError(str(error), where=root))
        return False
    session.ui.notice = label
    return True


def _nothing() -> None:
    pass
