"""BCn encoding with ispc_texcomp: surfaces padded and packed as each encoder wants them, rows split over threads.

ispc reads BC4 as tight R8, BC5 as tight RG8 and BC6H as RGBA16F, whatever its documentation says, and sizes that are
no multiple of 4 come out short: so everything goes through `encode_blocks`. Blocks are independent, so the number of
threads never changes a byte.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, cast

import ispc_texcomp
import numpy as np
from numpy.typing import NDArray

from engine.assets.texture import FORMATS

#: input channels and dtype of each encoder
_INPUT = {"bc4": (1, "u1"), "bc5": (2, "u1"), "bc6h": (4, "<f2"), "bc7": (4, "u1")}

#: images below this many texels are not worth a second thread
_SPLIT_TEXELS = 128 * 128


def encode_blocks(pixels: NDArray[Any], format: str, profile: str, threads: int = 0) -> bytes:
    """The blocks of one image. `pixels` [h,w,c]: c and dtype as the format's encoder takes them (BC5: u1[h,w,2]).

    `profile`: ultrafast | veryfast | fast | basic | slow, with `alpha_` before it for BC7 with alpha (BC6H has no
    ultrafast); `threads` 0 = one per CPU.
    """
    base = format.removesuffix("-srgb")
    channels, dtype = _INPUT[base]
    assert pixels.shape[2] == channels, (pixels.shape, format)
    assert pixels.dtype == np.dtype(dtype), (pixels.dtype, format)
    padded = pad_to_blocks(pixels)
    height, width = padded.shape[:2]
    run = _encoder(base, profile)
    threads = threads or os.cpu_count() or 1
    if threads == 1 or height * width < _SPLIT_TEXELS or height < 8:
        return _checked(run(padded), base, width, height)
    # More strips than threads: some parts of an image take longer than others.
    rows = max(4, -(-height // (threads * 4)) + 3 & ~3)
    strips = [padded[y : y + rows] for y in range(0, height, rows)]
    with ThreadPoolExecutor(threads) as pool:
        return _checked(b"".join(pool.map(run, strips)), base, width, height)


def pad_to_blocks(pixels: NDArray[Any]) -> NDArray[Any]:
    """`pixels` C-contiguous with both sizes rounded up to multiples of 4 by repeating the last row and column."""
    height, width = pixels.shape[:2]
    if height % 4 or width % 4:
        pixels = np.pad(pixels, ((0, -height % 4), (0, -width % 4), (0, 0)), mode="edge")
    return np.ascontiguousarray(pixels)


def _encoder(base: str, profile: str) -> Callable[[NDArray[Any]], bytes]:
    settings: Any = None
    if base == "bc7":
        settings = ispc_texcomp.BC7EncSettings.from_profile(cast("Any", profile))
    elif base == "bc6h":
        settings = ispc_texcomp.BC6HEncSettings.from_profile(cast("Any", profile))
    compress = getattr(ispc_texcomp, f"compress_blocks_{base}")

    def run(strip: NDArray[Any]) -> bytes:
        height, width = strip.shape[:2]
        surface = ispc_texcomp.RGBASurface(strip.tobytes(), width, height, strip.strides[0])
        return bytes(compress(surface, settings) if settings is not None else compress(surface))

    return run


def _checked(data: bytes, base: str, width: int, height: int) -> bytes:
    want = width * height // 16 * FORMATS[base][1]
    if len(data) != want:  # the encoder's own fault, never the input's: better loud than a garbled texture
        raise AssertionError(f"{base} encoder gave {len(data)} bytes for {width}x{height}, expected {want}")
    return data
