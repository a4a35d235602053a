"""Saving: the scene as it was opened plus what the user changed, as files that stand by themselves.

A scene that came from the import cache is written with a copy of everything it refers to: the cache may be emptied at
any time. A scene that lies where it is saved is updated in place, its edited materials too.
"""

from __future__ import annotations

import contextlib
import copy
import filecmp
import os
import shutil
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from editor.bookmark_table import BOOKMARKS, save_to
from editor.commands.lights import DRIFTS
from editor.document import Document
from editor.material_editing import parent_values
from editor.opening import scene_stem
from editor.tables import FEATURES, QUEUE, TEXTURE, object_column, texture_from_plain
from engine.assets.clip import ClipAsset
from engine.assets.material import TextureRef
from engine.assets.scene import NodeAsset, SceneAsset
from engine.core.atomic import atomic_path, write_text
from engine.core.errors import LucarnaError, OutputError
from engine.core.paths import user_cache_dir


def default_target(document: Document) -> Path | None:
    """Where Ctrl+S writes, or None where the user must be asked (a loose source file)."""
    if document.saved_to is not None:
        return document.saved_to
    cached = document.scene_path.resolve().is_relative_to(user_cache_dir().resolve())
    if not cached:
        return document.scene_path
    if document.project_root is not None:
        return document.project_root / "scenes" / f"{scene_stem(document.scene_path)}.scene.json"
    return None


def suggested_target(document: Document) -> Path:
    """What a "save as" begins with: beside the source."""
    target = default_target(document)
    if target is not None:
        return target
    folder = document.source if document.source.is_dir() else document.source.parent
    return folder / f"{scene_stem(document.scene_path)}.scene.json"


def save_document(document: Document, target: Path) -> list[Path]:
    """Write the scene to `target` and what belongs to it beside it; returns the files written.

    Raises OutputError when something cannot be written. The scene file is written last, so a failure never leaves a
    scene that names missing files."""
    from engine.assets.lanim import write_lanim
    from engine.assets.material_toml import update_material
    from engine.assets.scene_json import write_scene

    target = target.resolve()
    source_dir, target_dir = document.scene_path.resolve().parent, target.parent
    asset = current_scene(document)
    said = said_and_saved(document)
    edited = edited_materials(document.runtime.residency, said)
    written: list[Path] = []
    written += _carry_profiles(asset, target_dir)
    if source_dir != target_dir:
        asset = _reached_from(asset, source_dir, target_dir)
        written += copy_references(asset, source_dir, target_dir)
    drifts = drifting(document, asset, target)
    if drifts is not None:
        name, clip = drifts
        write_lanim(target_dir / name, clip)
        written.append(target_dir / name)
    animation = said.get(("animation", "text", 0))
    if animation is not None:
        asset.animation = _animation_name(asset.animation, target) if animation else ""
        if animation:
            write_text(target_dir / asset.animation, animation)
            written.append(target_dir / asset.animation)
    asset.drive = getattr(document.runtime, "drive", asset.drive) if asset.animation else ""
    for path, changes in edited.items():
        inside = path.is_relative_to(source_dir)
        out = target_dir / path.relative_to(source_dir) if inside else path
        for key, value in changes.items():
            if key.endswith(".path") and Path(value).is_absolute():
                found = Path(value)
                if source_dir != target_dir and found.is_relative_to(source_dir):  # it goes along with the scene
                    if _copy(found, target_dir / found.relative_to(source_dir)):
                        written.append(target_dir / found.relative_to(source_dir))
                    found = target_dir / found.relative_to(source_dir)
                changes[key] = _beside(str(found), out.parent)
        update_material(out, changes)
        written.append(out)
    from editor.reimporting import save_record

    write_scene(target, asset)
    note_saved(document)
    return [*dict.fromkeys([*written, *save_record(document, target)]), target]


def note_saved(document: Document) -> None:
    """What the user said until now is in files of their own: when it is undone, they say it still."""
    for table, column, row in document.overrides:
        if table == "materials" and (path := document.runtime.residency.material(row).path):
            document.saved_values.add((table, column, str(Path(path).resolve())))
        elif table == "animation":
            document.saved_values.add((table, column, ""))


