"""What a lone image is (a picture, a face of a cube, a layer, a panorama), and the files that belong to it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from engine.core.errors import InputError
from importers.settings import ImportSettings
from importers.texture_names import face_of, read_name

#: suffix of the name -> role of the texture
_ROLES = {
    "color": "color", "emissive": "color", "normal": "normal", "normal_dx": "normal", "orm": "metal_rough",
    "metal_rough": "metal_rough", "rough": "mask", "gloss": "mask", "metal": "mask", "occlusion": "occlusion",
    "height": "mask", "opacity": "mask",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Group:
    """`kind`: 2d, cube, array or environment; `files` in the order of their layers; `why`: what decided it."""

    kind: str
    files: tuple[Path, ...]
    why: str = ""


def group_of(path: Path, size: tuple[int, int], floats: bool, settings: ImportSettings) -> Group:
    """What `path` (an image of `size`) is to become. Raises InputError where siblings that are wanted are missing."""
    wanted = settings.image_as
    if wanted in ("auto", "cube"):
        faces = _faces(path)
        if faces is not None:
            return Group("cube", faces, f"{faces[0].name} and its five siblings are the faces of a cube")
    if wanted == "array":
        layers = _layers(path)
        return Group("array", layers, f"{len(layers)} numbered layers from {layers[0].name}")
    width, height = size
    panorama = width == 2 * height
    if wanted == "auto" and floats and panorama:
        return Group("environment", (path,), "radiance, twice as wide as high: an environment")
    if wanted in ("cube", "environment"):
        if not panorama:
            raise InputError(
                f"{width}x{height} is no panorama, and there are no six faces beside it", where=path,
                hint="a panorama is twice as wide as high; faces are named sky_px, sky_nx, … or sky_right, sky_left, …",
            )  # fmt: skip
        return Group(wanted, (path,), "as the setting image_as says")
    return Group("2d", (path,))


def siblings_of(path: Path, settings: ImportSettings) -> tuple[Path, ...]:
    """The files that become one texture with `path`, by their names alone; none where it stands alone."""
    try:
        if settings.image_as in ("auto", "cube"):
            return _faces(path) or ()
        return _layers(path) if settings.image_as == "array" else ()
    except (InputError, OSError):
        return ()


def common_name(path: Path, files: Sequence[Path]) -> str:
    """What the texture of `files` is called after: the name they share (`sky` of sky_px, sky_nx …), else the stem of
    `path`, or its folder's name where the files are called after their faces alone."""
    if len(files) < 2:
        return path.stem
    face = face_of(path.stem)
    shared = face[0] if face is not None else path.stem.rstrip("0123456789")
    return shared.rstrip(" _.-") or path.absolute().parent.name or path.stem


def role_of(path: Path, settings: ImportSettings) -> tuple[str, bool, str]:
    """(role, whether its green points down, why) of a picture."""
    if settings.role != "auto":
        return settings.role, settings.flip_green, ""
    name = read_name(path.stem)
    role = _ROLES.get(name.role, "color")
    why = f"its name ends in {name.suffix!r}" if name.role else "its name says nothing else"
    return role, settings.flip_green or name.role == "normal_dx", f"taken as {role}: {why}"


def _faces(path: Path) -> tuple[Path, ...] | None:
    """The six faces in order, where `path` is one of them and all are there."""
    own = face_of(path.stem)
    if own is None:
        return None
    found: dict[int, Path] = {}
    try:
        siblings = sorted(p for p in path.parent.iterdir() if p.suffix.lower() == path.suffix.lower())
    except OSError:
        return None
    for file in siblings:
        face = face_of(file.stem)
        if face is not None and face[0].lower() == own[0].lower():
            found.setdefault(face[1], file)
    return tuple(found[k] for k in range(6)) if len(found) == 6 else None


def _layers(path: Path) -> tuple[Path, ...]:
    """The files that differ from `path` in the number at the end of their names, by that number."""
    match = re.match(r"^(.*?)(\d+)$", path.stem)
    if match is None:
        raise InputError(
            "an array is made of numbered files", where=path, hint="name them like tile_00.png, tile_01.png"
        )
    found: dict[int, Path] = {}
    for file in sorted(path.parent.iterdir()):
        other = re.match(r"^(.*?)(\d+)$", file.stem)
        if other is not None and other[1] == match[1] and file.suffix.lower() == path.suffix.lower():
            found.setdefault(int(other[2]), file)
    return tuple(found[k] for k in sorted(found))
