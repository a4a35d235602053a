"""What the files of a project name each other by: one list of references a file, whatever its format.

A text value of our own JSON and TOML files counts as a reference where it leads to a file that is there: from the
file's own folder, for effects and shaders also from the folders of shaders, for project.toml from the project. glTF and
OBJ files are read for what they name, too, but they are sources, which nobody rewrites.
"""

from __future__ import annotations

import json
import os
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

SKIPPED_FOLDERS = {".git", ".cache", "__pycache__", "node_modules", ".venv"}
SHADERS = (".glsl", ".vert", ".frag", ".comp", ".geom", ".tesc", ".tese")
#: formats that are read for what they name and never written
SOURCES = (".gltf", ".obj", ".mtl")
#: keys whose values are words, whatever file is called the same
WORDS = {"name", "doc", "schema", "label"}
LARGEST = 256 << 20
_INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"\n]+)"', re.M)
_LINE = re.compile(r"^\s*(mtllib|map_\w+|bump|disp|decal|norm|refl)\s+(.+?)\s*$", re.M)

KeyPath = tuple[str | int, ...]


@dataclass(frozen=True, slots=True)
class Reference:
    """`file` says `text` at `keys` and means `target`, looked for from `base`. `is_key`: the key itself is the name;
    `by_name`: an effect's name stands for its file. `fixed`: it stands in a source."""

    file: Path
    keys: KeyPath
    text: str
    target: Path
    base: Path
    is_key: bool = False
    by_name: bool = False

    @property
    def fixed(self) -> bool:
        return self.file.suffix.lower() in SOURCES


def project_root(path: Path) -> Path:
    """The folder of the project around `path`; without one, the folder that `path` lies in."""
    start = path.absolute()
    for place in start.parents:
        if (place / "project.toml").is_file():
            return place
    return start.parent


def files_of(root: Path) -> list[Path]:
    """Every file below `root` but hidden ones and caches, sorted."""
    found = []
    for base, folders, names in os.walk(root):
        folders[:] = sorted(f for f in folders if f not in SKIPPED_FOLDERS and not f.startswith("."))
        found += [Path(base) / name for name in sorted(names) if not name.startswith(".")]
    return found


def all_references(root: Path, files: Sequence[Path] | None = None) -> list[Reference]:
    """Those of every file below `root`."""
    files = files_of(root) if files is None else files
    known = set(files)
    effects = {p.name.removesuffix(".effect.toml"): p for p in files if p.name.endswith(".effect.toml")}
    return [ref for file in files for ref in references(file, root, known, effects)]


def references(
    file: Path, root: Path, known: set[Path], effects: Mapping[str, Path] | None = None
) -> Iterator[Reference]:
    """What `file` names among the `known` files. A file that cannot be read names nothing."""
    name = file.name.lower()
    try:
        if file.stat().st_size > LARGEST:
            return
        if name.endswith((".scene.json", ".gltf")):
            yield from _values(file, root, known, json.loads(file.read_text("utf-8")))
        elif name.endswith((".toml", ".import")):
            data = tomllib.loads(file.read_text("utf-8"))
            yield from _values(file, root, known, data)
            if name.endswith(".import"):
                yield from _keys(file, known, data)
            effect = data.get("effect")
            if name.endswith(".material.toml") and effects and isinstance(effect, str) and effect in effects:
                yield Reference(file, ("effect",), effect, effects[effect], effects[effect].parent, by_name=True)
        elif name.endswith(SHADERS):
            for found in _INCLUDE.finditer(file.read_text("utf-8")):
                yield from _resolved(file, ("include",), found[1], [file.parent, *shader_roots(root)], known)
        elif name.endswith((".obj", ".mtl")):
            for found in _LINE.finditer(file.read_text("utf-8", errors="replace")):
                words = found[2].split()
                for text in {found[2], words[-1]}:
                    yield from _resolved(file, (found[1],), text, [file.parent], known)
    except (OSError, ValueError, RecursionError):
        return


def shader_roots(root: Path) -> list[Path]:
    return [root / "shaders", root]


def _values(file: Path, root: Path, known: set[Path], data: Any) -> Iterator[Reference]:
    bases = [file.parent]
    if file.name.endswith(".effect.toml"):
        bases += shader_roots(root)
    source = file.suffix.lower() in SOURCES
    for keys, text in _texts(data, ()):
        if keys[-1] in WORDS or len(text) > 1024 or "\n" in text or (source and keys[-1] != "uri"):
            continue
        yield from _resolved(file, keys, unquote(text) if source else text, bases, known)


def _keys(file: Path, known: set[Path], data: Mapping[str, Any]) -> Iterator[Reference]:
    """`[textures."wood.png"]` of a sidecar."""
    textures = data.get("textures")
    for key in textures if isinstance(textures, dict) else ():
        for found in _resolved(file, ("textures", key), key, [file.parent], known):
            yield Reference(file, found.keys, key, found.target, found.base, is_key=True)


def _texts(data: Any, keys: KeyPath) -> Iterator[tuple[KeyPath, str]]:
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _texts(value, (*keys, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from _texts(value, (*keys, index))
    elif isinstance(data, str) and keys:
        yield keys, data


def _resolved(file: Path, keys: KeyPath, text: str, bases: Sequence[Path], known: set[Path]) -> Iterator[Reference]:
    if not text or text in (".", ".."):
        return
    for base in bases:
        target = Path(os.path.normpath(base / text))
        if target in known and target != file:
            yield Reference(file, keys, text, target, base)
            return