def said_and_saved(document: Document) -> dict[tuple[str, str, int], Any]:
    """The user's values, and the present ones of what was saved and has been undone since."""
    values = dict(document.overrides)
    numbers = getattr(document.runtime.residency, "material_files", {})
    for table, column, file in sorted(document.saved_values):
        row = numbers.get(Path(file)) if file else 0
        if row is not None and (table, column, row) not in values:
            with contextlib.suppress(KeyError):  # the effect knows it no longer
                values[table, column, row] = document.tables[table].read(column, (row,))[0]
    return values


def current_scene(document: Document) -> SceneAsset:
    """The scene as the user has it now, with what each instance of a prefab has of its own written down."""
    from engine.assets.prefab import with_changes

    asset = edited_scene(document.runtime, document.overrides)
    know_prefabs(document, asset)
    return with_changes(asset, document.scene_path.parent, document.prefabs)


def know_prefabs(document: Document, asset: SceneAsset) -> None:
    """Read the prefabs of instances that came without being placed, as those of a recovered session do."""
    from engine.assets.prefab import instance_nodes, prefab_files

    for path in prefab_files(asset, document.scene_path.parent):
        if path not in document.prefabs:
            with contextlib.suppress(LucarnaError):  # it is told of when the scene is read
                document.prefabs[path] = instance_nodes(path, document.scene_path.parent)


def relative(path: Path, folder: Path) -> str:
    """`path` as a file in `folder` names it."""
    return _beside(str(path), folder)


def copy_references(asset: SceneAsset, source_dir: Path, target_dir: Path) -> list[Path]:
    """Copy every file inside `source_dir` that the scene and its materials name to `target_dir`; those copied."""
    wanted = sorted(set(references(asset, source_dir)))
    return [target_dir / r for r in wanted if _copy(source_dir / r, target_dir / r)]


def moved_reference(reference: str, source_dir: Path, target_dir: Path) -> str:
    """What a scene in `target_dir` says for what one in `source_dir` says; what was copied there stays as it is."""
    if not reference or Path(reference).is_absolute():
        return reference
    if _inside(reference) and (target_dir / reference).is_file():
        return reference
    return relative(Path(os.path.normpath(source_dir / reference)), target_dir)


def _reached_from(asset: SceneAsset, source_dir: Path, target_dir: Path) -> SceneAsset:
    """`asset` with references that leave its folder as they are from `target_dir`; the others go along."""
    from importers.reimport.merging import rebased

    named = [asset.environment.path, asset.animation, *asset.clips]
    for node in asset.nodes:
        named += [node.mesh.file, *node.mesh.materials] if node.mesh is not None else []
        named += [node.light.profile] if node.light is not None else []
    return rebased(asset, source_dir, target_dir, known={n for n in named if _inside(n)})


def edited_scene(runtime: Any, overrides: Mapping[tuple[str, str, int], Any]) -> SceneAsset:
    """A copy of the runtime's scene asset with the user's values."""
    scene = runtime.scene
    if is_restructured(scene, runtime.asset):
        return _restructured(scene, runtime.asset, overrides, driven_rows(runtime))
    asset: SceneAsset = copy.deepcopy(runtime.asset)
    for (table, column, row), value in overrides.items():
        if table == "nodes":
            apply_to_node(asset.nodes[row], column, value)
        elif table == "objects":
            apply_to_object(asset.nodes[row], column, value)
        elif table == "lights":
            light = asset.nodes[int(scene.lights.node[row])].light
            if light is not None:
                setattr(light, column, value)
        elif table == "cameras":
            camera = asset.nodes[int(scene.cameras.node[row])].camera
            if camera is not None:
                setattr(camera, column, value)
        elif table in {"environment", "look"}:
            setattr(getattr(asset, table), column, value)
        elif table == BOOKMARKS:
            save_to(asset, row, value)
    return asset


def driven_rows(runtime: Any) -> frozenset[int]:
    """The nodes that are posed by clips, and are none of the file: those of prefabs, and copies of what clips move."""
    rows: frozenset[int] = getattr(getattr(runtime, "instance_clips", None), "driven", frozenset())
    if not getattr(runtime, "clips", ()):
        return rows
    runtime.follow_structure()
    channels = [channel for clip in runtime.clips for channel in clip.channels if channel.path != "weights"]
    moved = {int(runtime.cast_rows[c.node]) for c in channels if c.node < len(runtime.cast_rows)}
    copies = runtime.deck.copies.moving
    pairs = zip(copies.leader.tolist(), copies.row.tolist(), strict=True)
    return rows | {row for leader, row in pairs if leader in moved}


