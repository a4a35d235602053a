"""Importers from outside: by the entry points `lucarna.importers`, and files that LUCARNA_IMPORTERS names, which the
worker processes of a conversion inherit. One that cannot be loaded is left out and told of in `problems`.

A file defines IMPORTER, an importers.registry.Importer, and `load` and `dependencies` beside it.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from importers.registry import Importer

GROUP = "lucarna.importers"
VARIABLE = "LUCARNA_IMPORTERS"

#: file or entry point -> what went wrong, with its line
problems: dict[str, str] = {}
_loaded: dict[str, tuple[float, Importer | None]] = {}
_installed: list[Importer] | None = None


def plugin_importers() -> tuple[Importer, ...]:
    """All that can be used now; files are loaded again when they change."""
    global _installed
    if _installed is None:
        _installed = []
        for point in importlib.metadata.entry_points(group=GROUP):
            try:
                _installed.append(_checked(point.load()))
            except Exception as error:  # foreign code raises what it likes: it is listed, the rest loads
                problems[point.value] = where_it_broke(error)
    files = [Path(f) for f in os.environ.get(VARIABLE, "").split(os.pathsep) if f]
    return (*_installed, *(i for i in map(_of_file, files) if i is not None))


def add_file(path: Path) -> None:
    """Use the importer of a file in this process and in those that it starts."""
    files = [f for f in os.environ.get(VARIABLE, "").split(os.pathsep) if f and f != str(path)]
    os.environ[VARIABLE] = os.pathsep.join([*files, str(path)])


def remove_file(path: Path) -> None:
    files = [f for f in os.environ.get(VARIABLE, "").split(os.pathsep) if f and f != str(path)]
    os.environ[VARIABLE] = os.pathsep.join(files)
    _loaded.pop(str(path), None)


def _of_file(path: Path) -> Importer | None:
    try:
        stamp = path.stat().st_mtime
    except OSError:
        return None
    known = _loaded.get(str(path))
    if known is None or known[0] != stamp:
        problems.pop(str(path), None)
        try:
            known = (stamp, _checked(load_module(path).IMPORTER))
        except Exception as error:  # foreign code raises what it likes: it is listed, the rest loads
            problems[str(path)] = where_it_broke(error, path)
            known = (stamp, None)
        _loaded[str(path)] = known
    return known[1]


def module_name(path: Path) -> str:
    """The name that a plug-in's file has among Python's modules."""
    stem = path.parent.name if path.name == "__init__.py" else path.stem
    return f"lucarna_plugin_{stem}"


def load_module(path: Path) -> Any:
    """Run a file as a module of its own, in the place of what it was before. What it raises comes through."""
    name = module_name(path)
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is no Python file")
    module = importlib.util.module_from_spec(spec)
    before = sys.modules.get(name)
    sys.modules[name] = module
    try:
        source = path.read_text(encoding="utf-8")  # not by the loader: its cache knows whole seconds only
        exec(compile(source, str(path), "exec"), module.__dict__)
    except BaseException:  # an interrupt, too, leaves nothing behind
        if before is None:
            del sys.modules[name]
        else:
            sys.modules[name] = before
        raise
    return module


def where_it_broke(error: BaseException, path: Path | None = None) -> str:
    """`file:line: what`, of the innermost place inside `path` (or of all)."""
    if isinstance(error, SyntaxError):
        return f"{error.filename}:{error.lineno}: {error.msg}"
    frames = traceback.extract_tb(error.__traceback__)
    own = [f for f in frames if path is None or Path(f.filename).is_relative_to(path.parent)]
    words = traceback.format_exception_only(error)[-1].strip()
    place = (own or frames)[-1] if frames else None
    return f"{place.filename}:{place.lineno}: {words}" if place is not None else words


def _checked(importer: Any) -> Importer:
    from importers.registry import Importer

    if not isinstance(importer, Importer):
        raise TypeError(f"IMPORTER is {type(importer).__name__}, and no Importer")
    return importer
