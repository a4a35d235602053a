"""A new import and what the user had made of the last one -> a folder to open. Nothing of either side is written to.

<user cache>/merged/<number>/   the new import's files, links where the system has them; the merged materials and
                                scene; the record of the new import
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from engine.assets.material import MaterialAsset
from engine.assets.material_toml import parse_material, read_material, update_material
from engine.assets.prefab import map_files
from engine.assets.scene import SceneAsset
from engine.assets.scene_json import read_scene, write_scene
from engine.core.errors import LucarnaError, OutputError
from engine.core.paths import user_cache_dir
from importers.reimport.merge import Report
from importers.reimport.merge_material import changes, merge_material
from importers.reimport.merge_scene import merge_scene
from importers.reimport.record import SCENE, Imported, digest_of_import, material_texts, write_record


def merge_import(
    last: Imported, new_scene: Path, ours: SceneAsset, origin: list[int], folder: Path,
    unsaved: Mapping[Path, Mapping[str, Any]],
) -> tuple[Path, Report]:  # fmt: skip
    """Merge and write. `ours`: the user's scene, whose files are relative to `folder`; `origin`: see merge_scene;
    `unsaved`: material file -> the dotted keys that the user changed and did not save.

    Returns the scene to open and the report. Raises InputError, FormatError, OutputError; then nothing is left."""
    theirs = read_scene(new_scene)
    report = Report()
    out = _new_folder()
    try:
        _link_all(new_scene.parent, out)
        ours = rebased(ours, folder, out, known=set(last.materials) | _named(last.scene))
        merged, keys = merge_scene(last.scene, theirs, ours, origin, report)
        for name in material_texts(theirs, new_scene.parent):
            _merge_file(last, name, folder, out, unsaved, report)
        _keep_orphans(last, theirs, new_scene.parent, folder, out, unsaved, report)
        path = out / f"{new_scene.name.removesuffix(SCENE)}{SCENE}"
        write_scene(path, merged)
        record = Imported(
            last.source, digest_of_import(new_scene, theirs), theirs, material_texts(theirs, new_scene.parent),
            keys, [*last.orphans, *report.orphans],
        )  # fmt: skip
        write_record(path, record)
    except BaseException:  # an interrupt, too, leaves nothing behind
        shutil.rmtree(out, ignore_errors=True)
        raise
    return path, report


def rebased(asset: SceneAsset, folder: Path, out: Path, known: set[str]) -> SceneAsset:
    """`asset` with references from `out` in place of from `folder`; names of the import itself (`known`) stay."""
    import copy

    asset = copy.deepcopy(asset)

    def follow(reference: str) -> str:
        if not reference or reference in known or Path(reference).is_absolute():
            return reference
        return Path(os.path.relpath(folder / reference, out)).as_posix()

    asset.nodes = [map_files(node, follow) for node in asset.nodes]
    asset.clips = [follow(c) for c in asset.clips]
    asset.environment.path = follow(asset.environment.path)
    asset.animation = follow(asset.animation)
    return asset


def _named(scene: SceneAsset) -> set[str]:
    """The files that an imported scene names beside its materials."""
    meshes = {n.mesh.file for n in scene.nodes if n.mesh is not None}
    profiles = {n.light.profile for n in scene.nodes if n.light is not None and n.light.profile}
    return meshes | profiles | set(scene.clips) | ({scene.environment.path} - {""})


def _merge_file(
    last: Imported, name: str, folder: Path, out: Path, unsaved: Mapping[Path, Mapping[str, Any]], report: Report
) -> None:
    """Make out/name, which holds the new import's material, the merged one."""
    if name not in last.materials:
        report.taken.append(f"material {name.removesuffix('.material.toml')}: new")
        return
    target = out / name
    theirs = read_material(target)
    base = parse_material(last.materials[name], str(target))
    mine = _ours(last, name, folder, target, unsaved)
    merged = merge_material(base, theirs, mine, report)
    delta = changes(mine, merged)
    if delta:
        update_material(target, delta)


def _ours(
    last: Imported, name: str, folder: Path, target: Path, unsaved: Mapping[Path, Mapping[str, Any]]
) -> MaterialAsset:
    """Put the user's material at `target`, saved or not, with its comments, and return it."""
    saved = folder / name
    text = saved.read_text("utf-8") if saved.is_file() else last.materials[name]
    target.unlink(missing_ok=True)  # it may be a link into the cache
    target.write_text(text, encoding="utf-8", newline="\n")
    wanted = dict(unsaved.get(saved.resolve(), {}))
    if wanted:
        update_material(target, wanted)
    base = parse_material(last.materials[name], str(target))
    mine = read_material(target)
    known = {ref.path for ref in base.textures.values()}
    moved = {
        f"textures.{slot}.path": Path(os.path.relpath(folder / ref.path, target.parent)).as_posix()
        for slot, ref in mine.textures.items()
        if ref.path and ref.path not in known and not Path(ref.path).is_absolute()
    }
    return update_material(target, moved) if moved else mine


def _keep_orphans(
    last: Imported, theirs: SceneAsset, new_folder: Path, folder: Path, out: Path,
    unsaved: Mapping[Path, Mapping[str, Any]], report: Report,
) -> None:  # fmt: skip
    """Materials that the source no longer has: what the user had changed of them is told, and kept as a file."""
    now = material_texts(theirs, new_folder)
    for name in last.materials:
        if name in now:
            continue
        target = out / name
        try:
            base = parse_material(last.materials[name], str(target))
            mine = _ours(last, name, folder, target, unsaved)
            told = Report()
            merge_material(base, base, mine, told)
        except LucarnaError as error:
            report.orphans.append(f"material {name}: {error}")
            continue
        title = name.removesuffix(".material.toml")
        if told.kept:
            said = ", ".join(line.rpartition(": ")[2] for line in told.kept)
            report.orphans.append(f"material {title} is no longer in the source; yours ({said}) is kept as {name}")
        else:
            report.taken.append(f"material {title}: gone")


def _new_folder() -> Path:
    root = user_cache_dir() / "merged"
    try:
        root.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(dir=root))
    except OSError as error:
        raise OutputError(f"cannot write there: {error.strerror or error}", where=root) from error


def _link_all(source: Path, out: Path) -> None:
    for path in source.iterdir():
        if path.is_file() and path.name != "import.json":
            if path.name.endswith((".toml", ".json")):
                shutil.copyfile(path, out / path.name)
                continue
            try:
                os.link(path, out / path.name)
            except OSError:
                shutil.copyfile(path, out / path.name)