def is_restructured(scene: Any, base: SceneAsset) -> bool:
    """Whether nodes were added, removed or hung elsewhere; else node rows are indices into the asset's nodes."""
    rows = scene.row_of_node
    if len(base.nodes) != len(rows) or not np.array_equal(rows, np.arange(len(rows))):
        return True
    if scene.nodes.alive_count != len(rows):
        return True
    return bool((np.asarray(scene.nodes.parent)[rows] != [n.parent for n in base.nodes]).any())


def _restructured(
    scene: Any, base: SceneAsset, overrides: Mapping[tuple[str, str, int], Any], driven: Collection[int]
) -> SceneAsset:
    """The scene as it is, except that nodes of the file that nobody moved keep the file's place, not their pose, and
    those of instances placed since, where clips of their prefabs have `driven` them, the prefab's."""
    from engine.scene.convert import parents_first

    asset: SceneAsset = scene.to_asset(base)
    index_of = {row: index for index, row in enumerate(parents_first(scene))}
    for node in asset.nodes:
        if -1 in node.joints:  # a joint was deleted: the mesh is rigid now, as it is in the window
            node.joints = []
    rests = {row: old for old, row in zip(base.nodes, scene.row_of_node.tolist(), strict=True) if row >= 0}
    rests |= {row: scene.sources[row] for row in driven if row not in rests and row in scene.sources}
    for row, old in rests.items():
        node = asset.nodes[index_of[row]]
        node.translation, node.rotation, node.scale = old.translation, old.rotation, old.scale
        node.matrix = old.matrix
    for (table, column, row), value in overrides.items():
        if table == "nodes" and row in rests:
            apply_to_node(asset.nodes[index_of[row]], column, value)
    for (table, _column, row), value in overrides.items():
        if table == BOOKMARKS:
            save_to(asset, row, value)
    return asset


def _carry_profiles(asset: SceneAsset, folder: Path) -> list[Path]:
    """Copy light profiles and the panorama that lie elsewhere to `folder` and name them there in `asset`; returns the
    copies."""
    written = []
    for node in asset.nodes:
        if node.light is not None and node.light.profile and not _inside(node.light.profile):
            source = Path(node.light.profile)
            node.light = replace(node.light, profile=source.name)
            if _copy(source, folder / source.name):
                written.append(folder / source.name)
    lit_by = Path(asset.environment.path)
    if asset.environment.path and lit_by.is_absolute():
        asset.environment.path = lit_by.name
        if _copy(lit_by, folder / lit_by.name):
            written.append(folder / lit_by.name)
    return written


def drifting(document: Document, asset: SceneAsset, target: Path) -> tuple[str, ClipAsset] | None:
    """What of `asset`'s lights drifts since it was opened, as one clip and its file's name, named in `asset`."""
    from engine.scene.convert import parents_first
    from engine.scene.drift import add_clips, free_name

    beside = getattr(document.runtime, "beside", {})
    clips = [clip for key, (clip, _player) in beside.items() if key[0] == DRIFTS]
    if not clips:
        return None
    index_of = {row: index for index, row in enumerate(parents_first(document.runtime.scene))}
    for channel in (channel for clip in clips for channel in clip.channels if channel.node in index_of):
        node = asset.nodes[index_of[channel.node]]
        x, y, z = channel.values[0].tolist()
        node.translation = (x, y, z)  # wherever time stands now
    name = free_name(asset, scene_stem(target))
    return name, add_clips(asset, name, clips, index_of)


def _animation_name(present: str, target: Path) -> str:
    """Where the animation is written, relative to the scene: where it was, if that is beside it."""
    return present if present and _inside(present) else f"{scene_stem(target)}.animation.toml"


