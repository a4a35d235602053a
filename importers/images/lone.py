"""Files of one group -> TextureAsset. What has GPU blocks already stays as it is; all else is encoded by role."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.texture import TextureAsset
from engine.core.errors import FormatError, InputError
from importers.gltf.uris import read_regular_file
from importers.images.grouping import Group
from importers.settings import ImportSettings
from importers.textures.cube import from_equirect
from importers.textures.encode import encode
from importers.textures.image import decode, stored_texture
from importers.textures.pixels import rgba_pixels

Pixels = NDArray[Any]


def build(group: Group, role: str, flip: bool, settings: ImportSettings) -> TextureAsset:
    """The texture of a picture, cube or array. Raises InputError, FormatError."""
    own = settings.replace(flip_green=flip)
    if len(group.files) == 1 and group.kind == "2d":
        data = read_regular_file(group.files[0], own.max_file_bytes)
        texture = stored_texture(data, str(group.files[0]), own)
        if texture is not None:
            return _stored(texture, role, own)
    images = [read_pixels(file, own) for file in group.files]
    if group.kind == "cube" and len(images) == 1:
        images = list(_unrolled(images[0]))
    return layered([encode(image, _role(role, image), own, wrap=group.kind == "2d") for image in images], group)


def read_pixels(file: Path, settings: ImportSettings) -> Pixels:
    """The image's pixels, upright. Raises InputError."""
    return decode(read_regular_file(file, settings.max_file_bytes), str(file), settings, upright=True)


def unreadable(files: Sequence[Path], settings: ImportSettings) -> Iterator[tuple[Path, InputError]]:
    """Those of `files` that hold no sound image, and why."""
    for file in files:
        try:
            data = read_regular_file(file, settings.max_file_bytes)
            if stored_texture(data, str(file), settings) is None:
                decode(data, str(file), settings)
        except InputError as error:
            yield file, error


def layered(parts: Sequence[TextureAsset], group: Group) -> TextureAsset:
    """One texture of one-layer textures of equal size. Raises FormatError."""
    first = parts[0]
    for part, file in zip(parts, (*group.files, *[group.files[0]] * 6), strict=False):
        if (part.width, part.height, part.format) != (first.width, first.height, first.format):
            raise FormatError(
                f"is {part.width}x{part.height} {part.format}, {group.files[0].name} is {first.width}x{first.height} "
                f"{first.format}", where=file, hint="all layers need one size and kind",
            )  # fmt: skip
    if group.kind == "cube" and first.width != first.height:
        raise FormatError(f"faces of {first.width}x{first.height}", where=group.files[0], hint="faces must be square")
    return replace(first, levels=[part.levels[0] for part in parts], cube=group.kind == "cube")


def _role(role: str, pixels: Pixels) -> str:
    return "hdr" if pixels.dtype.kind == "f" and role == "color" else role


def _unrolled(image: Pixels) -> Pixels:
    """Faces [6,n,n,c] of a panorama, in its own kind of numbers; colours are averaged in linear light."""
    size = max(4, 1 << (image.shape[0] // 2).bit_length() - 1)
    if image.dtype.kind == "f":
        return from_equirect(image, size)
    from engine.math.color import srgb_to_linear, to_u1

    top = float(np.iinfo(image.dtype).max)
    faces = from_equirect(srgb_to_linear(image[..., :3] / top).astype(np.float32), size)
    out = np.full((*faces.shape[:3], 4), 255, np.uint8)
    out[..., :3] = to_u1(faces)
    return out


def _stored(texture: TextureAsset, role: str, settings: ImportSettings) -> TextureAsset:
    """A texture out of a container: plain 8-bit pixels are encoded, all else stays; too large mips are dropped."""
    if settings.compress and texture.format in ("rgba8", "rgba8-srgb") and texture.depth == 1:
        parts = [
            encode(np.ascontiguousarray(rgba_pixels(texture, layer)), role, settings, wrap=not texture.cube)
            for layer in range(texture.layers)
        ]
        return replace(parts[0], levels=[part.levels[0] for part in parts], cube=texture.cube)
    drop = 0
    while settings.max_texture_size and max(texture.width, texture.height) >> drop > settings.max_texture_size:
        drop += 1
    drop = min(drop, texture.mip_count - 1)
    if not drop:
        return texture
    width, height, depth = (max(1, e >> drop) for e in (texture.width, texture.height, texture.depth))
    levels = [list(layer)[drop:] for layer in texture.levels]
    return replace(texture, width=width, height=height, depth=depth, levels=list(levels))
