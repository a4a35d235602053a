"""KTX2 textures: containers of plain and block-compressed images, zstd or zlib packed, and Basis Universal ones.

    header -> plain vkFormat       -> TextureAsset in our format (sizes checked; zstd by `zstandard`, zlib by Python)
           -> Basis (ETC1S, UASTC) -> `opengl_basisu` transcodes to RGBA8 (pixels) or BC7, BC5, BC4 (textures)

Source: KTX File Format 2.0 (Khronos, 2021), sections 3 and 4.
"""

from __future__ import annotations

import importlib.util
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.texture import FORMATS, TextureAsset, level_size, mip_extent
from engine.core.errors import FormatError, InputError, Place

MAGIC = b"\xabKTX 20\xbb\r\n\x1a\n"
MISSING = "install the transcoder: pip install 'lucarna[gltf]'"
_MISSING_ZSTD = "install the unpacker: pip install 'lucarna[gltf]'"
_NONE, _BASIS_LZ, _ZSTD, _ZLIB = 0, 1, 2, 3
MAX_EXTENT = 65536

#: VkFormat -> (our format, how the stored pixels become ours)
_FORMATS: dict[int, tuple[str, str]] = {
    9: ("r8", ""), 16: ("rg8", ""), 37: ("rgba8", ""), 43: ("rgba8-srgb", ""),
    23: ("rgba8", "rgb"), 29: ("rgba8-srgb", "rgb"), 44: ("rgba8", "bgra"), 50: ("rgba8-srgb", "bgra"),
    15: ("r8", ""), 22: ("rg8", ""),
    76: ("r16f", ""), 83: ("rg16f", ""), 97: ("rgba16f", ""), 90: ("rgba16f", "rgb16f"),
    100: ("r32f", ""), 103: ("rg32f", ""), 109: ("rgba32f", ""), 106: ("rgba32f", "rgb32f"),
    122: ("rgba16f", "b10g11r11"), 123: ("rgba16f", "e5b9g9r9"),
    131: ("bc1", ""), 132: ("bc1-srgb", ""), 133: ("bc1", ""), 134: ("bc1-srgb", ""), 137: ("bc3", ""),
    138: ("bc3-srgb", ""), 139: ("bc4", ""), 141: ("bc5", ""), 143: ("bc6h", ""), 145: ("bc7", ""),
    146: ("bc7-srgb", ""),
}  # fmt: skip
_STORED_BYTES = {"rgb": 3, "rgb16f": 6, "rgb32f": 12, "bgra": 4, "b10g11r11": 4, "e5b9g9r9": 4}


@dataclass(frozen=True, slots=True)
class Header:
    """What the first bytes say. `basis`: whether the images have to be transcoded."""

    vk_format: int
    width: int
    height: int
    depth: int
    layers: int
    faces: int
    levels: int
    scheme: int

    @property
    def basis(self) -> bool:
        return self.scheme == _BASIS_LZ or self.vk_format == 0

    @property
    def format_name(self) -> str:
        known = _FORMATS.get(self.vk_format)
        return "Basis Universal" if self.basis else known[0] if known else f"VkFormat {self.vk_format}"


def can_transcode() -> bool:
    """Whether the transcoder of Basis Universal images is installed."""
    return importlib.util.find_spec("opengl_basisu") is not None


def is_ktx2(data: bytes) -> bool:
    return bytes(data[:12]) == MAGIC


def read_header(data: bytes, place: str) -> Header:
    """Raises FormatError where the header is cut off or its numbers are not possible."""
    if len(data) < 80 or not is_ktx2(data):
        raise FormatError("is no KTX2 texture: its header is cut off", where=Place(place))
    vk, _type, width, height, depth, layers, faces, levels, scheme = struct.unpack_from("<9I", data, 12)
    header = Header(vk, width, max(height, 1), max(depth, 1), max(layers, 1), faces, max(levels, 1), scheme)
    extents = (header.width, header.height, header.depth)
    if min(extents) < 1 or max(extents) > MAX_EXTENT or faces not in (1, 6) or header.layers > 4096:
        raise FormatError(f"sizes {extents}, {layers} layers, {faces} faces are not possible", where=Place(place))
    if header.levels > max(extents).bit_length() or scheme > _ZLIB:
        raise FormatError(f"{levels} mips or supercompression {scheme} are not possible", where=Place(place))
    return header


def read_ktx2(data: bytes, place: str, max_bytes: int = 1 << 31) -> TextureAsset:
    """The texture in one of our formats, as it is stored. Raises FormatError; InputError where a library is missing.

    Basis Universal images become rgba8: what they are for is the material's word (see `encode`).
    """
    header = read_header(data, place)
    texels = header.width * header.height * header.depth * header.layers * header.faces
    if texels * 4 > max_bytes:
        raise FormatError(f"{texels:,} texels are more than the limit allows", where=Place(place))
    if header.basis:
        return _transcode(data, header, place)
    if header.vk_format not in _FORMATS:
        hint = "supported: BC1 to BC7, 8-bit, half and float R, RG, RGB, RGBA; Basis Universal (ETC1S, UASTC)"
        raise FormatError(f"VkFormat {header.vk_format} is not supported", where=Place(place), hint=hint)
    name, stored = _FORMATS[header.vk_format]
    images = header.layers * header.faces
    levels: list[list[bytes]] = [[] for _ in range(images)]
    for mip in range(header.levels):
        extent = [mip_extent(e, mip) for e in (header.width, header.height, header.depth)]
        texel_count = extent[0] * extent[1] * extent[2]
        size = texel_count * _STORED_BYTES[stored] if stored else level_size(name, *extent)
        body = _level(data, header, mip, size * images, place)
        for k in range(images):
            part = body[k * size : (k + 1) * size]
            levels[k].append(_converted(part, stored) if stored else part)
    kept: list[Sequence[bytes | memoryview]] = [list(images_of) for images_of in levels]
    return TextureAsset(name, header.width, header.height, kept, header.depth, header.faces == 6)


