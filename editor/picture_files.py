"""Image files for the texture viewer, read in a thread: the window goes on.

get(path) ──► thread: .dds as it is stored, all else decoded ──► PictureFile       a new answer wakes the window
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from editor.texture_view import as_float
from editor.waking import wake
from engine.assets.texture import TextureAsset
from engine.core.errors import LucarnaError


@dataclass(frozen=True, slots=True)
class PictureFile:
    """One of: `asset`, what is stored in GPU formats; `pixels` f4[h,w,c] of any other image; `problem`, why it cannot
    be read. `srgb`: colours for the eye, stored with the sRGB curve. `depth`: bits a channel, of `pixels`."""

    path: Path
    stamp: int = 0
    asset: TextureAsset | None = None
    pixels: Any = None
    srgb: bool = False
    bits: int = 8
    problem: str = ""


class PictureFiles:
    """The file that was asked for last."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._wanted: tuple[Path, int] | None = None
        self._found: PictureFile | None = None

    def get(self, path: Path) -> PictureFile | None:
        """What is in the file, as it is on disk now; None while it is being read."""
        try:
            stamp = path.stat().st_mtime_ns
        except OSError as error:
            return PictureFile(path, problem=str(error))
        with self._lock:
            if self._found is not None and (self._found.path, self._found.stamp) == (path, stamp):
                return self._found
            if self._wanted != (path, stamp):
                self._wanted = (path, stamp)
                threading.Thread(target=self._read, args=(path, stamp), daemon=True, name="picture").start()
        return None

    def _read(self, path: Path, stamp: int) -> None:
        try:
            found = read_picture(path, stamp)
        except (LucarnaError, OSError, ValueError, MemoryError) as error:
            found = PictureFile(path, stamp, problem=str(error))
        with self._lock:
            if self._wanted == (path, stamp):
                self._found = found
        wake()


def read_picture(path: Path, stamp: int = 0) -> PictureFile:
    """The image file. Raises LucarnaError where it is none."""
    from importers.settings import ImportSettings
    from importers.texture_names import read_name
    from importers.textures.image import decode

    if path.suffix.lower() == ".dds":
        from engine.assets.dds import read_dds

        asset = read_dds(path)
        return PictureFile(path, stamp, asset=asset, srgb=asset.format.endswith("-srgb"))
    pixels = decode(path.read_bytes(), str(path), ImportSettings(), upright=True)
    color = read_name(path.stem).role in ("", "color", "emissive")
    return PictureFile(
        path,
        stamp,
        pixels=as_float(pixels),
        srgb=pixels.dtype.kind == "u" and color,
        bits=8 * np.dtype(pixels.dtype).itemsize,
    )
