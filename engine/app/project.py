"""A project: a folder with `project.toml`, sources under `assets/`, and a rebuildable `.cache/`.

[project]
name = "Orrery"
start = "assets/orrery.glb"   # the scene or source that opens first, relative to this file
engine = "0.1.0"              # the version of Lucarna that wrote the project
"""

from __future__ import annotations

import difflib
import os
import re
import shutil
import tempfile
import tomllib
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

from engine import __version__
from engine.core.errors import FormatError, InputError, OutputError, Place, UsageError
from engine.core.findings import Findings
from engine.core.paths import template_dir

PROJECT_FILE = "project.toml"
KEYS = ("name", "start", "engine")
#: tables of project.toml that others read: settings of imports, budgets of `lucarna check`
OTHER_TABLES = ("import", "presets", "budgets")
#: Left behind when a template is copied: what a run leaves in a folder, and the picture for our own front page.
_IGNORED = shutil.ignore_patterns(".cache", "out", "preview.png", "__pycache__", "*.pyc", "*.tmp")


@dataclass(frozen=True, slots=True)
class Project:
    """`root`: its folder, absolute. `start`: the scene or source that opens first, absolute. `engine`: the version that
    wrote it. `findings`: what was noticed while reading, nothing of which stops the project from opening."""

    name: str
    root: Path
    start: Path
    engine: str = __version__
    findings: Findings = field(default_factory=Findings)

    @property
    def cache_dir(self) -> Path:
        return self.root / ".cache"


def is_project(path: Path) -> bool:
    """Whether `path` is a project's folder or its project.toml."""
    return path.name == PROJECT_FILE and path.is_file() if not path.is_dir() else (path / PROJECT_FILE).is_file()


def shader_folders(folder: Path) -> list[Path]:
    """Where the effects and shaders of the project around `folder` are, also before there are any: in `shaders/` as the
    built-in ones are, or in `effects/`. Without a project they are beside `folder`'s files."""
    root = folder.absolute()
    root = next((place for place in (root, *root.parents) if (place / PROJECT_FILE).is_file()), root)
    return [root / "shaders", root]


def new_project(directory: Path, *, template: Path | None = None) -> Project:
    """Make a project in `directory` from the template, whole or not at all, named after the folder.

    Raises UsageError when something is there already, OutputError when it cannot be written.
    """
    template = template_dir() if template is None else template
    target = Path(os.path.abspath(directory))  # noqa: PTH100  (resolve() would follow a link that the user chose)
    if target.is_dir():
        if any(target.iterdir()):
            raise UsageError("the folder is not empty", where=target, hint="give the name of a new folder")
    elif os.path.lexists(target):
        raise UsageError("a file of this name is there already", where=target, hint="give the name of a new folder")
    if not (template / PROJECT_FILE).is_file():
        raise InputError(f"the template has no {PROJECT_FILE}", where=template, hint="install Lucarna again")
    staging: Path | None = None
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        staging = Path(tempfile.mkdtemp(prefix=f".{target.name}.", suffix=".tmp", dir=target.parent))
        content = staging / "project"
        shutil.copytree(template, content, ignore=_IGNORED)
        _rename(content / PROJECT_FILE, target.name)
        if target.is_dir():
            target.rmdir()  # empty, see above; Windows renames onto nothing that exists
        content.rename(target)
    except OSError as error:
        raise OutputError(
            f"cannot make the project: {error.strerror or error}",
            where=target,
            hint="choose a folder that you may write to",
        ) from error
    finally:
        if staging is not None:
            shutil.rmtree(staging, ignore_errors=True)
    return load_project(target)


def load_project(path: Path) -> Project:
    """Read a project by its folder or its project.toml.

    Raises InputError when there is none or its start is missing, FormatError (file:line:column) for a broken file.
    """
    path = Path(path)
    file = path if path.name == PROJECT_FILE else path / PROJECT_FILE
    try:
        text = file.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise FormatError("is not UTF-8 text", where=file, hint="save it as UTF-8") from error
    except OSError as error:
        raise InputError(
            "is no project: its project.toml cannot be read", where=path, hint="`lucarna new DIR` makes a project"
        ) from error
    findings = Findings(str(file))
    values = _read_table(file, text)
    start = _start(file, text, values["start"])
    engine = values.get("engine", __version__)
    if _version(engine) > _version(__version__):
        findings.warn(
            "project.newer-engine",
            f"was written by Lucarna {engine}, this is {__version__}",
            "project.engine",
            "update Lucarna, or expect that newer settings are not understood",
        )
    return Project(values["name"], file.parent.absolute(), start, engine, findings)


def _read_table(file: Path, text: str) -> dict[str, str]:
    """The checked [project] table: all keys known, all values texts, `name` and `start` there."""
    try:
        document: dict[str, Any] = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        match = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        place = Place(str(file), int(match[1]), int(match[2])) if match else Place(str(file))
        raise FormatError(re.sub(r" \(at .*\)$", "", str(error)), where=place, hint="it must be TOML") from error
    table = document.get("project")
    if not isinstance(table, dict):
        raise FormatError("has no [project] table", where=file, hint="add one with name and start")
    tables = ("project", *OTHER_TABLES)
    for key in [*(k for k in document if k not in tables), *(k for k in table if k not in KEYS)]:
        near = difflib.get_close_matches(key, (*tables, *KEYS), 1)
        raise FormatError(
            f"unknown key {key!r}",
            where=_place(file, text, key),
            hint=f"did you mean {near[0]!r}?" if near else f"[project] knows {', '.join(KEYS)}",
        )
    for key, value in table.items():
        if not isinstance(value, str) or not value.strip():
            raise FormatError(f"{key} must be a text, is {value!r}", where=_place(file, text, key))
    for key in ("name", "start"):
        if key not in table:
            raise FormatError(f"[project] lacks {key!r}", where=_place(file, text, "project"))
    return dict(table)


def _start(file: Path, text: str, value: str) -> Path:
    """`value` as an absolute path that stays inside the project and is there."""
    relative = PurePosixPath(value.replace("\\", "/"))
    place = _place(file, text, "start")
    if relative.is_absolute() or ".." in relative.parts or re.match(r"[A-Za-z]:", value):
        raise FormatError(f"start {value!r} leaves the project", where=place, hint="use a path below project.toml")
    start = file.parent.absolute().joinpath(*relative.parts)
    if not start.is_file():
        raise InputError(f"start {value!r} is not there", where=place, hint="correct the path or restore the file")
    return start


def _place(file: Path, text: str, key: str) -> Place:
    """Line and column of the first `key =` or `[key…]` in `text`."""
    for number, line in enumerate(text.splitlines(), 1):
        match = re.match(rf"\s*(?:\[+\s*)?[\"']?({re.escape(key)})[\"']?\s*(?:=|\]|\.)", line)
        if match:
            return Place(str(file), number, match.start(1) + 1)
    return Place(str(file))


def _version(text: str) -> tuple[int, ...]:
    return tuple(int(number) for number in re.findall(r"\d+", text)[:3])


def _rename(file: Path, name: str) -> None:
    """Set name and engine version in a copied project file; its comments stay."""
    import tomlkit

    document = tomlkit.parse(file.read_text(encoding="utf-8"))
    table = document["project"]
    assert isinstance(table, dict)
    table["name"] = name
    table["engine"] = __version__
    file.write_text(tomlkit.dumps(document), encoding="utf-8", newline="\n")