def _level(data: bytes, header: Header, mip: int, size: int, place: str) -> bytes:
    """The unpacked bytes of all images of one mip."""
    at = 80 + 24 * mip
    if at + 24 > len(data):
        raise FormatError("the level index is cut off", where=Place(place))
    offset, length, plain = struct.unpack_from("<3Q", data, at)
    if offset + length > len(data):
        raise FormatError(f"mip {mip} lies beyond the end of the file", where=Place(place), hint="copy it again")
    if plain not in (size, 0) and header.scheme != _NONE:
        raise FormatError(f"mip {mip} has {plain:,} bytes unpacked, its size asks for {size:,}", where=Place(place))
    body = data[offset : offset + length]
    if header.scheme == _ZLIB:
        try:
            body = zlib.decompressobj().decompress(body, size + 1)
        except zlib.error as error:
            raise FormatError(f"mip {mip} cannot be unpacked: {error}", where=Place(place)) from error
    elif header.scheme == _ZSTD:
        body = _unzstd(body, size, mip, place)
    if len(body) < size or (header.scheme != _NONE and len(body) != size):
        raise FormatError(f"mip {mip} has {len(body):,} bytes, its size asks for {size:,}", where=Place(place))
    return bytes(body[:size])


def _unzstd(body: bytes, size: int, mip: int, place: str) -> bytes:
    try:
        import zstandard
    except ImportError as error:
        raise InputError("is packed by zstd", where=Place(place), hint=_MISSING_ZSTD) from error
    try:
        return bytes(zstandard.ZstdDecompressor().decompress(body, max_output_size=size, allow_extra_data=False))
    except zstandard.ZstdError as error:
        raise FormatError(f"mip {mip} cannot be unpacked: {error}", where=Place(place)) from error


def _transcode(data: bytes, header: Header, place: str) -> TextureAsset:
    try:
        import opengl_basisu
    except ImportError as error:
        raise InputError("is compressed by Basis Universal", where=Place(place), hint=MISSING) from error
    try:
        texture = opengl_basisu.open(bytes(data))
        levels: list[Sequence[bytes | memoryview]] = [
            [image.data.tobytes() for image in texture.transcode_levels("rgba8", face, layer)]
            for layer in range(texture.layers)
            for face in range(texture.faces)
        ]
    except (opengl_basisu.BasisuError, ValueError, IndexError, RuntimeError) as error:
        raise FormatError(f"the Basis Universal data is damaged: {error}", where=Place(place)) from error
    name = "rgba8-srgb" if texture.srgb else "rgba8"
    return TextureAsset(name, texture.width, texture.height, levels, 1, header.faces == 6)


def _converted(image: bytes, stored: str) -> bytes:
    """What has no format of ours, as rgba8, rgba16f or rgba32f."""
    if stored in ("rgb", "rgb16f", "rgb32f"):
        dtype, one = {"rgb": ("u1", 255), "rgb16f": ("<f2", 1), "rgb32f": ("<f4", 1)}[stored]
        rgb: NDArray[Any] = np.frombuffer(image, dtype).reshape(-1, 3)
        out: NDArray[Any] = np.full((len(rgb), 4), one, rgb.dtype)
        out[:, :3] = rgb
        return out.tobytes()
    if stored == "bgra":
        return np.frombuffer(image, np.uint8).reshape(-1, 4)[:, [2, 1, 0, 3]].tobytes()
    words = np.frombuffer(image, "<u4")
    out = np.ones((len(words), 4), "<f4")
    if stored == "e5b9g9r9":
        scale = np.ldexp(1.0, (words >> 27).astype(np.int32) - 24)
        for k in range(3):
            out[:, k] = (words >> np.uint32(9 * k) & 511) * scale
    else:
        for k, (shift, bits) in enumerate(((0, 6), (11, 6), (22, 5))):
            out[:, k] = _small_float(words >> np.uint32(shift) & np.uint32((1 << (5 + bits)) - 1), bits)
    packed: bytes = np.minimum(out, 65504.0).astype("<f2").tobytes()
    return packed


def _small_float(value: NDArray[np.uint32], mantissa: int) -> NDArray[np.float64]:
    """Unsigned floats of 5 bits of exponent (bias 15)."""
    m = (value & np.uint32((1 << mantissa) - 1)).astype(np.float64) / (1 << mantissa)
    e = (value >> np.uint32(mantissa)).astype(np.int32)
    return np.where(e == 0, np.ldexp(m, -14), np.where(e == 31, 65504.0, np.ldexp(1.0 + m, e - 15)))


assert all(name in FORMATS for name, _ in _FORMATS.values())
