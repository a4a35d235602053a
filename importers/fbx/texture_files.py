"""Finding textures: the paths that FBX files hold are mostly those of another machine.

Tried in order: the path as given, its tail against the source's folder, the folders beside it, the folders above it
(there by name only). Letter case and the direction of slashes do not matter. A path that climbs out of the folder by
itself (`../x.png`, `/etc/x`) is never followed, only its file name is searched.
"""

from __future__ import annotations

import difflib
import os
import re
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

#: folders beside a source in which exporters and artists put textures
_FOLDERS = ("textures", "texture", "tex", "images", "image", "maps", "map", "materials", "source")
#: only such names are searched above the source's folder
IMAGES = {".png", ".jpg", ".jpeg", ".tga", ".bmp", ".tif", ".tiff", ".dds", ".webp", ".gif", ".hdr", ".exr", ".psd",
          ".ktx2", ".pcx", ".sgi", ".ppm", ".qoi", ".jp2"}  # fmt: skip
_ABOVE = 2
_DRIVE = re.compile(r"^([A-Za-z]:|\\\\|/|[A-Za-z][A-Za-z0-9+.\-]*://)")


@dataclass(slots=True)
class Search:
    """`path`: the file, or None; `tried`: paths in the order tried, as shown to people; `similar`: nearest names."""

    path: Path | None
    tried: list[str] = field(default_factory=list)
    similar: list[str] = field(default_factory=list)


class TextureFinder:
    """Searches around one source file. Folders are listed once."""

    def __init__(self, source: Path, allow_outside: bool = False) -> None:
        self._root = source.parent.resolve()
        self._stem = source.stem
        self._allow_outside = allow_outside
        self._listed: dict[Path, dict[str, str]] = {}

    def find(self, names: list[str]) -> Search:
        """The file of a texture that the source calls by any of `names` (relative, then absolute ones)."""
        given = [name.replace("\\", "/").strip() for name in dict.fromkeys(names) if name.strip()]
        search = Search(None)
        for name in given:
            plain = not _DRIVE.match(name) and ".." not in PurePosixPath(name).parts
            if plain or self._allow_outside:
                search.tried.append(name)
                search.path = self._open(self._root, name) if plain else _regular(self._root / name)
                if search.path is not None:
                    return search
        tails = list(dict.fromkeys(tail for name in given for tail in _tails(name)))
        base = [PurePosixPath(tail).name for tail in tails[-1:]]
        places = [(self._root, tails)]
        places += [(self._root / folder, tails) for folder in self._folders()]
        above = self._root
        for _ in range(_ABOVE):
            if above.parent == above:
                break
            above = above.parent
            images = [tail for tail in tails if PurePosixPath(tail).suffix.lower() in IMAGES]
            places += [(above, images), *((above / folder, base) for folder in _FOLDERS if images)]
        for folder, wanted in places:
            for tail in wanted:
                search.path = self._open(folder, tail, links=folder.is_relative_to(self._root))
                if search.path is not None:
                    return search
        search.tried += [_shown(folder / tail, self._root) for folder, wanted in places for tail in wanted[-1:]]
        search.tried = list(dict.fromkeys(search.tried))
        search.similar = self._similar(base[0]) if base else []
        return search

    def _folders(self) -> list[str]:
        """Folders beside the source, its `.fbm` folder first."""
        here = self._names(self._root)
        wanted = [f"{self._stem}.fbm".lower(), *_FOLDERS]
        return [here[name] for name in wanted if name in here]

    def _open(self, folder: Path, name: str, links: bool = True) -> Path | None:
        """The regular file `folder`/`name`, each part in any letter case, not leaving the source's folder by links;
        without `links` not through any."""
        path = folder
        for part in PurePosixPath(name).parts:
            found = self._names(path).get(part.lower())
            if found is None or part == "..":
                return None
            path = path / (part if part in self._names(path).values() else found)
        resolved = _regular(path)
        inside = resolved is not None and (resolved.is_relative_to(self._root) if links else resolved == path)
        return resolved if inside or self._allow_outside else None

    def _names(self, folder: Path) -> dict[str, str]:
        """Lower-case name -> name, of what lies in a folder."""
        if folder not in self._listed:
            try:
                self._listed[folder] = {p.name.lower(): p.name for p in sorted(folder.iterdir(), reverse=True)}
            except OSError:
                self._listed[folder] = {}
        return self._listed[folder]

    def _similar(self, name: str) -> list[str]:
        """Names of images near the source that are spelt alike."""
        here: dict[str, str] = {}
        for folder in (self._root, *(self._root / f for f in self._folders())):
            for lower, actual in self._names(folder).items():
                if PurePosixPath(lower).suffix in IMAGES:
                    here.setdefault(lower, str((folder / actual).relative_to(self._root)))
        stem = PurePosixPath(name.lower()).stem
        alike = [lower for lower in here if PurePosixPath(lower).stem == stem]
        alike += difflib.get_close_matches(name.lower(), here, 2, 0.7)
        return [here[lower] for lower in dict.fromkeys(alike)][:3]


def _shown(path: Path, root: Path) -> str:
    """Relative to the source's folder, alike on every machine."""
    return Path(os.path.relpath(path, root)).as_posix()


def _tails(name: str) -> list[str]:
    """`a/b/c.png` -> [a/b/c.png, b/c.png, c.png], without drives and `..`, at most the last four parts."""
    parts = [p for p in PurePosixPath(_DRIVE.sub("", name)).parts if p not in ("..", "/", ".")][-4:]
    return ["/".join(parts[k:]) for k in range(len(parts))]


def _regular(path: Path) -> Path | None:
    try:
        resolved = path.resolve()
        return resolved if resolved.is_file() else None
    except (OSError, ValueError, RuntimeError):
        return None
