"""A picture (.png, .jpg …) becomes the texture of a slot: encoded aside by the importers, written beside the material.

PictureTexture (a Work) ─ thread ─► decode, mips, compress ─► <picture>.<slot>.dds ─► material_editing.set_texture
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from engine.core.errors import InputError, LucarnaError

if TYPE_CHECKING:
    from editor.session import Session

PICTURES = (".png", ".jpg", ".jpeg", ".webp", ".tga", ".bmp", ".tif", ".tiff", ".psd", ".avif", ".gif", ".ktx2")
#: how a slot's pixels are stored where the standard surface has no such slot: by its colour space
ROLES = {"srgb": "color", "normal": "normal", "linear": "data"}


def role_of(slot: str, space: str) -> str:
    """The role (importers.textures.encode.ROLES) of what lies in a slot."""
    from importers.loose_textures import SLOTS

    return SLOTS.get(slot, ROLES.get(space, "data"))


def write_texture(picture: Path, folder: Path, slot: str, space: str) -> Path:
    """Encode `picture` for a slot into `folder`; returns the .dds, one of its own where that name is another's.

    Raises InputError, FormatError, OutputError."""
    from engine.assets.dds import write_dds
    from importers.images.lone import read_pixels
    from importers.settings import ImportSettings
    from importers.textures.encode import encode

    settings = ImportSettings()
    texture = encode(read_pixels(picture, settings), role_of(slot, space), settings)
    stem, number = f"{picture.stem}.{slot.removesuffix('_map')}", 1
    while True:
        target = folder / (f"{stem}.dds" if number == 1 else f"{stem}.{number}.dds")
        if not target.exists():
            write_dds(target, texture)
            return target
        aside = folder / f".{target.name}.new.dds"
        write_dds(aside, texture)
        same = aside.read_bytes() == target.read_bytes()
        aside.unlink()
        if same:
            return target
        number += 1


@dataclass(slots=True)
class PictureTexture:
    """See editor.work.Work."""

    picture: Path
    materials: Sequence[int]
    slot: str
    space: str
    folder: Path
    title: str = "Making a texture"
    progress: float = -1.0
    text: str = ""
    _thread: threading.Thread | None = field(default=None, repr=False)
    _made: Path | None = field(default=None, repr=False)
    _error: LucarnaError | None = field(default=None, repr=False)

    def step(self, session: Session) -> bool:
        from editor import material_editing

        if self._thread is None:
            self.text = self.picture.name
            self._thread = threading.Thread(target=self._run, name="texture", daemon=True)
            self._thread.start()
        self._thread.join(0.005)
        if self._thread.is_alive():
            return True
        if self._error is not None:
            raise self._error
        if self._made is not None:
            material_editing.set_texture(session, self.materials, self.slot, self._made)
        return False

    def close(self) -> None:
        """The thread ends by itself; a file that it still writes is whole or not there."""

    def _run(self) -> None:
        try:
            self._made = write_texture(self.picture, self.folder, self.slot, self.space)
        except LucarnaError as error:
            self._error = error
        except OSError as error:
            self._error = InputError(error.strerror or str(error), where=error.filename or self.picture)
