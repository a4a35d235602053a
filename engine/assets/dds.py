"""`.dds`: textures in their GPU format, with all mips, faces, layers and slices; mapped, not copied.

Written: always with the DX10 header, then the images in file order (layer by layer, each from mip 0 down), then, where
`extras` is not empty, a trailer that other readers ignore: `LCRN` | u4 length | JSON of the extras.

Read: the same; and legacy headers: DXT1..5, ATI1/2, BC4U/BC5U, D3DFMT float codes, RGB(A) masks, luminance, cubes,
volumes. What no GPU format of ours matches exactly (24-bit RGB, BGRA, 565, DXT3 …) is converted (dds_legacy.py;
16-bit, signed and packed floats to half or single floats: dds_wide.py).
Every count is checked against the size of the file before it is used.

Format: "DDS file layout" and "DDS_HEADER_DXT10", Microsoft Learn.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from engine.assets.container import compact_json
from engine.assets.dds_legacy import Pixels, convert, legacy_pixels
from engine.assets.mapping import map_file
from engine.assets.texture import FORMATS, TextureAsset, level_size, mip_extent
from engine.core.atomic import atomic_path
from engine.core.errors import FormatError, Place

MAGIC = b"DDS "
MAX_EXTENT = 65536
MAX_TRAILER = 16 << 20

#: our format -> DXGI_FORMAT
DXGI = {
    "r8": 61, "rg8": 49, "rgba8": 28, "rgba8-srgb": 29,
    "r16f": 54, "rg16f": 34, "rgba16f": 10, "r32f": 41, "rg32f": 16, "rgba32f": 2,
    "bc1": 71, "bc1-srgb": 72, "bc3": 77, "bc3-srgb": 78, "bc4": 80, "bc5": 83, "bc6h": 95, "bc7": 98, "bc7-srgb": 99,
}  # fmt: skip
#: DXGI_FORMAT -> how its pixels are kept; typeless ones as unorm
_READ: dict[int, Pixels] = {code: Pixels(name) for name, code in DXGI.items()}
_READ |= {
    code: Pixels(name)
    for code, name in (
        (1, "rgba32f"), (9, "rgba16f"), (15, "rg32f"), (27, "rgba8"), (33, "rg16f"), (39, "r32f"), (48, "rg8"),
        (60, "r8"), (70, "bc1"), (76, "bc3"), (79, "bc4"), (82, "bc5"), (94, "bc6h"), (97, "bc7"),
    )
}  # fmt: skip
_READ |= {
    73: Pixels("rgba8", "bc2"), 74: Pixels("rgba8", "bc2"), 75: Pixels("rgba8-srgb", "bc2"),
    85: Pixels("rgba8", "mask", 16, (0xF800, 0x07E0, 0x001F, 0)),
    86: Pixels("rgba8", "mask", 16, (0x7C00, 0x03E0, 0x001F, 0x8000)),
    115: Pixels("rgba8", "mask", 16, (0x0F00, 0x00F0, 0x000F, 0xF000)),
    87: Pixels("rgba8", "mask", 32, (0xFF0000, 0xFF00, 0xFF, 0xFF000000)),
    88: Pixels("rgba8", "mask", 32, (0xFF0000, 0xFF00, 0xFF, 0)),
    90: Pixels("rgba8", "mask", 32, (0xFF0000, 0xFF00, 0xFF, 0xFF000000)),
    91: Pixels("rgba8-srgb", "mask", 32, (0xFF0000, 0xFF00, 0xFF, 0xFF000000)),
    92: Pixels("rgba8", "mask", 32, (0xFF0000, 0xFF00, 0xFF, 0)),
    93: Pixels("rgba8-srgb", "mask", 32, (0xFF0000, 0xFF00, 0xFF, 0)),
    65: Pixels("rgba8", "mask", 8, (0, 0, 0, 0xFF)),
    6: Pixels("rgba32f", "rgb32f"), 11: Pixels("rgba16f", "unorm16"), 13: Pixels("rgba16f", "snorm16"),
    24: Pixels("rgba16f", "wide-mask", 32, (0x3FF, 0xFFC00, 0x3FF00000, 0xC0000000)),
    26: Pixels("rgba16f", "r11g11b10f"), 31: Pixels("rgba16f", "snorm8"), 35: Pixels("rg16f", "unorm16"),
    37: Pixels("rg16f", "snorm16"), 51: Pixels("rg16f", "snorm8"), 56: Pixels("r32f", "unorm16"),
    58: Pixels("r32f", "snorm16"), 63: Pixels("r16f", "snorm8"), 67: Pixels("rgba16f", "rgb9e5"),
    81: Pixels("r16f", "bc4s"), 84: Pixels("rg16f", "bc5s"),
}  # fmt: skip

_ALPHA_MODES = ("unknown", "straight", "premultiplied", "opaque", "custom")
_DX10 = b"DX10"
_FOURCC = 0x4
_CUBE, _VOLUME, _ALL_FACES = 0x200, 0x200000, 0xFC00


def read_dds(path: Path) -> TextureAsset:
    """The texture; its levels are views of the mapped file (copies only where pixels had to be converted).

    Raises InputError when it cannot be read, FormatError when it breaks the format or has a format that we lack.
    """
    return parse_dds(map_file(path), str(path))


def parse_dds(data: memoryview, file: str) -> TextureAsset:
    """The same from memory; `file` names it in messages."""

    def fail(message: str, field: str = "", hint: str = "") -> FormatError:
        return FormatError(message, where=Place(file, path=field), hint=hint)

    if len(data) < 128 or bytes(data[:4]) != MAGIC:
        raise fail("is no DDS file: it does not start with a DDS header")
    header = struct.unpack("<31I", data[4:128])
    height, width, depth, mips = header[2], header[3], header[5], header[6]
    fourcc_flags, fourcc = header[19], bytes(data[84:88])
    caps2 = header[27]
    if header[0] != 124 or header[18] != 32:
        raise fail(f"header sizes {header[0]} and {header[18]}, expected 124 and 32")
    start, layers, cube, volume = 128, 1, bool(caps2 & _CUBE), bool(caps2 & _VOLUME)
    extras: dict[str, object] = {}
    if fourcc_flags & _FOURCC and fourcc == _DX10:
        if len(data) < 148:
            raise fail("ends inside the DX10 header")
        dxgi, dimension, misc, layers, misc2 = struct.unpack("<5I", data[128:148])
        start, cube, volume = 148, bool(misc & 4), dimension == 4
        if dimension not in (2, 3, 4):
            raise fail(f"resource dimension {dimension} is none of 2, 3, 4", "resourceDimension")
        if dxgi not in _READ:
            raise fail(f"DXGI format {dxgi} is not supported", "dxgiFormat", _supported())
        pixels = _READ[dxgi]
        if dimension == 2:
            height = 1
        if misc2 & 7 and misc2 & 7 < len(_ALPHA_MODES):
            extras["alpha_mode"] = _ALPHA_MODES[misc2 & 7]
    else:
        legacy = legacy_pixels(fourcc_flags, fourcc, header[21], header[22:26])
        if legacy is None:
            raise fail(
                f"pixel format (flags {fourcc_flags:#x}, code {fourcc!r}, {header[21]} bits) is not supported",
                "ddspf",
                _supported(),
            )
        pixels = legacy
        if cube and caps2 & _ALL_FACES != _ALL_FACES:
            raise fail("the cube map lacks faces", "dwCaps2", "store all six")
    depth = depth if volume else 1
    mips = max(1, mips)
    for name, extent in (("width", width), ("height", height), ("depth", depth)):
        if not 1 <= extent <= MAX_EXTENT:
            raise fail(f"{name} {extent} is outside 1..{MAX_EXTENT}", name)
    if mips > max(width, height, depth).bit_length():
        raise fail(f"{mips} mip levels are more than {width}x{height}x{depth} has", "dwMipMapCount")
    if layers < 1 or (volume and (layers > 1 or cube)):
        raise fail(f"array size {layers} is not possible here", "arraySize")
    layers *= 6 if cube else 1

    extents = [(mip_extent(width, m), mip_extent(height, m), mip_extent(depth, m)) for m in range(mips)]
    sizes = [pixels.stored_size(*extent) for extent in extents]
    need = start + layers * sum(sizes)
    if need > len(data):
        raise fail(
            f"{width}x{height}x{depth} {pixels.stored_name}, {mips} mips, {layers} layers need {need} bytes; "
            f"the file has {len(data)}"
        )
    if pixels.note:
        extras["stored"] = pixels.note
    trailer = _trailer(data, need, file)
    levels: list[Sequence[bytes | memoryview]] = []
    at = start
    for _ in range(layers):
        images: list[bytes | memoryview] = []
        for (w, h, d), size in zip(extents, sizes, strict=True):
            images.append(convert(pixels, data[at : at + size], w, h, d))
            at += size
        levels.append(images)
    name = file.replace("\\", "/").rsplit("/", 1)[-1].removesuffix(".dds")
    return TextureAsset(pixels.format, width, height, levels, depth, cube, name, {**extras, **trailer})


def write_dds(path: Path, texture: TextureAsset) -> None:
    """Write `texture` with a DX10 header, atomically; the same texture gives the same bytes.

    Raises FormatError when its levels do not have the sizes its description asks for, OutputError.
    """
    check_texture(texture, str(path))
    block, size = FORMATS[texture.format]
    volume = texture.depth > 1
    flags = 0x1007 | (0x20000 if texture.mip_count > 1 else 0) | (0x80000 if block > 1 else 0x8)
    pitch = level_size(texture.format, texture.width, texture.height) if block > 1 else texture.width * size
    caps = 0x1000 | (0x400000 | 0x8 if texture.mip_count > 1 else 0) | (0x8 if texture.cube or volume else 0)
    header = [0] * 31
    header[0:7] = [124, flags | (0x800000 if volume else 0), texture.height, texture.width, pitch, 0, texture.mip_count]
    header[5] = texture.depth if volume else 0
    header[18:21] = [32, _FOURCC, int.from_bytes(_DX10, "little")]
    header[26:28] = [caps, (_CUBE | _ALL_FACES if texture.cube else 0) | (_VOLUME if volume else 0)]
    arrays = texture.layers // 6 if texture.cube else texture.layers
    alpha = texture.extras.get("alpha_mode")
    alpha_mode = _ALPHA_MODES.index(alpha) if isinstance(alpha, str) and alpha in _ALPHA_MODES else 0
    dx10 = (DXGI[texture.format], 4 if volume else 3, 4 if texture.cube else 0, arrays, alpha_mode)
    kept = {k: v for k, v in texture.extras.items() if k != "stored" and not (k == "alpha_mode" and alpha_mode)}
    with atomic_path(Path(path)) as temporary, temporary.open("wb") as file:
        file.write(MAGIC + struct.pack("<31I", *header) + struct.pack("<5I", *dx10))
        for layer in texture.levels:
            for image in layer:
                file.write(image)
        if kept:
            text = compact_json(kept).encode("utf-8")
            file.write(b"LCRN" + struct.pack("<I", len(text)) + text)


def check_texture(texture: TextureAsset, file: str = "") -> None:
    """Raise FormatError when the parts of `texture` do not fit together."""

    def fail(message: str) -> FormatError:
        return FormatError(message, where=file or texture.name or "texture")

    if texture.format not in DXGI:
        raise fail(f"format {texture.format!r} cannot be stored; known: {', '.join(DXGI)}")
    extents = (texture.width, texture.height, texture.depth)
    if min(extents) < 1 or max(extents) > MAX_EXTENT or not texture.levels or not texture.levels[0]:
        raise fail(f"has extent {extents} and {texture.layers} layers; both must be at least 1")
    if texture.cube and (texture.layers % 6 or texture.width != texture.height):
        raise fail("a cube needs square faces and a multiple of 6 layers")
    if texture.depth > 1 and texture.layers > 1:
        raise fail("a volume cannot be an array")
    if texture.mip_count > max(extents).bit_length():
        raise fail(f"{texture.mip_count} mip levels are too many for {extents}")
    for index, layer in enumerate(texture.levels):
        if len(layer) != texture.mip_count:
            raise fail(f"layer {index} has {len(layer)} mips, layer 0 has {texture.mip_count}")
        for mip, image in enumerate(layer):
            want = level_size(texture.format, *(mip_extent(e, mip) for e in extents))
            got = memoryview(image).nbytes
            if got != want:
                raise fail(f"layer {index} mip {mip} has {got} bytes, {texture.format} needs {want}")


def _trailer(data: memoryview, at: int, file: str) -> dict[str, Any]:
    if bytes(data[at : at + 4]) != b"LCRN" or len(data) < at + 8:
        return {}
    (length,) = struct.unpack("<I", data[at + 4 : at + 8])
    if length > MAX_TRAILER or at + 8 + length > len(data):
        raise FormatError(f"the trailer claims {length} bytes, {len(data) - at - 8} are there", where=file)
    try:
        extras = json.loads(bytes(data[at + 8 : at + 8 + length]))
    except (ValueError, RecursionError) as error:
        raise FormatError(f"the trailer is not JSON: {error}", where=file) from error
    if not isinstance(extras, dict):
        raise FormatError("the trailer is no JSON object", where=file)
    return extras


def _supported() -> str:
    return "supported: BC1-BC7 (BC6H unsigned), 8 and 16-bit R, RG, RGBA, signed or not, 10:10:10:2, half and float"
