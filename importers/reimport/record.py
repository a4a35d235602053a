"""`X.imported.json` beside `X.scene.json`: what the scene was imported from, as it was then. A later import is merged
against it; without it nobody could tell the user's changes from the source's."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from engine.assets.scene import SceneAsset
from engine.assets.scene_json import format_scene, parse_scene
from engine.core.atomic import write_text

SCHEMA = "lucarna.imported/1"
SUFFIX = ".imported.json"
SCENE = ".scene.json"


@dataclass(slots=True)
class Imported:
    """`scene`, `materials` (file name -> its text): the last import, as it came. `keys[i]`: the node of that import
    that node i of the scene beside the record is, or -1. `orphans`: what found no place when it was merged."""

    source: Path
    digest: str
    scene: SceneAsset
    materials: dict[str, str]
    keys: list[int]
    orphans: list[str] = field(default_factory=list)


def record_path(scene: Path) -> Path:
    return scene.with_name(scene.name.removesuffix(SCENE) + SUFFIX)


def read_record(scene: Path) -> Imported | None:
    """The record of a scene file; None where there is none, or it cannot be understood: then nothing is merged."""
    path = record_path(scene)
    try:
        data: dict[str, Any] = json.loads(path.read_text("utf-8"))
        if data.get("schema") != SCHEMA:
            return None
        source = Path(os.path.normpath(scene.parent / data["source"]))
        asset = parse_scene(json.dumps(data["scene"]), str(path))
        materials = {str(k): str(v) for k, v in data["materials"].items()}
        keys = [int(k) for k in data["keys"]]
        return Imported(source, str(data["digest"]), asset, materials, keys, [str(o) for o in data["orphans"]])
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def write_record(scene: Path, record: Imported) -> Path:
    """Write the record of the scene file `scene`. Raises OutputError."""
    path = record_path(scene)
    try:
        source = Path(os.path.relpath(record.source, scene.parent)).as_posix()
    except ValueError:  # on another drive of Windows
        source = record.source.as_posix()
    data = {
        "schema": SCHEMA, "source": source, "digest": record.digest, "keys": record.keys, "orphans": record.orphans,
        "materials": record.materials, "scene": json.loads(format_scene(record.scene, str(path))),
    }  # fmt: skip
    write_text(path, json.dumps(data, indent=1, sort_keys=True, ensure_ascii=False) + "\n")
    return path


def digest_of_import(scene_path: Path, scene: SceneAsset) -> str:
    """What tells one import of a source from another: every file that it wrote, where the cache knows them."""
    from importers.cache import read_entry
    from importers.fingerprint import digest_of

    entry = read_entry(scene_path.parent)
    if entry is None:
        return scene.provenance.get("source_hash", "")
    return digest_of(*(f"{item['name']} {item['digest']}" for item in entry.outputs))


def of_import(source: Path, scene_path: Path, scene: SceneAsset) -> Imported:
    """The record of a scene as an import has just written it."""
    return Imported(
        source, digest_of_import(scene_path, scene), scene, material_texts(scene, scene_path.parent),
        list(range(len(scene.nodes))),
    )  # fmt: skip


def material_texts(scene: SceneAsset, folder: Path) -> dict[str, str]:
    """The material files that the scene names, by their names there."""
    names = dict.fromkeys(m for node in scene.nodes if node.mesh is not None for m in node.mesh.materials if m)
    texts = {}
    for name in names:
        try:
            texts[name] = (folder / name).read_text("utf-8")
        except OSError:
            continue
    return texts
