"""`parent = "base.material.toml"`: a material that says only what is other than in the material it comes from.

    steel.material.toml                 worn_steel.material.toml
        effect = "surface"                  parent = "steel.material.toml"
        [params]                            [params]
        metallic = 1.0                      roughness = 0.6
        roughness = 0.2

Key by key, through any number of files: what is not said is as in the parent, an array is replaced as a whole, `false`
takes an inherited texture away. The path is relative to the file that says it. `name` and `extensions` are not
inherited (a name left out is that of the file).
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from engine.assets.records import did_you_mean
from engine.core.errors import FormatError, InputError
from engine.core.toml_merge import Merged, merged
from engine.core.toml_source import TomlSource, load_toml

SUFFIX = ".material.toml"
#: no one nests deeper; a longer chain is a mistake or an attack
MOST = 32
NOT_INHERITED = frozenset({"schema", "name", "parent", "extensions"})


def load_chain(source: TomlSource, path: Path) -> Merged:
    """`source` (of the file `path`) over its parents. Paths of textures are relative to the folder of `path` then.

    Raises FormatError at the line that names a parent which is not there, or comes round to a file again."""
    sources, files = [source], [path]
    while isinstance(name := sources[-1].data.get("parent"), str) and name:
        at, here = sources[-1], files[-1]
        file = here.parent / name
        if any(_same(file, known) for known in files):
            round_trip = " -> ".join([*(known.name for known in files), file.name])
            raise at.error(
                ("parent",), f"the parents go in a circle: {round_trip}", hint="break the circle", value=True
            )
        if len(files) == MOST:
            raise at.error(("parent",), f"more than {MOST} parents one above the other", value=True)
        if not file.is_file():
            near = sorted(other.name for other in here.parent.glob(f"*{SUFFIX}") if not _same(other, here))
            hint = did_you_mean(name, near) or "the path is relative to this file"
            raise at.error(("parent",), f"the parent {name!r} is not there", hint=hint, value=True)
        try:
            sources.append(load_toml(file))
        except FormatError as error:
            raise FormatError(
                f"the parent of {here.name}: {error.message}", where=error.where, hint=error.hint
            ) from error
        files.append(file)

    def rebased(data: dict[str, Any], index: int) -> Mapping[str, Any]:
        return data if index == 0 else _rebased(data, files[index].parent, path.parent)

    return merged(sources, files, NOT_INHERITED, rebased)


def chain_files(path: Path) -> list[Path]:
    """The file and its parents as far as they can be known, also such as are not there. Never raises."""
    files = [path]
    while len(files) <= MOST:
        try:
            name = load_toml(files[-1]).data.get("parent")
        except InputError:
            break
        if not isinstance(name, str) or not name:
            break
        file = files[-1].parent / name
        if any(_same(file, known) for known in files):
            break
        files.append(file)
    return files


def relative(path: str, source: Path, target: Path) -> str:
    """A path relative to the folder `source` as one relative to `target`, with /."""
    if not path or Path(path).is_absolute() or _same(source, target):
        return path
    try:
        return Path(os.path.relpath(source / path, target)).as_posix()
    except ValueError:  # another drive
        return (source / path).resolve().as_posix()


def _rebased(data: dict[str, Any], source: Path, target: Path) -> dict[str, Any]:
    textures = data.get("textures")
    if not isinstance(textures, dict):
        return data
    moved = {
        slot: {**t, "path": relative(t["path"], source, target)}
        if isinstance(t, dict) and isinstance(t.get("path"), str)
        else t
        for slot, t in textures.items()
    }
    return {**data, "textures": moved}


def _same(one: Path, other: Path) -> bool:
    return one.resolve() == other.resolve()