def apply_to_node(node: NodeAsset, column: str, value: Any) -> None:
    """What the user said of a node, in a column of the table of nodes."""
    if column == "skinning":
        node.extras = {**node.extras, "skinning": value}
        return
    if column == "weights":
        node.weights = [float(v) for v in value]
        return
    if column == "local":
        node.translation, node.rotation, node.scale, matrix = value
        # ours is by rows, the file's by columns
        node.matrix = None if matrix is None else tuple(float(v) for v in np.array(matrix).T.ravel())
        return
    setattr(node, column, value)
    if column in {"translation", "rotation", "scale"}:
        node.matrix = None


def apply_to_object(node: NodeAsset, column: str, value: Any) -> None:
    """A parameter of the material in a slot, on this object alone; None: as the material says."""
    if node.mesh is None:
        return
    slot, name = object_column(column)
    said = [*map(dict, node.mesh.overrides), *({} for _ in range(slot + 1 - len(node.mesh.overrides)))]
    said[slot].pop(name, None)
    if value is not None:
        said[slot][name] = value
    while said and not said[-1]:
        said.pop()
    node.mesh = replace(node.mesh, overrides=said)


def edited_materials(residency: Any, overrides: Mapping[tuple[str, str, int], Any]) -> dict[Path, dict[str, Any]]:
    """Material file -> {dotted key: value} for all that the user changed in materials that have a file."""
    found: dict[Path, dict[str, Any]] = {}
    for (table, column, row), value in overrides.items():
        if table == "materials":
            path = residency.material(row).path
            if path:
                changes = found.setdefault(Path(path).resolve(), {})
                if column.startswith(TEXTURE):
                    inherits = bool(getattr(residency.material(row).asset, "parent", ""))
                    changes.update(_texture_changes(column.removeprefix(TEXTURE), value, inherits))
                else:
                    as_parent = parent_values(residency, row).get(column) == value  # then the file need not say it
                    key = {FEATURES: "features", QUEUE: "queue"}.get(column, f"params.{column}")
                    changes[key] = None if as_parent else value
    return found


def _texture_changes(slot: str, value: tuple[Any, ...] | None, inherits: bool) -> dict[str, Any]:
    """The keys of a slot in a material file; None takes a key away, false an inherited texture."""
    if value is None:
        return {f"textures.{slot}": False if inherits else None}
    ref, usual = texture_from_plain(value), TextureRef(value[0])
    said = {"path", *ref.stated}
    return {
        f"textures.{slot}.{name}": getattr(ref, name)
        if name in said or getattr(ref, name) != getattr(usual, name)
        else None
        for name in TextureRef.__slots__
        if name != "stated"
    }


def _beside(path: str, folder: Path) -> str:
    """A texture's path as a material file in `folder` names it."""
    if not Path(path).is_absolute():
        return path
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # on another drive of Windows
        return Path(path).as_posix()


def references(asset: SceneAsset, folder: Path) -> Iterable[str]:
    """Every file inside `folder` that the scene names, and those its materials name."""
    from engine.assets.material_toml import read_material

    direct = [*asset.clips, asset.environment.path, asset.animation]
    for node in asset.nodes:
        if node.mesh is not None:
            direct += [node.mesh.file, *node.mesh.materials]
        if node.light is not None:
            direct.append(node.light.profile)
    for reference in dict.fromkeys(direct):
        if not reference or not _inside(reference):
            continue
        yield reference
        if reference.endswith(".material.toml") and (folder / reference).is_file():
            base = PurePosixPath(reference).parent
            material = read_material(folder / reference)
            for parent in material.files[1:]:
                joined = Path(os.path.relpath(parent, folder)).as_posix()
                if _inside(joined):
                    yield joined
            for texture in material.textures.values():
                joined = str(base / texture.path)
                if texture.path and _inside(joined):
                    yield joined


def _inside(reference: str) -> bool:
    return not PurePosixPath(reference).is_absolute() and ".." not in PurePosixPath(reference).parts


def _copy(source: Path, target: Path) -> bool:
    """Copy unless the target holds the same bytes already; False when there was nothing to do."""
    if not source.is_file():
        return False  # a missing file was reported when the scene was opened
    if target.is_file() and filecmp.cmp(source, target, shallow=False):
        return False
    with atomic_path(target) as temporary:
        try:
            shutil.copyfile(source, temporary)
        except OSError as error:
            raise OutputError(f"cannot copy {source.name}: {error.strerror}", where=target) from error
    return True
