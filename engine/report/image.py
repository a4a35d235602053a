"""Image files: PNG (8 bit) and OpenEXR (half or float). Row 0 is the top. Written atomically, no times in them.

The same pixels and metadata give the same bytes. Pillow and OpenEXR are imported when first used.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.atomic import atomic_path
from engine.core.errors import FormatError, InputError, OutputError

#: Larger images are refused: a picture of this many pixels takes over a gigabyte as float RGBA.
MAX_PIXELS = 1 << 27


def save_png(path: Path, pixels: ArrayLike, metadata: Mapping[str, str] | None = None) -> None:
    """Write u1 `pixels` [h,w], [h,w,3] or [h,w,4] (sRGB, straight alpha) with `metadata` as text chunks, sorted.

    Raises InputError for another shape or dtype, OutputError when it cannot be written.
    """
    from PIL import Image, PngImagePlugin

    array = np.asarray(pixels)
    if array.dtype != np.uint8:
        raise InputError(f"PNG pixels must be uint8, got {array.dtype}", where=path, hint="encode with color.to_u1")
    _check_shape(array, path, channels=(1, 3, 4))
    info = PngImagePlugin.PngInfo()
    for key, value in sorted((metadata or {}).items()):
        info.add_itxt(key, value)
    image = Image.fromarray(np.ascontiguousarray(array))
    with atomic_path(Path(path)) as temporary:
        image.save(temporary, format="PNG", compress_level=6, pnginfo=info)


def load_png(path: Path) -> NDArray[np.uint8]:
    """Return u1[h,w,3] or u1[h,w,4] of a PNG (grey and palettes are expanded). Raises InputError, FormatError."""
    from PIL import Image

    try:
        with Image.open(path, formats=["PNG"]) as image:
            if image.width * image.height > MAX_PIXELS:
                raise FormatError(f"image too large: {image.width} x {image.height}", where=path)
            alpha = "A" in image.getbands() or "transparency" in image.info
            return np.asarray(image.convert("RGBA" if alpha else "RGB"), np.uint8).copy()
    except FileNotFoundError as error:
        raise InputError("no such file", where=path) from error
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise FormatError(f"not a readable PNG: {error}", where=path) from error


def png_metadata(path: Path) -> dict[str, str]:
    """Return the text chunks of a PNG. Raises InputError, FormatError."""
    from PIL import Image

    try:
        with Image.open(path, formats=["PNG"]) as image:
            image.load()
            return {str(key): str(value) for key, value in getattr(image, "text", {}).items()}
    except FileNotFoundError as error:
        raise InputError("no such file", where=path) from error
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise FormatError(f"not a readable PNG: {error}", where=path) from error


def save_exr(path: Path, pixels: ArrayLike, metadata: Mapping[str, str] | None = None, *, half: bool = True) -> None:
    """Write scene-linear `pixels` [h,w,3|4] as RGB(A), half by default (beyond 65504 clamped), ZIP compressed.

    `metadata` becomes string attributes named `lucarna.<key>`. Raises InputError for another shape, OutputError.
    """
    import OpenEXR

    array = np.asarray(pixels, np.float32)
    _check_shape(array, path, channels=(3, 4))
    if half:
        array = np.clip(array, -65504.0, 65504.0).astype(np.float16)
    header: dict[str, object] = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    header.update({f"lucarna.{key}": value for key, value in sorted((metadata or {}).items())})
    name = "RGBA" if array.shape[2] == 4 else "RGB"
    with atomic_path(Path(path)) as temporary:
        try:
            with OpenEXR.File(header, {name: np.ascontiguousarray(array)}) as file:
                file.write(str(temporary))
        except RuntimeError as error:
            raise OutputError(f"cannot write OpenEXR: {error}", where=path) from error


def load_exr(path: Path) -> NDArray[np.float32]:
    """Return f4[h,w,3|4] of an OpenEXR file with R, G, B (A) or Y channels. Raises InputError, FormatError."""
    import OpenEXR

    path = Path(path)
    if not path.is_file():
        raise InputError("no such file", where=path)
    try:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: np.asarray(channel.pixels, np.float32) for name, channel in file.channels().items()}
    except (RuntimeError, ValueError, TypeError) as error:
        raise FormatError(f"not a readable OpenEXR image: {error}", where=path) from error
    names = ["R", "G", "B"] if "R" in channels else ["Y", "Y", "Y"]
    missing = sorted({n for n in names if n not in channels})
    if missing:
        raise FormatError(
            f"no channel {', '.join(missing)}; it has {', '.join(sorted(channels)) or 'none'}",
            where=path, hint="save it as RGB, RGBA or luminance",
        )  # fmt: skip
    if "A" in channels:
        names.append("A")
    return np.stack([channels[n] for n in names], axis=-1)


def _check_shape(array: NDArray[np.generic], path: Path, channels: tuple[int, ...]) -> None:
    count = 1 if array.ndim == 2 else array.shape[2] if array.ndim == 3 else 0
    if count not in channels or array.size == 0:
        wanted = " or ".join("[h,w]" if c == 1 else f"[h,w,{c}]" for c in channels)
        raise InputError(f"an image must have shape {wanted}, got {array.shape}", where=path)
    if array.shape[0] * array.shape[1] > MAX_PIXELS:
        raise InputError(f"image too large: {array.shape[1]} x {array.shape[0]}", where=path)
