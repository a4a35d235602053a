"""What lies around a mesh: the scripts and images that Ogre would find by name in its resource locations.

Ogre looks names up in folders that an application lists; a mesh does not say which. So: the mesh's own folder with all
below it, then `materials`, `scripts`, `textures` … beside it and beside the three folders above. The nearest counts.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

#: folders beside the mesh's (and beside those above it) that are looked through
NEAR = ("materials", "material", "scripts", "textures", "images", "skins")
LEVELS = 3
MAX_DEPTH = 5
MAX_ENTRIES = 20_000
IMAGE_EXTENSIONS = (
    ".png", ".jpg", ".jpeg", ".tga", ".dds", ".bmp", ".tif", ".tiff", ".webp", ".gif", ".psd", ".hdr", ".exr", ".ktx2",
)  # fmt: skip


@dataclass(slots=True)
class Surroundings:
    """`scripts` nearest first; `files`: lower-case name -> paths, nearest first; `complete` False where the folders
    held more entries than are looked at."""

    scripts: list[Path] = field(default_factory=list)
    files: dict[str, list[Path]] = field(default_factory=dict)
    complete: bool = True

    def find(self, name: str) -> Path | None:
        """The nearest file of that name; a path before it must match the end of the file's own, where one does."""
        wanted = PurePosixPath(name.replace("\\", "/"))
        found = self.files.get(wanted.name.lower(), [])
        tail = [part.lower() for part in wanted.parts if part not in ("/", "..", ".")]
        exact = [p for p in found if [part.lower() for part in p.parts[-len(tail) :]] == tail]
        same_case = [p for p in exact or found if p.name == wanted.name]
        return next(iter(same_case or exact or found), None)

    def find_image(self, stem: str) -> Path | None:
        """The nearest image of that name, whatever its extension."""
        for extension in IMAGE_EXTENSIONS:
            found = self.files.get(f"{stem.lower()}{extension}")
            if found:
                return found[0]
        return None

    def images(self) -> list[str]:
        """The names of all images, for did-you-mean."""
        return sorted(name for name in self.files if name.endswith(IMAGE_EXTENSIONS))


def look_around(folder: Path, stem: str) -> Surroundings:
    """Everything near the folder of a mesh called `stem`. Folders that cannot be read are passed over."""
    result = Surroundings()
    left = MAX_ENTRIES
    seen: set[str] = set()
    starts = [folder]
    above = folder
    for _ in range(LEVELS):
        if above.parent == above:
            break
        above = above.parent
        starts += [above / name for name in NEAR]
    for start in starts:
        left = _walk(start, above, result, seen, left)
    own = f"{stem.lower()}.material"
    result.scripts.sort(key=lambda path: path.name.lower() != own)  # stable: nearest first but for this
    result.complete = left > 0
    return result


def _walk(start: Path, root: Path, result: Surroundings, seen: set[str], left: int) -> int:
    """Take in the files below `start`, breadth first, by name; returns how many entries may still be looked at.

    Links to folders are not followed, links to files only within `root`."""
    queue: list[tuple[Path, int]] = [(start, 0)]
    while queue and left > 0:
        folder, depth = queue.pop(0)
        try:
            key = str(folder.resolve())
            if key in seen:
                continue
            seen.add(key)
            with os.scandir(folder) as listing:
                entries = sorted(listing, key=lambda entry: entry.name)
        except (OSError, RuntimeError):
            continue
        left -= len(entries)
        for entry in entries:
            if entry.name.startswith("."):
                continue
            try:
                if entry.is_dir(follow_symlinks=False):
                    if depth < MAX_DEPTH:
                        queue.append((folder / entry.name, depth + 1))
                    continue
                if not entry.is_file() or (entry.is_symlink() and not _is_within(folder / entry.name, root)):
                    continue
            except OSError:
                continue
            name = entry.name.lower()
            if name.endswith(".material"):
                result.scripts.append(folder / entry.name)
            if name.endswith((*IMAGE_EXTENSIONS, ".material", ".skeleton", ".skeleton.xml")):
                result.files.setdefault(name, []).append(folder / entry.name)
    return left


def _is_within(link: Path, root: Path) -> bool:
    try:
        return link.resolve().is_relative_to(root.resolve())
    except (OSError, RuntimeError):
        return False
