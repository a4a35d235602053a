"""Which plug-ins there are: installed ones by entry point, a project's by its `plugins/` folder. Nothing runs here."""

from __future__ import annotations

import importlib.metadata
from dataclasses import dataclass
from pathlib import Path

GROUP = "lucarna.plugins"
FOLDER = "plugins"


@dataclass(frozen=True, slots=True)
class Found:
    """`path`: the file of a project's plug-in, else None; `entry`: what an entry point names."""

    name: str
    path: Path | None = None
    entry: importlib.metadata.EntryPoint | None = None

    @property
    def source(self) -> str:
        return str(self.path) if self.path is not None else (self.entry.value if self.entry is not None else "")


def installed() -> list[Found]:
    return [Found(point.name, None, point) for point in importlib.metadata.entry_points(group=GROUP)]


def of_project(root: Path) -> list[Found]:
    """`plugins/NAME.py` and `plugins/NAME/__init__.py`, by name; names with `_` or `.` in front are left out."""
    folder = root / FOLDER
    if not folder.is_dir():
        return []
    files = list(folder.glob("*.py")) + [p / "__init__.py" for p in folder.iterdir() if p.is_dir()]
    named = {(p.parent.name if p.name == "__init__.py" else p.stem): p for p in sorted(files) if p.is_file()}
    return [Found(name, path) for name, path in sorted(named.items()) if not name.startswith(("_", "."))]


def stamp(path: Path) -> float:
    """When a plug-in's files were last changed: those of its folder, or its one file."""
    return max((f.stat().st_mtime for f in files_of(path) if f.is_file()), default=0.0)


def files_of(path: Path) -> list[Path]:
    """The Python files of the plug-in whose first one is `path`."""
    return list(path.parent.rglob("*.py")) if path.name == "__init__.py" else [path]
